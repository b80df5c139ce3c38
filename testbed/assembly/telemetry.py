"""From a record, flown or measured, to what the estimators take."""

from __future__ import annotations

from dataclasses import replace
from math import ceil

import numpy as np

from testbed.arrays import Array, Flags, Series, UnitSeries, Vectors3
from testbed.assembly.platform import Body, each_wheel
from testbed.assembly.surroundings import surroundings_of
from testbed.assembly.time_base import require_time_in_seconds
from testbed.cmg.cluster import Cluster
from testbed.cmg.servo_law import stiffness_of
from testbed.errors import InputError
from testbed.estimation.gyro_noise import gyro_noise_of, noise_freedom
from testbed.estimation.held import corners_of, held_periods, impulse_of_held
from testbed.estimation.slow_bias import SlowBias
from testbed.estimation.telemetry import (
    GimbalTelemetry,
    Servo,
    Telemetry,
    Thrusters,
    WheelMotors,
    WheelTelemetry,
)
from testbed.records.checks import live_columns, sampled_rows
from testbed.records.record import Record
from testbed.records.selection import sampled, telemetry_only, usable
from testbed.scenario.body import BodyScenario
from testbed.scenario.scenario import Scenario
from testbed.signals import AXES, SIGNALS, TURNED_BY

_CLOCK_JITTER = 0.01
"""Of a control period, by which the times of samples may be off."""


def telemetry_of(record: Record, scenario: BodyScenario, nominal: Body) -> Telemetry:
    """Return what a record gives the estimators; its usable part only.

    Args:
        record: flown or measured.
        scenario: the gyro's noise where neither the record states it nor its samples show it, and what is known of the
            initial momentum.
        nominal: geometry of the units, and their momentum where the record has no tachometers.

    Raises:
        InputError: a channel that the estimators need is missing, too few samples are usable, or the time cannot be in
            seconds.
    """
    require_time_in_seconds(record, scenario.gyro.sample_rate_hz)
    part = _with_torque(usable(telemetry_only(record)), scenario)
    live = live_axes(record, scenario)
    gyro_time, body_rate = sampled(part, "body_rate")
    body_rate = np.where(live, body_rate, 0.0)  # a bearing holds the platform: these are no readings
    source = _actuator_channel(part)
    time, values = sampled(part, source)
    held = source == "applied_torque" and scenario.diagnosis.applied_torque == "held"
    thrusters, thrust = _thrusters(part, scenario, time)
    smooth = body_rate
    if held:
        time, means = held_periods(time, gyro_time)
        values, thrust = means(values), None if thrust is None else means(thrust)
        # Corners would pass for noise.
        smooth = body_rate - corners_of(impulse_of_held(time, values), nominal.turned_inertia)(gyro_time)
    noise = _gyro_noise(part, gyro_time, smooth[:, live])
    return Telemetry(
        gyro_time=gyro_time,
        body_rate=body_rate,
        gyro_noise=scenario.gyro.noise_rad_s if noise is None else noise,
        actuator_time=time,
        gimbals=_gimbals(part, scenario, _units(part, nominal), time, values) if source == "gimbal_angle" else None,
        wheels=_wheels(part, scenario, nominal, time),
        cluster_momentum=values if source == "cluster_momentum" else None,
        applied_torque=values if source == "applied_torque" else _channel(part, "applied_torque", time),
        torque_held=held,
        held_inertia=nominal.turned_inertia if held else None,
        thrust=thrust,
        thrusters=thrusters,
        initial_momentum=scenario.estimation.initial_momentum,
        constant_torque=scenario.estimation.constant_torque,
        slow_bias=_slow_bias(scenario),
        noise_freedom=np.inf if noise is None or noise == part.details.gyro_noise else noise_freedom(gyro_time),
        live=(bool(live[0]), bool(live[1]), bool(live[2])),
        surroundings=surroundings_of(record, scenario, nominal),
    )


