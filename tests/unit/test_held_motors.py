"""Motors that hold their torque between samples of the telemetry: momenta go along chords, and a late gyro shows it."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import make_interp_spline

from support.synthetic_telemetry import TRUE_THETA
from testbed.diagnosis.data import runs_of
from testbed.diagnosis.fitting import fitted
from testbed.diagnosis.held_motors import along_chords
from testbed.diagnosis.model import Hypothesis
from testbed.dynamics.inertia import inertia_of, theta_of
from testbed.effects.registry import EFFECTS
from testbed.estimation.telemetry import Telemetry

TRUE_INERTIA = inertia_of(TRUE_THETA)
PERIOD = 0.08
"""s, between samples of the actuators, and of their controller."""
NOISE = 6e-4
NOMINAL = theta_of(1.05 * TRUE_INERTIA)


def flight(seed, *, degree=1, late=0.0, phase=0.0, tachometer=1e-4, gyro_rate=25.0):
    """Return a run of 40 s at zero momentum, where ω = -J⁻¹ h.

    Args:
        seed: of the maneuver and the noise.
        degree: of the path between the instants at which the torque changes: 1 for chords.
        late: of the gyro, s.
        phase: by which the torque changes after the telemetry's samples, in periods.
        tachometer: noise of J⁻¹ h, rad/s.
        gyro_rate: Hz.
    """
    rng = np.random.default_rng(seed)
    sent, read = PERIOD * np.arange(501), np.arange(int(40.0 * gyro_rate)) / gyro_rate
    changes = PERIOD * (np.arange(-3, 505) + phase)
    frequency, shift = rng.uniform(0.2, 2.2, (2, 3, 5)), rng.uniform(0.0, 6.0, (3, 5))
    rate = 0.05 * np.sin(frequency[0] * changes[:, None, None] + shift).sum(axis=-1)
    path = make_interp_spline(changes, rate, k=degree)
    return Telemetry(
        gyro_time=read,
        body_rate=NOISE * rng.standard_normal((len(read), 3)) - path(read - late),
        gyro_noise=NOISE,
        actuator_time=sent,
        gimbals=None,
        cluster_momentum=(path(sent) + tachometer * rng.standard_normal((len(sent), 3))) @ TRUE_INERTIA,
        initial_momentum="estimated",
    )


@pytest.mark.parametrize("late", [0.0, 0.01, 0.02, 0.04, -0.03])
@pytest.mark.parametrize("seed", range(3))
def test_chords_are_seen_however_late_the_gyro_is(seed, late):
    sent = [flight(3 * seed + number, late=late) for number in range(2)]
    assert [run.momentum_held for run in along_chords(sent, NOMINAL)] == [True, True]


@pytest.mark.parametrize("late", [0.0, 0.02])
@pytest.mark.parametrize("seed", range(3))
def test_a_smooth_path_is_none_of_chords(seed, late):
    """Noise of tachometers suits chords better, by up to three tenths of what it adds: it must not count for them."""
    sent = [flight(3 * seed + number, degree=3, late=late, tachometer=2e-4) for number in range(2)]
    assert along_chords(sent, NOMINAL) == sent


@pytest.mark.parametrize("seed", range(3))
def test_torques_that_change_between_samples_give_no_chords_through_these(seed):
    sent = [flight(3 * seed + number, phase=0.4) for number in range(2)]
    assert along_chords(sent, NOMINAL) == sent


def test_actuators_as_fast_as_the_gyro_are_left_as_they_are():
    sent = [flight(1, gyro_rate=12.5)]
    assert along_chords(sent, NOMINAL) == sent


@pytest.mark.parametrize("seed", range(3))
def test_a_late_gyro_as_fast_as_the_actuators_shows_chords(seed):
    """One of 40 ms at 10 Hz had a bandwidth of 4 Hz, with P = 1."""
    sent = [flight(3 * seed + number, late=0.03, gyro_rate=12.5) for number in range(2)]
    assert [run.momentum_held for run in along_chords(sent, NOMINAL)] == [True, True]
    smooth = [flight(3 * seed + number, degree=3, late=0.03, gyro_rate=12.5) for number in range(2)]
    assert along_chords(smooth, NOMINAL) == smooth


def late_fit(telemetry, effect, component, value):
    hypothesis = Hypothesis(effect=EFFECTS[effect], component=component)
    names = [str(number) for number, _ in enumerate(telemetry)]
    return fitted(runs_of(names, telemetry), [hypothesis], NOMINAL, [np.array([value])])


@pytest.mark.parametrize("seed", range(2))
def test_along_chords_a_late_gyro_is_late_and_not_slow(seed):
    """Along splines it was slow, by 17 to 45 units of χ² in four outside sets, and J11 was up to 1.2e-3 too large."""
    sent = [flight(20 + 3 * seed + number, late=0.04, tachometer=0.0) for number in range(3)]
    held = along_chords(sent, NOMINAL)
    smooth, bent = (late_fit(each, "gyro_latency", "gyro", 0.03) for each in (sent, held))
    slow = late_fit(held, "gyro_bandwidth", "gyro", 0.03)
    assert bent.chi_square < min(smooth.chi_square, slow.chi_square) - 9.0
    assert abs(bent.effect_values[0] - 0.04) < 2e-4
    np.testing.assert_allclose(bent.theta[:3], TRUE_THETA[:3], rtol=2e-3)


def test_along_chords_late_telemetry_and_a_late_gyro_are_one():
    """Shifted, chords had corners between the nodes of the integration: 8 units of χ² spoke for the wrong one."""
    held = along_chords([flight(31 + number, late=0.01) for number in range(2)], NOMINAL)
    gyro, telemetry = late_fit(held, "gyro_latency", "gyro", 0.01), late_fit(held, "telemetry_skew", "actuators", -0.01)
    assert abs(gyro.chi_square - telemetry.chi_square) < 1e-3
    np.testing.assert_allclose(gyro.effect_values, [-value for value in telemetry.effect_values], atol=1e-6)
