"""The residual's autocorrelation, and that the paper's γ whitens it."""

from __future__ import annotations

import numpy as np

from testbed.assembly.platform import nominal_platform
from testbed.experiment.planning import plan_maneuver
from testbed.reproduction.whiteness import autocorrelation, whiteness
from testbed.scenario.reader import read_scenario
from testbed.scenario.shipped import shipped_scenario


def test_autocorrelation_of_a_moving_average_is_the_textbooks():
    """e_k + b e_{k-1}: b / (1 + b²) at lag 1, nothing beyond; 3 · 20,000 samples leave 1/√60,000 = 0.004."""
    noise = np.random.default_rng(1).standard_normal((20_001, 3))
    moving = noise[1:] + 0.5 * noise[:-1]
    np.testing.assert_allclose(autocorrelation(moving, 4), [0.4, 0.0, 0.0, 0.0], atol=4 * 0.004)


def test_the_papers_prefilter_whitens_the_residual_and_a_quick_one_does_not():
    scenario = read_scenario(shipped_scenario("basic"))
    maneuver = plan_maneuver(scenario, nominal_platform(scenario)).maneuver
    curve = whiteness(scenario, maneuver, 4, 1)
    paper = curve.time_constant.tolist().index(0.8)
    assert np.abs(curve.autocorrelation[paper]).max() < curve.white_band
    # Behind a prefilter of T = 0.05 s the derivative is still there: Ts/(Ts + 1) of white noise at 16 Hz.
    assert curve.autocorrelation[0, 0] < -curve.white_band