def _slow_bias(scenario: BodyScenario) -> SlowBias | None:
    """Return how the gyro's bias wanders by the scenario; None where it says nothing of that."""
    gyro = scenario.gyro
    if not (gyro.bias_instability_rad_s or gyro.rate_random_walk_rad_s_per_sqrt_s):
        return None
    return SlowBias(
        instability=gyro.bias_instability_rad_s,
        correlation_time=gyro.bias_correlation_time_s or np.inf,
        random_walk=gyro.rate_random_walk_rad_s_per_sqrt_s,
    )


def live_axes(record: Record, scenario: BodyScenario) -> Flags:
    """Return about which body axes the platform turns in a run, shape (3,).

    Those that the scenario and the run allow, less those whose gyro channel is empty or constant.

    Args:
        record: measured.
        scenario: whose `platform.axes` says about which axes the rig can turn.

    Raises:
        InputError: an axis of a platform that turns freely is empty, or no axis is left.
    """
    rates = record.channels["body_rate"]
    known = live_columns(rates)
    turning = np.array([np.ptp(rates[sampled_rows(rates), axis]) > 0.0 if known[axis] else False for axis in range(3)])
    said = [each for each in (scenario.platform.axes, record.details.axes) if each is not None]
    if not said:
        if not known.all():
            empty = " and ".join(axis for axis, yes in zip(AXES, known, strict=True) if not yes)
            raise InputError(
                f"{record.details.name}: the gyro's channel about {empty} has no value in any row: fill it; of a rig "
                f"that does not turn about {empty}, say so: {axes_key(known & turning)} in [platform] of the scenario"
            )
        return known
    allowed = np.array([all(axis in each for each in said) for axis in AXES])
    if not (allowed & turning).any():
        raise InputError(
            f"{record.details.name}: the gyro shows no motion about {' or '.join(said[0])}, about which the rig turns "
            "by platform.axes (and by axes in the run's .toml): correct these, or take the run out"
        )
    return np.asarray(allowed & turning)


def axes_key(live: Flags) -> str:
    """Return the key that says about which axes a rig turns, such as `axes = ["z"]`."""
    names = ", ".join(f'"{axis}"' for axis, yes in zip(AXES, live, strict=True) if yes)
    return f"axes = [{names}]"


def _gyro_noise(record: Record, time: Series, body_rate: Vectors3) -> float | None:
    """Return the noise that the record states; of a measured one that does not, what its samples show."""
    stated = record.details.gyro_noise
    if stated or record.details.source == "simulated":  # no measured gyro is free of noise
        return stated
    return gyro_noise_of(time, body_rate)


def _actuator_channel(record: Record) -> str:
    for name in TURNED_BY:
        if name in record.channels:
            return name
    raise InputError(f"{record.details.name}: one of {', '.join(TURNED_BY)} is needed to estimate the inertia")


_AGREES = 0.2
"""Share of the applied torque's scatter by which it may differ from what the thrusters make of their thrusts: rounding
and another constant pass, a motor in another's place does not."""


def _with_torque(record: Record, scenario: BodyScenario) -> Record:
    """Return a record with the torque that its thrusts make, where nothing else in it says what turned the platform.

    Raises:
        InputError: the scenario does not say where its thrusters sit, or of another number of them.
    """
    if _actuator_channel(record) != "motor_thrust":
        return record
    if not scenario.thrusters:
        raise InputError(
            f"{record.details.name}: holds motor_thrust, but the scenario does not say which torque a thrust makes: "
            "add [[thrusters]] with position_m and direction, one for each column, or applied_torque to the record"
        )
    thrust = record.channels["motor_thrust"]
    torque_B = thrust @ _stated_thrusters(record, scenario).torque_per_thrust_B
    return replace(record, channels={**record.channels, "applied_torque": torque_B})


