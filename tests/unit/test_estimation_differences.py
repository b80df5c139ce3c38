"""White noise from differences: what they take out, and what they leave of it."""

import numpy as np
import pytest

from testbed.estimation.differences import (
    correlated_share,
    divided_differences,
    median_std,
    median_variance,
    squared_differences,
)

SIGMA = 0.3


@pytest.mark.parametrize("order", [4, 8])
def test_polynomials_below_the_order_leave_nothing(order):
    time = np.sort(np.random.default_rng(1).uniform(0.0, 1.0, 40))
    powers = np.arange(order)
    even = np.linspace(0.0, 1.0, 40)[:, None] ** powers
    np.testing.assert_allclose(squared_differences(even, order), 0.0, atol=1e-24)
    np.testing.assert_allclose(divided_differences(time, time[:, None] ** powers, order), 0.0, atol=1e-9)


@pytest.mark.parametrize("order", [4, 8])
def test_white_noise_keeps_its_variance(order):
    noise = np.random.default_rng(2).normal(0.0, SIGMA, (100_000, 2))
    uneven = np.cumsum(np.random.default_rng(3).uniform(0.5, 1.5, len(noise)))
    spread = 6.0 * np.sqrt(2.0 * correlated_share(order) / len(noise))  # of a mean of overlapping squares
    np.testing.assert_allclose(squared_differences(noise, order).mean(axis=0), SIGMA**2, rtol=spread)
    np.testing.assert_allclose(median_variance(noise, order), SIGMA**2, rtol=2.0 * spread)  # a median is less sure
    np.testing.assert_allclose(median_std(divided_differences(uneven, noise, order)), SIGMA, rtol=spread)


def test_the_median_bears_outliers_that_the_mean_does_not():
    rng = np.random.default_rng(4)
    noise = rng.normal(0.0, SIGMA, (20_000, 1))
    noise[rng.choice(len(noise), len(noise) // 200, replace=False)] += 100.0  # each spoils five differences
    assert 1.0 < float(median_variance(noise, 4)[0]) / SIGMA**2 < 1.1
    assert float(squared_differences(noise, 4).mean()) / SIGMA**2 > 100.0
