"""The controller of a flight, built on the nominal platform, and the flight's clock."""

from __future__ import annotations

import numpy as np

from testbed.arrays import Matrices3, Series, Units, Vectors3
from testbed.assembly.platform import PlatformModel, each_wheel, platform_actuators
from testbed.cmg.steering import (
    GeneralizedSingularityRobust,
    MoorePenrose,
    OffDiagonalSingularityRobust,
    SingularityRobust,
    SteeringLaw,
)
from testbed.cmg.wheels import Wheels
from testbed.control.controller import Controller
from testbed.control.servo import gimbal_servo, momentum_gain
from testbed.control.tracker import Tracker, feedback_gain
from testbed.control.wheels import WheelDrive
from testbed.dynamics.environment import outside_torque
from testbed.errors import InputError
from testbed.maneuver.maneuver import Maneuver
from testbed.rotation.kinematics import integrate_attitude
from testbed.rotation.quaternion import matrix_of
from testbed.scenario import control as schema
from testbed.scenario.scenario import Scenario
from testbed.scenario.timing import too_large
from testbed.scenario.values import per_unit
from testbed.simulation.flight import Clock


def flight_clock(scenario: Scenario, maneuver_duration: float) -> Clock:
    """Return the integer clocks of the flight; the scenario has checked that they divide.

    Args:
        scenario: rates and, where given, the duration.
        maneuver_duration: s, flown with the settling time where the scenario gives no duration.

    Raises:
        InputError: the flight is longer than any that is flown.
    """
    simulation = scenario.simulation
    duration = simulation.duration_s
    if duration is None:
        duration = maneuver_duration + simulation.settle_s
    if problem := too_large(simulation, duration):  # of a table of samples, whose length the scenario does not know
        raise InputError(f"the flight: {problem}")
    return Clock(
        step=simulation.step_s,
        control_steps=round(1.0 / (simulation.control_rate_hz * simulation.step_s)),
        telemetry_ticks=round(simulation.control_rate_hz / simulation.telemetry_rate_hz),
        ticks=round(duration * simulation.control_rate_hz),
    )


def flight_controller(scenario: Scenario, nominal: PlatformModel) -> Controller:
    """Return the controller; it knows the nominal platform only."""
    gyros, steering = scenario.gyros, scenario.controller.steering
    period = 1.0 / scenario.simulation.control_rate_hz
    servo = gimbal_servo(nominal.cluster, gyros.servo_bandwidth, gyros.servo_damping_ratio, gyros.gimbal_rate_limit)
    return Controller(
        actuators=platform_actuators(scenario, nominal),
        tracker=Tracker(inertia=nominal.turned_inertia, gain=_gain(scenario)),
        law=steering_law(steering),
        servo=servo,
        drive=_wheel_drive(scenario, nominal.wheels),
        momentum_gain=momentum_gain(servo, period),
        null_motion_gain=steering.null_motion_gain_1_s,
        period=period,
    )


def expected_torque(scenario: Scenario, nominal: PlatformModel, maneuver: Maneuver, time: Series) -> Vectors3 | None:
    """Return what the controller expects to act on the platform along its reference; None where nothing does.

    Args:
        scenario: how the flight starts.
        nominal: with its environment.
        maneuver: the reference.
        time: shape (N,), s.

    Returns:
        Shape (N, 3), N·m, body axes.
    """
    if nominal.environment is None:
        return None
    body_rate = maneuver.reference(time).body_rate
    matrix_NB = reference_attitude(scenario, time, body_rate)
    return outside_torque(nominal.environment, nominal.inertia, time, matrix_NB, body_rate)


def reference_attitude(scenario: Scenario, time: Series, body_rate: Vectors3) -> Matrices3:
    """Return R_NB along a reference body rate from the scenario's start, shape (N, 3, 3)."""
    return matrix_of(np.array(scenario.initial.attitude_quat_NB)) @ matrix_of(integrate_attitude(time, body_rate))


def tilts_along(scenario: Scenario, maneuver: Maneuver, time: Series) -> Series:
    """Return the angle between the body z axis and the vertical along a reference, shape (N,), rad."""
    up_B = reference_attitude(scenario, time, maneuver.reference(time).body_rate)[:, 2]
    return np.asarray(np.arctan2(np.hypot(up_B[:, 0], up_B[:, 1]), up_B[:, 2]))


def _wheel_drive(scenario: Scenario, wheels: Wheels) -> WheelDrive:
    allocation, count = scenario.controller.wheels, len(wheels.spin_inertia)
    return WheelDrive(
        viscous_friction=each_wheel(scenario, "viscous_friction_N_m_s_rad"),
        loop_gain=wheels.spin_inertia * each_wheel(scenario, "speed_loop_bandwidth_rad_s"),
        null_motion=allocation.null_motion,
        null_gain=allocation.gain_1_s,
        preferred=np.array(per_unit(allocation.preferred_momentum_N_m_s, count, 0.0)),
    )


def preferred_gimbal_angle(scenario: Scenario) -> Units | None:
    """Return constant preferred gimbal angles, shape (M,), rad; None where the maneuver prescribes them."""
    preferred = scenario.controller.steering.preferred_gimbal_angle_rad
    if preferred == "maneuver":
        return None
    return np.array(per_unit(() if preferred == "zero" else preferred, scenario.gyros.units, 0.0))


def steering_law(steering: schema.Steering) -> SteeringLaw:
    """Return the law that a scenario's steering section describes."""
    match steering:
        case schema.MoorePenrose():
            return MoorePenrose()
        case schema.SingularityRobust():
            return SingularityRobust(damping=steering.damping, decay=steering.decay)
        case schema.GeneralizedSingularityRobust():
            return GeneralizedSingularityRobust(**_dithered(steering))
        case schema.OffDiagonalSingularityRobust():
            return OffDiagonalSingularityRobust(**_dithered(steering))


def _dithered(
    steering: schema.GeneralizedSingularityRobust | schema.OffDiagonalSingularityRobust,
) -> dict[str, float]:
    return {
        "damping": steering.damping,
        "decay": steering.decay,
        "dither": steering.dither,
        "dither_rate": steering.dither_rate_rad_s,
    }


def _gain(scenario: Scenario) -> float:
    controller, gyro = scenario.controller, scenario.gyro
    if not controller.feedback:
        return 0.0
    if controller.feedback_gain_1_s is not None:
        return controller.feedback_gain_1_s
    return feedback_gain(gyro.noise_rad_s, 1.0 / gyro.sample_rate_hz)