def _thrusters(record: Record, scenario: BodyScenario, time: Series) -> tuple[Thrusters | None, Array | None]:
    """Return the scenario's thrusters and what each was commanded; none where either is not known.

    Raises:
        InputError: there are not as many of one as of the other, or together they make another torque than recorded.
    """
    thrust, torque_B = _channel(record, "motor_thrust", time), _channel(record, "applied_torque", time)
    if thrust is None or torque_B is None or not scenario.thrusters:
        return None, None
    thrusters = _stated_thrusters(record, scenario)
    missed = torque_B - thrust @ thrusters.torque_per_thrust_B
    if missed.std(axis=0).max() > _AGREES * torque_B.std(axis=0).max():
        raise InputError(
            f"{record.details.name}: the scenario's [[thrusters]] make another torque of motor_thrust than "
            "applied_torque says: check their order, positions, directions and the signs of reaction_m"
        )
    return thrusters, thrust


def _stated_thrusters(record: Record, scenario: BodyScenario) -> Thrusters:
    sent, stated = record.channels["motor_thrust"].shape[1], len(scenario.thrusters)
    if sent != stated:
        raise InputError(
            f"{record.details.name}: has {sent} columns motor_thrust_..._N, but the scenario has {stated} "
            "[[thrusters]]: give each thruster a column, in the scenario's order"
        )
    return Thrusters(
        position_B=np.array([each.position_m for each in scenario.thrusters]),
        direction_B=np.array([each.direction for each in scenario.thrusters]),
        reaction=np.array([each.reaction_m for each in scenario.thrusters]),
    )


def _units(record: Record, nominal: Body) -> Cluster:
    if nominal.cluster is None:
        raise InputError(
            f"{record.details.name}: holds gimbal_angle, but the scenario has no [cluster] of control moment gyros; "
            "use the scenario of the platform that was measured"
        )
    sent, believed = record.channels["gimbal_angle"].shape[1], len(nominal.cluster.rotor_momentum)
    if sent != believed:
        raise InputError(
            f"{record.details.name}: has gimbal angles of {sent} units, but the scenario has {believed}; "
            f"{_lacking('gimbal_angle', sent, believed)}use the scenario of the platform that was measured"
        )
    return nominal.cluster


def _lacking(signal: str, sent: int, believed: int) -> str:
    """Return what to do about the columns that a record has fewer of than the scenario has units."""
    missing = SIGNALS[signal].sized(believed).columns[sent:]
    return f"add {', '.join(missing)}, or " if missing else ""


def _wheels(record: Record, scenario: BodyScenario, nominal: Body, time: Series) -> WheelTelemetry | None:
    """Return what the reaction wheels sent, at the actuators' times; None of a record without any."""
    speed = _channel(record, "wheel_speed", time)
    if speed is None:
        return None
    sent, believed = speed.shape[1], len(nominal.wheels.spin_inertia)
    if sent != believed:
        known = f"has {believed}" if believed else "has no [[actuators]] of that kind"
        raise InputError(
            f"{record.details.name}: has speeds of {sent} reaction wheels, but the scenario {known}; "
            f"{_lacking('wheel_speed', sent, believed)}use the scenario of the platform that was measured"
        )
    command, period = _command(record, "wheel_torque_command", scenario, time)
    return WheelTelemetry(
        wheels=nominal.wheels,
        momentum=speed * nominal.wheels.spin_inertia,
        torque=_channel(record, "wheel_torque", time),
        torque_command=command,
        motors=_motors(scenario, period),
    )


def _motors(scenario: BodyScenario, period: float) -> WheelMotors:
    return WheelMotors(
        viscous_friction=each_wheel(scenario, "viscous_friction_N_m_s_rad"),
        coulomb_friction=each_wheel(scenario, "coulomb_friction_N_m"),
        loop_bandwidth=each_wheel(scenario, "speed_loop_bandwidth_rad_s"),
        period=period,
    )


