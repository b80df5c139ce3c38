"""The servo's law, as it is flown and as it is predicted."""

import numpy as np

from testbed.cmg.servo_law import next_commanded_angle, set_point, stiffness_of, within
from testbed.estimation.telemetry import Servo
from testbed.prediction.kernels import set_points

SERVO = Servo(bandwidth=50.0, stiffness=stiffness_of(50.0, 1.0), rate_limit=2.0, period=0.0125)


def test_the_predicted_set_points_are_those_that_are_flown():
    """Errors within the bound, beyond it, and cut on either side; behind a gap the gimbals count as commanded."""
    rng = np.random.default_rng(1)
    angles, commands = rng.uniform(-0.2, 0.2, (200, 6)).cumsum(axis=0), rng.uniform(-3.0, 3.0, (200, 6))
    anew = np.arange(200) == 70
    gain, commanded, flown = SERVO.stiffness / SERVO.bandwidth, angles[0], []
    for angle, command, begun in zip(angles, commands, anew, strict=True):
        commanded = angle if begun else commanded
        flown.append(set_point(command, commanded - angle, gain))
        commanded = next_commanded_angle(commanded, angle, SERVO.angle_error_bound, command, SERVO.period)
    predicted = set_points(commands, angles, anew, (gain, SERVO.angle_error_bound, SERVO.period))
    np.testing.assert_allclose(predicted, flown, atol=1e-11)


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
