"""What the gimbals' inner telemetry should have shown: motor torques, and how the angles answer the commands.

The gimbal's own motion is measured, so that its equation of motion is not integrated but read:
τ = (Jg + Jt)(d̈ + g·ω̇) - Js Ω ω·t + (Jt - Js)(ω·s)(ω·t), and friction beside it.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.signal import lfilter

from testbed.arrays import Array, Flags, UnitSeries
from testbed.estimation.telemetry import Telemetry, covered_by
from testbed.prediction.grid import Gimbals, Grid
from testbed.prediction.hooks import Hooks
from testbed.prediction.integration import effective_gimbals
from testbed.prediction.servo import answer, set_point, ticks_of
from testbed.prediction.smoothed import body_motion, gimbal_motion

SETTLING = 0.2
"""s. How long a servo needs to take up its work: what the motors do until then is not compared."""
_COMPARED = 0.1
"""s. Time constant of the high-pass behind which angles are compared: slower differences are the plan's, not known."""
_AT_LIMIT = 0.98
"""Share of the rate limit from which on a set point may be cut: 0.04 rad/s is what 1.5 mrad of an angle add to it."""
_MISSING = 1.5
"""Of the usual interval: longer ones are gaps."""
_REMEMBERED = 64


def has_torques(grid: Grid) -> bool:
    """Return whether the runs carry motor torques that can be predicted."""
    return grid.gimbals is not None and all(run.gimbal_torque is not None for run in grid.runs)


def has_commands(grid: Grid) -> bool:
    """Return whether the runs carry the rates that were asked of the gimbals, and their servo is known."""
    return grid.gimbals is not None and all(
        run.gimbal_rate_command is not None and run.servo is not None for run in grid.runs
    )


def measured_torques(grid: Grid) -> list[Array]:
    """Return the motor torques of every run that are compared, each of shape (K, 6), N·m."""
    return [_of(run.gimbal_torque)[compared(run)] for run in grid.runs]


def measured_answers(grid: Grid) -> list[Array]:
    """Return what is compared of the gimbal angles of every run, each of shape (K, 3), rad."""
    return [shown(run, np.unwrap(_of(run.gimbal_angle), axis=0)) for run in grid.runs]


def motor_torques(grid: Grid, hooks: Sequence[Hooks], effects: Sequence[Array], rates: Array) -> list[Array]:
    """Return the predicted motor torques of every run, each of shape (P, K, 6), N·m.

    Args:
        grid: the runs; they carry motor torques.
        hooks: the effects in the model.
        effects: their parameters, shapes (P, Q).
        rates: ω at the grid's nodes, shape (R, P, M + 1, 3), rad/s.
    """
    gimbals = effective_gimbals(grid, hooks, effects)
    assert gimbals is not None
    age = torque_age(grid.runs)
    torques = []
    for index, run in enumerate(grid.runs):
        at = run.actuator_time[compared(run)]
        torque = CubicSpline(grid.node_time[index], _frictionless(grid, gimbals, rates[index], index), axis=1)(at - age)
        torque = torque - age * tachometer_gain(run) * gimbal_motion(run)(at, 2)
        gimbal_rate = gimbal_motion(run)(at, 1)[None]
        for hook, value in zip(hooks, effects, strict=True):
            torque = hook.motor_torque(torque, value, gimbal_rate)
        torques.append(torque)
    return torques


@lru_cache(maxsize=_REMEMBERED)
def torque_age(runs: tuple[Telemetry, ...]) -> float:
    """Return by how much motor torques are older than their samples, s: half of the period through which they are held.

    A motor holds its demand through a control period and gives, at its end, what the middle needed, less what its
    tachometer loop takes back: τ(t) - τ'·a - k_v d̈·a. The age a is the one that fits the measured torques, with all
    units and runs together; zero where the servo is not known.
    """
    known = [run for run in runs if run.servo is not None]
    late = np.concatenate([np.zeros(0), *(_change_by_age(run) for run in known)])
    missed = np.concatenate([np.zeros(0), *(_missed(run) for run in known)])
    longest = max((run.servo.period for run in known if run.servo is not None), default=0.0)
    return float(np.clip(late @ missed / max(late @ late, np.finfo(float).tiny), 0.0, longest))


def tachometer_gain(run: Telemetry) -> Array | float:
    """Return k_v of the loop inside the motors, N·m·s/rad; zero where the servo is not known."""
    return 0.0 if run.servo is None or run.cluster is None else run.servo.bandwidth * run.cluster.gimbal_axis_inertia


