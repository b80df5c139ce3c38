"""Where a search begins for an effect that moves the platform too far for a linearisation to lead there."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from support.vectors import cross
from testbed.diagnosis.data import runs_of
from testbed.diagnosis.fitting import fitted
from testbed.diagnosis.model import Hypothesis
from testbed.diagnosis.short_runs import start_of_short_runs
from testbed.dynamics.inertia import theta_of
from testbed.effects.registry import EFFECTS
from testbed.estimation.telemetry import Telemetry

INERTIA = np.diag([0.02, 0.021, 0.026])
NOISE = 1e-4
DRAG = np.array([0.03, 0.02, 0.025])
"""N·m·s/rad: a platform that is left alone stops within a second."""
HIDDEN = Hypothesis(effect=EFFECTS["viscous_drag"], component="platform")


def flight(seed, duration=20.0):
    """Return a run in which a cluster turns a platform against a large drag."""
    rng = np.random.default_rng(seed)
    frequency, shift = rng.uniform(0.3, 2.0, (3, 4)), rng.uniform(0.0, 6.0, (3, 4))
    time = np.arange(int(20.0 * duration)) / 20.0

    def held(at):
        return 0.004 * np.sin(frequency * at + shift).sum(axis=-1)

    def driven(at):
        return 0.004 * (frequency * np.cos(frequency * at + shift)).sum(axis=-1)

    def slope(at, rate):
        torque = -driven(at) - cross(rate, INERTIA @ rate + held(at)) - DRAG * rate
        return np.linalg.solve(INERTIA, torque)

    rate = solve_ivp(slope, time[[0, -1]], np.zeros(3), t_eval=time, rtol=1e-9, atol=1e-12).y.T
    return Telemetry(
        gyro_time=time,
        body_rate=rate + NOISE * rng.standard_normal(rate.shape),
        gyro_noise=NOISE,
        actuator_time=time,
        gimbals=None,
        cluster_momentum=np.array([held(at) for at in time]),
        initial_momentum="estimated",
    )


@pytest.fixture(scope="module")
def runs():
    return runs_of(["1", "2"], [flight(1), flight(2)])


def test_parts_of_runs_lead_near_the_truth_from_no_effect_and_a_wrong_inertia(runs):
    bare = fitted(runs, [], theta_of(INERTIA), [])
    assert bare.chi_square > 1e4 * bare.freedom, "the motion without the effect is another one"
    theta, (drag,) = start_of_short_runs(runs, bare, [HIDDEN], [np.zeros(3)])
    np.testing.assert_allclose(drag, DRAG, rtol=0.02)
    np.testing.assert_allclose(theta, theta_of(INERTIA), atol=0.02 * INERTIA[0, 0])
    whole = fitted(runs, [HIDDEN], theta, [drag])
    assert whole.chi_square < 1.1 * whole.freedom


def test_nothing_is_cut_that_is_short_or_knows_no_attitude(runs):
    bare = fitted(runs, [], theta_of(INERTIA), [])
    cable = Hypothesis(effect=EFFECTS["tether"], component="platform")
    assert start_of_short_runs(runs, bare, [cable], [np.zeros(2)]) is None
    assert start_of_short_runs(replace(runs, windowed=("1", "2")), bare, [HIDDEN], [np.zeros(3)]) is None
    short = runs_of(["1", "2"], [flight(1, 0.9), flight(2, 0.9)])
    assert start_of_short_runs(short, fitted(short, [], theta_of(INERTIA), []), [HIDDEN], [np.zeros(3)]) is None