def _gimbals(
    record: Record, scenario: BodyScenario, cluster: Cluster, time: Series, angle: UnitSeries
) -> GimbalTelemetry:
    """Return what the units sent; their commands only where the servo is known that follows them."""
    rotor_speed = _channel(record, "rotor_speed", time)
    command, period = _command(record, "gimbal_rate_command", scenario, time)
    gimbals = GimbalTelemetry(
        cluster=cluster,
        angle=angle,
        rotor_momentum=None if rotor_speed is None else rotor_speed * cluster.rotor_spin_inertia,
        torque=_motor_torques(record, time),
        servo=_servo(scenario, period),
    )
    return gimbals if command is None else gimbals.commanded(command)


def _servo(scenario: BodyScenario, period: float) -> Servo:
    """Return what is known of the gimbals' servo."""
    gyros = scenario.gyros
    bandwidth = gyros.servo_bandwidth
    return Servo(
        bandwidth=bandwidth,
        stiffness=stiffness_of(bandwidth, gyros.servo_damping_ratio),
        rate_limit=gyros.gimbal_rate_limit,
        period=period,
    )


def _control_period(scenario: BodyScenario, time: Series) -> float:
    """Return the period of the control loop, s.

    Samples are taken on the control clock, so that one which is too slow for them is taken as fast as it has to be; so
    is that of a platform which is only measured and whose scenario does not say how fast it is.
    """
    interval = float(np.median(np.diff(time)))
    rate = scenario.diagnosis.control_rate_hz
    if rate is None and isinstance(scenario, Scenario):
        rate = scenario.simulation.control_rate_hz
    return interval if rate is None else interval / max(ceil(interval * rate - _CLOCK_JITTER), 1)


def _command(record: Record, name: str, scenario: BodyScenario, time: Series) -> tuple[Array | None, float]:
    """Return a channel of commands at given times, and for how long they hold, s; None where it was not sent.

    A command that was recorded at other times, such as those at which it changes, holds from its sample until the next
    one: at each time stands its mean until the next time. Of one that the controller changes more often than it is
    recorded only lines from sample to sample are known.
    """
    if name not in record.channels:
        return None, _control_period(scenario, time)
    known, values = sampled(record, name)
    if len(known) < 2 or np.array_equal(known, time) or not _holds(scenario, known):
        return _channel(record, name, time), _control_period(scenario, time)
    ends = np.append(time, 2.0 * time[-1] - time[-2])
    first, last = min(known[0], ends[0]), max(known[-1], ends[-1]) + 1.0
    knots = np.concatenate([[first], known[1:], [last]])
    total = np.concatenate([np.zeros_like(values[:1]), np.cumsum(values * np.diff(knots)[:, None], axis=0)])
    at_ends = np.stack([np.interp(ends, knots, column) for column in total.T], axis=1)
    return np.diff(at_ends, axis=0) / np.diff(ends)[:, None], float(np.median(np.diff(time)))


def _holds(scenario: BodyScenario, known: Series) -> bool:
    """Return whether a command that was recorded at such times holds from sample to sample."""
    return _control_period(scenario, known) >= (1.0 - _CLOCK_JITTER) * float(np.median(np.diff(known)))


def _motor_torques(record: Record, time: Series) -> Array | None:
    """Return the torques of the gimbals' motors at given times; not a number where they were not sampled then.

    Between slow samples lines would pass for torques without noise. Of samples that never come at these times, lines.
    """
    if "gimbal_torque" not in record.channels:
        return None
    known, values = sampled(record, "gimbal_torque")
    found = np.clip(np.searchsorted(known, time), 0, len(known) - 1)
    then = known[found] == time
    if not then.any():
        return _channel(record, "gimbal_torque", time)
    return np.where(then[:, None], values[found], np.nan)


def _channel(record: Record, name: str, time: Series) -> Array | None:
    """Return a channel at given times; where it was sampled then, exactly as it was; None where it was not sent."""
    if name not in record.channels:
        return None
    known, values = sampled(record, name)
    if np.array_equal(known, time):
        return values
    return np.stack([np.interp(time, known, column) for column in values.T], axis=1)
