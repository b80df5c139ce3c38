"""The predicted motion and its sensitivities, against a tight integration and finite differences."""

from dataclasses import replace

import numpy as np
import pytest

from support.synthetic_telemetry import TRUE_THETA, exact_telemetry, nominal_flight, sample_times
from testbed.errors import InputError
from testbed.estimation import motion as motion_module
from testbed.estimation.motion import drive_of, simulate
from testbed.estimation.sensitivity import rate_sensitivity

MOMENTUM_B = np.array([0.003, -0.004, 0.006])
FLIGHT = nominal_flight(MOMENTUM_B)
TELEMETRY = exact_telemetry(FLIGHT, sample_times(16.0), sample_times(1000.0))  # so that encoders leave no error


def test_predicted_rate_meets_the_exact_one():
    predicted = simulate(drive_of(TELEMETRY), TRUE_THETA, MOMENTUM_B).body_rate
    np.testing.assert_allclose(predicted, TELEMETRY.body_rate, atol=1e-8)  # rad/s, of 1 rad/s


def test_order_of_convergence_is_four(monkeypatch):
    errors = []
    for step in (1 / 8, 1 / 16, 1 / 32):
        monkeypatch.setattr(motion_module, "LONGEST_STEP", step)
        predicted = simulate(drive_of(replace(TELEMETRY)), TRUE_THETA, MOMENTUM_B).body_rate
        errors.append(np.abs(predicted - TELEMETRY.body_rate).max())
    order = np.log2(np.array(errors[:-1]) / errors[1:])
    assert (order > 3.7).all()


def test_a_motion_that_runs_away_is_refused_without_a_warning():
    """1 kN·m on 0.02 kg·m² leaves the finite numbers within a second of simulated time."""
    torque_B = np.full((len(TELEMETRY.actuator_time), 3), 1e3) * [1.0, -2.0, 3.0]
    with pytest.raises(InputError, match="runs away: check their units"):
        simulate(drive_of(replace(TELEMETRY, applied_torque=torque_B)), TRUE_THETA, MOMENTUM_B)


def test_sensitivities_that_run_away_are_refused_without_a_warning():
    drive = drive_of(TELEMETRY)
    motion = simulate(drive, TRUE_THETA, MOMENTUM_B)
    with pytest.raises(InputError, match="runs away: check their units"):
        rate_sensitivity(drive, replace(motion, node_rate=1e6 * motion.node_rate))


def test_momentum_keeps_its_size_without_torque():
    momentum_B = simulate(drive_of(TELEMETRY), TRUE_THETA, MOMENTUM_B).momentum_B
    np.testing.assert_allclose(np.linalg.norm(momentum_B, axis=1), np.linalg.norm(MOMENTUM_B), rtol=1e-6)


def test_no_momentum_stays_none_and_the_rate_follows_the_cluster():
    flight = nominal_flight()
    telemetry = exact_telemetry(flight, sample_times(16.0), sample_times(16.0))
    predicted = simulate(drive_of(telemetry), TRUE_THETA, np.zeros(3))
    assert not predicted.momentum_B.any()
    np.testing.assert_allclose(predicted.body_rate, telemetry.body_rate, atol=2e-5)  # of 0.7: 16 Hz encoders


@pytest.mark.parametrize("parameter", range(9))
def test_sensitivity_is_the_difference_quotient(parameter):
    drive = drive_of(TELEMETRY)
    centre = np.concatenate([TRUE_THETA, MOMENTUM_B])
    step = np.zeros(9)
    step[parameter] = 1e-6
    ahead, behind = (simulate(drive, shifted[:6], shifted[6:]).body_rate for shifted in (centre + step, centre - step))
    analytic = rate_sensitivity(drive, simulate(drive, TRUE_THETA, MOMENTUM_B))[..., parameter]
    np.testing.assert_allclose(analytic, (ahead - behind) / 2e-6, atol=1e-6 * np.abs(analytic).max())
