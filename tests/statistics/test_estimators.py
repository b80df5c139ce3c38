"""Bias, scatter and coverage over seeds; `python -m benchmarks.estimators` prints the same over 1,000.

Tolerances follow from the number of seeds S: a mean within 3.5 of its standard errors (18 means a flight, all at once
in 99 % of seeds' choices), a standard deviation within 1/√(2S) of its own value, times 3, beside the required 10 %, and
a coverage of 95 % give or take 3 √(0.95 * 0.05 / S).
"""

import numpy as np
import pytest

from benchmarks.estimators import (
    BIAS_WALK,
    FLIGHT_NOISE,
    RELEASE_MOMENTUM_B,
    SIMULATION_NOISE,
    closed_loop,
    open_loop,
    scores,
)

SEEDS = 120
STANDARD_ERRORS = 3.5
SCATTER = 0.1 + 3.0 / np.sqrt(2.0 * SEEDS)
COVERAGE = 0.95 - 3.0 * np.sqrt(0.95 * 0.05 / SEEDS)


@pytest.fixture(
    scope="module",
    params=[
        lambda: open_loop(SIMULATION_NOISE, np.zeros(3)),
        lambda: open_loop(SIMULATION_NOISE, RELEASE_MOMENTUM_B),
        lambda: closed_loop(SIMULATION_NOISE, SEEDS),
    ],
    ids=["from rest", "released with a spin", "closed loop"],
)
def score(request):
    return scores(request.param(), SEEDS)


@pytest.fixture(scope="module")
def walking():
    """Return the scores where the gyro's bias walks as the telemetry states."""
    return scores(open_loop(FLIGHT_NOISE, RELEASE_MOMENTUM_B, walk=BIAS_WALK), SEEDS)


@pytest.mark.parametrize("name", ["iv", "iv_momentum", "output_error"])
def test_mean_error_is_within_its_standard_error(score, name):
    assert np.abs(score[name].bias).max() < STANDARD_ERRORS


@pytest.mark.parametrize("name", ["iv_momentum", "output_error"])
def test_scatter_is_the_bounds(score, name):
    assert np.abs(score[name].scatter - 1.0).max() < SCATTER


@pytest.mark.parametrize("name", ["iv", "iv_momentum", "output_error"])
def test_bands_cover(score, name):
    assert score[name].coverage.min() > COVERAGE
    assert score[name].coverage.mean() < 0.985  # not for being too wide


def test_least_squares_pulls_the_moments_of_inertia_down(score):
    assert (score["ls"].bias[:3] < -6.0).all()
    assert (score["ls"].error[:, :3].mean(axis=0) < -1e-4).all()  # kg·m²


@pytest.mark.parametrize("name", ["iv", "iv_momentum", "output_error"])
def test_bands_cover_beside_a_bias_that_walks(walking, name):
    assert np.abs(walking[name].bias).max() < STANDARD_ERRORS
    assert walking[name].coverage.min() > COVERAGE
    assert walking[name].coverage.mean() < 0.985


def test_output_error_reaches_the_bound_beside_a_bias_that_walks(walking):
    assert np.abs(walking["output_error"].scatter - 1.0).max() < SCATTER
