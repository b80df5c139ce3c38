"""Samples that stand alone: spikes go before a fit, the corners of a motion stay."""

from __future__ import annotations

import numpy as np
import pytest

from testbed.arrays import Array
from testbed.diagnosis.windows import outliers_notice
from testbed.estimation.outliers import BY_CHANCE, gross_outliers, outliers

NOISE, PERIOD = 8e-6, 0.1  # rad/s, s: a fibre-optic gyro of 0.009 deg/sqrt(h)
TIME = PERIOD * np.arange(400)


def slew(seed: int) -> Array:
    """Rates along straight lines from corner to corner, with the gyro's noise, shape (400, 3), rad/s."""
    rng = np.random.default_rng(seed)
    at = np.concatenate([[0.0], np.cumsum(rng.uniform(4.0, 8.0, 10))])
    rates = [np.interp(TIME, at, values) for values in rng.uniform(-0.05, 0.05, (3, len(at)))]
    return np.stack(rates, axis=1) + NOISE * rng.standard_normal((len(TIME), 3))


@pytest.mark.parametrize("seed", range(5))
def test_corners_of_a_slew_are_no_spikes(seed):
    assert not gross_outliers(slew(seed), NOISE).any()


@pytest.mark.parametrize("size", [2e-3, -0.5])
@pytest.mark.parametrize("place", [0, 2, 57, 200, 399])
def test_a_spike_is_found_by_itself(place, size):
    samples = slew(1)
    samples[place, 1] += size
    found = gross_outliers(samples, NOISE)
    assert np.argwhere(found).tolist() == [[place, 1]]


def test_as_many_as_noise_makes_are_said_to_be_so():
    """Of 7,200 samples with three axes 0.4 lie so by noise alone, four by none."""
    assert outliers_notice(1, 7200).endswith("left out, as noise alone makes of so many")
    for few in (outliers_notice(4, 7200), outliers_notice(1, 100), outliers_notice(1)):
        assert few.endswith("left out")


def test_the_share_that_noise_makes_is_as_stated():
    values = np.random.default_rng(81).normal(size=(400_000, 3))
    share = np.any(outliers(values, 1.0), axis=1).mean()
    assert share == pytest.approx(BY_CHANCE, rel=0.5)  # 24 of them
