"""The servo's law, as it is flown and as it is predicted."""

import numpy as np

from testbed.cmg.servo_law import next_commanded_angle, set_point, stiffness_of, within
from testbed.estimation.telemetry import Servo
from testbed.prediction.servo import _Commanded

SERVO = Servo(bandwidth=50.0, stiffness=stiffness_of(50.0, 1.0), rate_limit=2.0, period=0.0125)


def test_the_predicted_commanded_angle_is_the_one_that_is_flown():
    """Errors within the bound, beyond it, and cut on either side."""
    rng = np.random.default_rng(1)
    flown = rng.uniform(-1.0, 1.0, 6)
    predicted = _Commanded(SERVO, flown)
    for _ in range(200):
        angle, command = flown + rng.uniform(-0.2, 0.2, 6), rng.uniform(-3.0, 3.0, 6)
        gain = SERVO.stiffness / SERVO.bandwidth
        np.testing.assert_allclose(
            predicted.set_point(command, angle), set_point(command, flown - angle, gain), atol=1e-11
        )
        flown = next_commanded_angle(flown, angle, SERVO.angle_error_bound, command, SERVO.period)
        predicted.follow(command, angle)


def test_a_commanded_angle_stays_within_its_bound_of_a_gimbal_that_stands():
    angle, stands = np.zeros(1), np.zeros(1)
    for _ in range(1000):
        angle = next_commanded_angle(angle, stands, SERVO.angle_error_bound, np.array([2.0]), SERVO.period)
    assert SERVO.angle_error_bound == 2.0 / 25.0
    np.testing.assert_allclose(angle, SERVO.angle_error_bound + 2.0 * SERVO.period, rtol=1e-12)


def test_a_limit_stops_the_derivative_by_complex_step_and_lets_it_pass_within():
    step = 1e-20j
    cut, passed = within(np.array([3.0 + step, 1.0 + step]), 2.0)
    assert (cut, passed) == (2.0 + 0j, 1.0 + step)
