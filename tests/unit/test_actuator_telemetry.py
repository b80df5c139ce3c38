"""Telemetry of actuators that comes more slowly than the gyro's samples."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import make_interp_spline

from support.synthetic_telemetry import TRUE_THETA, Flight, exact_telemetry, noisy, nominal_flight, sample_times
from testbed.diagnosis.actuator_telemetry import where_known, with_telemetry_noise
from testbed.diagnosis.data import runs_of
from testbed.dynamics.inertia import inertia_of
from testbed.estimation.telemetry import Telemetry
from testbed.estimation.telemetry_noise import predicted_rate_variance

FLIGHT = nominal_flight(np.array([0.002, -0.001, 0.002]))
SWIFT = replace(FLIGHT, gimbals=replace(FLIGHT.gimbals, frequency=2.0 * np.pi * np.array([0.8, 1.0, 0.9])))
"""Up to 1 Hz: of 2 Hz, which samples at 4 Hz show at most, a half."""
GYRO_RATE, GYRO_NOISE = 16.0, 0.001658


def run(actuator_rate: float, *, flight: Flight = FLIGHT, shift: float = 0.0, encoder_noise: float = 1e-4) -> Telemetry:
    times = sample_times(actuator_rate) + shift
    exact = exact_telemetry(flight, sample_times(GYRO_RATE), times[times <= 5.0], GYRO_NOISE)
    return noisy(exact, seed=4, encoder_noise=encoder_noise)


@pytest.mark.parametrize("actuator_rate", [8.0, 16.0, 80.0])
def test_samples_between_those_of_fast_actuators_stay(actuator_rate):
    fast = run(actuator_rate)
    assert where_known([fast], TRUE_THETA) == [fast]


@pytest.mark.parametrize("shift", [0.0, 0.02])
def test_samples_between_those_of_slow_actuators_are_left_out(shift):
    slow = run(4.0, shift=shift)
    (kept,) = where_known([slow], TRUE_THETA)
    assert np.abs(kept.gyro_time[:, None] - slow.actuator_time).min(axis=1).max() < 0.5 / GYRO_RATE + 1e-9
    assert len(kept.gyro_time) == len(slow.actuator_time)
    rows = np.searchsorted(slow.gyro_time, kept.gyro_time)
    np.testing.assert_array_equal(kept.body_rate, slow.body_rate[rows])


def test_of_clocks_that_coincide_now_and_then_those_samples_are_left():
    """The nearest to each lie between samples as well: of five healthy sets three got a name for it."""
    exact = exact_telemetry(FLIGHT, sample_times(10.0), sample_times(4.0), GYRO_NOISE)
    slow = noisy(exact, seed=4, encoder_noise=1e-4)
    (kept,) = where_known([slow], TRUE_THETA)
    np.testing.assert_allclose(kept.gyro_time, np.arange(11) / 2.0)


@pytest.mark.parametrize(("held", "left"), [(True, 60), (False, 251)])
def test_the_gyro_shows_whether_fast_actuators_move_along_chords(held, left):
    """At 10 Hz under a gyro at 50 Hz, torque held for 0.1 s, two of two healthy rigs had a flexible mode or slosh."""
    sent, read = np.arange(51) / 10.0, np.arange(251) / 50.0
    path = np.stack([0.4 * np.sin((2.0 + axis) * sent + axis) for axis in range(3)], axis=1)
    between = make_interp_spline(sent, path, k=1 if held else 3)(read)
    noise = 1e-4 * np.random.default_rng(5).standard_normal(between.shape)
    flight = Telemetry(
        gyro_time=read,
        body_rate=noise - between,
        gyro_noise=1e-4,
        actuator_time=sent,
        gimbals=None,
        cluster_momentum=path @ inertia_of(TRUE_THETA),
        initial_momentum="estimated",
    )
    (kept,) = where_known([flight], TRUE_THETA)
    assert len(kept.gyro_time) <= left
    assert (len(kept.gyro_time) < len(read)) == held
    assert set(np.round(sent, 6)) <= set(np.round(kept.gyro_time, 6))


@pytest.mark.parametrize("seed", range(6))
def test_chords_are_seen_though_a_fifth_of_their_bends_is_noise_of_the_telemetry(seed):
    """Of eight healthy sets of such a rig two were believed to move along splines, and named an appendage."""
    sent, read = np.arange(401) / 20.0, np.arange(2001) / 100.0
    rng = np.random.default_rng(seed)
    path = np.stack([0.08 * np.sin((2.0 + axis) * sent + axis + seed) for axis in range(3)], axis=1)
    between = make_interp_spline(sent, path, k=1)(read)
    flight = Telemetry(
        gyro_time=read,
        body_rate=8e-4 * rng.standard_normal(between.shape) - between,
        gyro_noise=8e-4,
        actuator_time=sent,
        gimbals=None,
        cluster_momentum=(path + 2e-4 * rng.standard_normal(path.shape)) @ inertia_of(TRUE_THETA),
        initial_momentum="estimated",
    )
    (kept,) = where_known([flight], TRUE_THETA)
    assert len(kept.gyro_time) < len(read)


def test_noise_of_the_telemetry_makes_no_chords():
    """It bends the chords as the spline, and the gyro shows neither: the samples between are as good as any."""
    sent, read = np.arange(201) / 10.0, np.arange(1001) / 50.0
    rng = np.random.default_rng(6)
    smooth = [0.3 * np.stack([np.sin((0.2 + 0.1 * axis) * time) for axis in range(3)], axis=1) for time in (sent, read)]
    flight = Telemetry(
        gyro_time=read,
        body_rate=1e-3 * rng.standard_normal((1001, 3)) - smooth[1],
        gyro_noise=1e-3,
        actuator_time=sent,
        gimbals=None,
        cluster_momentum=(smooth[0] + 5e-4 * rng.standard_normal((201, 3))) @ inertia_of(TRUE_THETA),
        initial_momentum="estimated",
    )
    assert where_known([flight], TRUE_THETA) == [flight]


def test_samples_between_those_of_actuators_at_rest_stay():
    moving = run(4.0)
    still = replace(moving, gimbals=replace(moving.gimbals, angle=0.0 * moving.gimbals.angle))
    assert where_known([still], TRUE_THETA) == [still]


def test_motion_between_slow_samples_is_no_noise_of_the_telemetry():
    (kept,) = where_known([run(4.0, flight=SWIFT)], TRUE_THETA)
    added = predicted_rate_variance(kept, TRUE_THETA)
    assert np.sqrt(added.min()) > 10.0 * GYRO_NOISE  # of the encoders it is 6e-5 rad/s
    sigma = with_telemetry_noise(runs_of(["a"], [kept]), TRUE_THETA).sigma
    assert sigma.max() < 2.0 * GYRO_NOISE  # known as well as 21 samples of one run show


def test_noise_of_the_telemetry_counts_as_its_fast_changes_have_it():
    loud = run(GYRO_RATE, encoder_noise=1e-2)
    added = predicted_rate_variance(loud, TRUE_THETA)
    assert np.sqrt(added.min()) > GYRO_NOISE
    sigma = with_telemetry_noise(runs_of(["a"], [loud]), TRUE_THETA).sigma
    np.testing.assert_array_equal(sigma, [np.sqrt(GYRO_NOISE**2 + added)])
