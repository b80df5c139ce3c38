"""What of a record an estimator may use, and what the actuators did between their samples."""

from dataclasses import replace

import numpy as np
import pytest

from support.synthetic_telemetry import exact_telemetry, nominal_flight, sample_times, with_gimbals
from testbed.cmg.cluster import cluster_momentum, inertia_change
from testbed.errors import InputError
from testbed.estimation.actuation import actuation
from testbed.estimation.telemetry import Telemetry, covered_part

FLIGHT = nominal_flight()
TIMES = sample_times(16.0)
TELEMETRY = exact_telemetry(FLIGHT, TIMES, TIMES)


def test_gyro_samples_outside_the_actuator_telemetry_are_left_out():
    late = TELEMETRY.with_actuator_samples(TIMES[10:70], lambda samples: samples[10:70])
    np.testing.assert_array_equal(covered_part(late).gyro_time, TIMES[10:70])


def test_gyro_samples_inside_an_actuator_gap_are_left_out_but_its_ends_are_kept():
    keep = np.delete(np.arange(len(TIMES)), range(40, 48))
    gappy = TELEMETRY.with_actuator_samples(TIMES[keep], lambda samples: samples[keep])
    np.testing.assert_array_equal(covered_part(gappy).gyro_time, TIMES[keep])


def test_one_lost_actuator_sample_is_interpolated_over():
    keep = np.delete(np.arange(len(TIMES)), 40)
    gappy = TELEMETRY.with_actuator_samples(TIMES[keep], lambda samples: samples[keep])
    np.testing.assert_array_equal(covered_part(gappy).gyro_time, TIMES)


@pytest.mark.parametrize(("gyro", "actuators"), [(3, 81), (81, 3)])
def test_too_short_a_record_is_refused(gyro, actuators):
    sent = TELEMETRY.with_actuator_samples(TIMES[:actuators], lambda samples: samples[:actuators])
    short = replace(sent, gyro_time=TIMES[:gyro], body_rate=TELEMETRY.body_rate[:gyro])
    with pytest.raises(InputError, match="3"):
        covered_part(short)


def test_actuation_between_samples_is_the_true_one():
    time = np.linspace(0.0, 5.0, 501)
    angle, rate = FLIGHT.gimbals.angle(time), FLIGHT.gimbals.rate(time)
    known = actuation(TELEMETRY, time)
    exact_B = cluster_momentum(FLIGHT.cluster, angle, rate)
    np.testing.assert_allclose(known.cluster_momentum_B, exact_B, atol=4e-6)  # of 0.02; the spline's last interval
    np.testing.assert_allclose(known.inertia_change_B, inertia_change(FLIGHT.cluster, angle), atol=2e-9)


def test_encoders_that_start_over_after_a_turn_give_the_same():
    shifted = TELEMETRY.gimbals.angle + 3.0
    wrapped = np.mod(shifted + np.pi, 2.0 * np.pi) - np.pi
    assert np.abs(np.diff(wrapped, axis=0)).max() > 3.0
    time = np.linspace(0.0, 5.0, 333)
    whole, again = (actuation(with_gimbals(TELEMETRY, angle=angle), time) for angle in (shifted, wrapped))
    np.testing.assert_allclose(again.cluster_momentum_B, whole.cluster_momentum_B, atol=1e-12)


def test_tachometers_replace_the_nominal_rotor_momentum():
    fast = with_gimbals(TELEMETRY, rotor_momentum=np.full((len(TIMES), 6), 1.1 * 0.004714))
    slow, gained = (actuation(telemetry, TIMES).cluster_momentum_B for telemetry in (TELEMETRY, fast))
    spin_only = cluster_momentum(FLIGHT.cluster, TELEMETRY.gimbals.angle, np.zeros((len(TIMES), 6)))
    np.testing.assert_allclose(gained - slow, 0.1 * spin_only, atol=1e-12)


def test_the_platforms_own_momentum_stands_in_for_missing_encoders():
    momentum_B = np.linspace(0.0, 1.0, len(TIMES))[:, None] * np.array([1.0, 2.0, 3.0])
    known = actuation(replace(TELEMETRY, gimbals=None, cluster_momentum=momentum_B), TIMES[3:7])
    np.testing.assert_allclose(known.cluster_momentum_B, momentum_B[3:7], atol=1e-12)
    assert not known.inertia_change_B.any()


@pytest.mark.parametrize(("held", "kept"), [(True, 11), (False, 9)])
def test_a_torque_that_is_held_covers_the_whole_of_its_first_and_last_period(held, kept):
    """Without the first sample a slow gyro had been released a sample late, and an actuator's lag was named for it."""
    read = 0.01 * np.arange(12)
    telemetry = Telemetry(
        gyro_time=read,
        body_rate=np.zeros((12, 3)),
        gyro_noise=1e-3,
        actuator_time=0.005 + 0.01 * np.arange(10),  # from 0 to 0.1 s
        gimbals=None,
        cluster_momentum=None,
        applied_torque=np.zeros((10, 3)),
        torque_held=held,
        initial_momentum="estimated",
    )
    assert len(covered_part(telemetry).gyro_time) == kept