def servo_answers(grid: Grid, hooks: Sequence[Hooks], effects: Sequence[Array]) -> list[Array]:
    """Return what is compared of the predicted answers to the commands in every run, each of shape (P, K, 3), rad.

    Args:
        grid: the runs; they carry commands.
        hooks: the effects in the model.
        effects: their parameters, shapes (P, Q).
    """
    pairs = list(zip(hooks, effects, strict=True))
    sets = max([1, *(len(value) for value in effects)])
    lag = np.zeros((sets, 6)) + sum((hook.servo_lag(value) for hook, value in pairs), np.zeros((1, 6)))
    gimbals, cluster = effective_gimbals(grid, hooks, effects), grid.cluster
    assert gimbals is not None
    assert cluster is not None
    answers = []
    for index, run in enumerate(grid.runs):
        friction = np.zeros((1, 1, 6))
        for hook, value in pairs:
            friction = hook.motor_torque(friction, value, ticks_of(run).gimbal_rate[None])
        against = (friction - _further_load(grid, gimbals, index)) / cluster.gimbal_axis_inertia
        answers.append(shown(run, answer(run, lag, np.broadcast_to(against, (sets, len(ticks_of(run).time), 6)))))
    return answers


def shown(run: Telemetry, angle: Array) -> Array:
    """Return what is compared of gimbal angles, shape (..., K, 3), rad: in the directions that hold no load.

    The servo is fed forward the load at a body rate that was planned and is not sent; what it misses by that lies in
    the three directions that a body rate loads.

    Args:
        run: with gimbal angles.
        angle: at its samples, shape (..., K', 6), rad.
    """
    free, keep = unloaded(run), followed(run)
    beside = np.matvec(free, np.matvec(np.swapaxes(free, -1, -2), angle))
    forgotten = np.exp(-float(np.median(np.diff(run.actuator_time))) / _COMPARED)
    changes = np.diff(beside[..., keep, :], axis=-2, prepend=beside[..., keep, :][..., :1, :])
    passed = lfilter([1.0], [1.0, -forgotten], changes, axis=-2)
    return np.asarray(np.matvec(np.swapaxes(free[keep], -1, -2), passed))


def by_units(run: Telemetry, values: Array) -> Array:
    """Return the gimbal angles to which what is compared belongs, shape (K, 6), of values of shape (K, 3), rad."""
    return np.asarray(np.einsum("kui,ki->ku", unloaded(run)[followed(run)], values))


@lru_cache(maxsize=_REMEMBERED)
def unloaded(run: Telemetry) -> Array:
    """Return the directions in which gimbal angles show nothing of a load by a body rate, shape (K', 6, 3).

    The servo answers a load as late as ω_b / ω_n²: the directions are those of the angles then.
    """
    cluster, servo = run.cluster, run.servo
    assert cluster is not None
    assert servo is not None
    before = run.actuator_time - servo.bandwidth / servo.stiffness
    angle = gimbal_motion(run)(np.maximum(before, run.actuator_time[0]))[..., None]
    transverse_B = np.cross(cluster.gimbal_axis_B, cluster.spin_axis_B)
    loaded = np.cos(angle) * transverse_B - np.sin(angle) * cluster.spin_axis_B
    return np.asarray(np.linalg.qr(loaded, mode="complete")[0][..., 3:])


def compared(run: Telemetry) -> Flags:
    """Return which actuator samples are compared, shape (K,).

    They lie within the gyro's, after the servos have taken up their work, and not beside a gap, over which the gimbals'
    acceleration is not known; nor in a gap of the gyro, over which the body's is not.
    """
    inside = (run.actuator_time >= run.gyro_time[0] + SETTLING) & covered_by(run.actuator_time, run.gyro_time)
    gap = np.concatenate([[False], gaps(run), [False]])
    return np.asarray(inside & ~gap[1:] & ~gap[:-1])


def gaps(run: Telemetry) -> Flags:
    """Return between which actuator samples others are missing, shape (K' - 1,)."""
    interval = np.diff(run.actuator_time)
    return np.asarray(interval > _MISSING * np.median(interval))


@lru_cache(maxsize=_REMEMBERED)
def followed(run: Telemetry) -> Flags:
    """Return which of the compared samples come before the first set point at the rate limit or gap, shape (K,).

    Behind either nobody knows what the servo was asked for.
    """
    assert run.servo is not None
    cut = (np.abs(set_point(run)) > _AT_LIMIT * run.servo.rate_limit).any(axis=1)
    missing = np.concatenate([[False], gaps(run)])
    lost = np.logical_or.accumulate(cut)[ticks_of(run).samples] | np.logical_or.accumulate(missing)
    return np.asarray(compared(run) & ~lost)


