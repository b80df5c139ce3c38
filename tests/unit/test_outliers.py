"""Samples that stand alone: spikes go before a fit, the corners of a motion stay."""

from __future__ import annotations

import numpy as np
import pytest

from testbed.arrays import Array
from testbed.estimation.outliers import gross_outliers

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