def _change_by_age(run: Telemetry) -> Array:
    """Return what an age of one second would change in a run's motor torques, shape (6 K,), N·m/s."""
    at = run.actuator_time[compared(run)]
    return np.asarray(-(_needed(run)(at, 1) + tachometer_gain(run) * gimbal_motion(run)(at, 2)).ravel())


def _missed(run: Telemetry) -> Array:
    """Return a run's motor torques less those that its measured motion needs, shape (6 K,), N·m."""
    keep = compared(run)
    return np.asarray((_of(run.gimbal_torque)[keep] - _needed(run)(run.actuator_time[keep])).ravel())


def _needed(run: Telemetry) -> CubicSpline:
    """Return the torque that a run's gimbals need by its measured motion, (6,), N·m."""
    cluster, time = run.cluster, run.actuator_time
    assert cluster is not None
    motion, body = gimbal_motion(run), body_motion(run)(np.clip(time, run.gyro_time[0], run.gyro_time[-1]))
    transverse_B = np.cross(cluster.gimbal_axis_B, cluster.spin_axis_B)
    turned = np.cos(motion(time)) * (body @ transverse_B.T) - np.sin(motion(time)) * (body @ cluster.spin_axis_B.T)
    return CubicSpline(time, cluster.gimbal_axis_inertia * motion(time, 2) - cluster.rotor_momentum * turned)


def _further_load(grid: Grid, gimbals: Gimbals, run: int) -> Array:
    """Return the load of units as they are less that of telemetry, at a run's ticks, shape (P, N, 6), N·m."""
    if gimbals is grid.gimbals or grid.gimbals is None:
        return np.zeros((1, 1, 6))
    time = grid.node_time[run]
    body_rate = body_motion(grid.runs[run])(time)
    further = _load(gimbals, body_rate, run) - _load(grid.gimbals, body_rate, run)
    at = np.clip(ticks_of(grid.runs[run]).time, time[0], time[-1])
    return np.asarray(CubicSpline(time, further, axis=1)(at))


def _load(gimbals: Gimbals, body_rate: Array, run: int) -> Array:
    """Return Js Ω ω·t of a run's gimbals at the nodes, shape (P, M + 1, 6), N·m."""
    return np.asarray(_of_run(gimbals.rotor_momentum, run) * _along(gimbals, body_rate, run)[1])


def _along(gimbals: Gimbals, body_rate: Array, run: int) -> tuple[Array, Array]:
    """Return ω·s and ω·t of a run's gimbals at the nodes, each of shape (P, M + 1, 6), rad/s."""
    spin_B = np.swapaxes(gimbals.spin_axis_B, -1, -2)
    transverse_B = np.swapaxes(np.cross(gimbals.gimbal_axis_B, gimbals.spin_axis_B), -1, -2)
    angle = _of_run(gimbals.angle, run)
    along_spin, along_transverse = body_rate @ spin_B, body_rate @ transverse_B
    spinning = np.cos(angle) * along_spin + np.sin(angle) * along_transverse
    return spinning, np.cos(angle) * along_transverse - np.sin(angle) * along_spin


def _frictionless(grid: Grid, gimbals: Gimbals, body_rate: Array, run: int) -> Array:
    """Return the torque that a run's gimbals need at the nodes, shape (P, M + 1, 6), N·m."""
    cluster, time = grid.cluster, grid.node_time[run]
    assert cluster is not None
    gimbal_B = np.swapaxes(gimbals.gimbal_axis_B, -1, -2)
    spinning, turned = _along(gimbals, body_rate, run)
    acceleration = gimbal_motion(grid.runs[run])(time, 2) + _slopes(time, body_rate) @ gimbal_B
    own = cluster.rotor_transverse_inertia - cluster.rotor_spin_inertia
    load = (_of_run(gimbals.rotor_momentum, run) - own * spinning) * turned
    return np.asarray(cluster.gimbal_axis_inertia * acceleration - load)


def _slopes(time: Array, values: Array) -> Array:
    return np.asarray(CubicSpline(time, values, axis=-2)(time, 1))


def _of_run(values: Array, run: int) -> Array:
    """Return what stands along the grid at the nodes of one run, shape (P, M + 1, 6)."""
    return values[run if len(values) > 1 else 0, :, ::2]


def _of(channel: UnitSeries | None) -> UnitSeries:
    assert channel is not None
    return channel
