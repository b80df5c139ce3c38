"""The torques that the gimbals' motors should have given.

The gimbal's own motion is measured, so that its equation of motion is not integrated but read:
τ = (Jg + Jt)(d̈ + g·ω̇) - Js Ω ω·t + (Jt - Js)(ω·s)(ω·t), and friction beside it.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from functools import lru_cache

import numpy as np
from scipy.interpolate import CubicSpline

from testbed.arrays import Array, Series, UnitSeries
from testbed.estimation.telemetry import GimbalRun, GimbalTelemetry
from testbed.prediction.compared import torques_compared
from testbed.prediction.grid import Gimbals, Grid, at_nodes
from testbed.prediction.hooks import Hooks
from testbed.prediction.integration import effective_gimbals
from testbed.prediction.smooth import Smooth, node_slopes
from testbed.prediction.smoothed import body_motion, direction_of, gimbal_motion
from testbed.prediction.unit_axes import along_units, rate_across

_REMEMBERED = 64
"""Runs of which what no parameter changes is kept: fitted and held-out runs of a data set, with the gyro's errors of
some models; of more than 64 runs they are worked out again."""


def has_torques(grid: Grid) -> bool:
    """Return whether the runs carry motor torques that can be predicted."""
    return len(list(_with_torques(grid.gimbal_runs))) == len(grid.runs)


def measured_torques(grid: Grid) -> list[Array]:
    """Return the motor torques of every run that are compared, each of shape (K, M), N·m."""
    return [torque[torques_compared(run)] for run, torque in _with_torques(grid.gimbal_runs)]


def motor_torques(grid: Grid, hooks: Sequence[Hooks], effects: Sequence[Array], rates: Array) -> list[Array]:
    """Return the predicted motor torques of every run, each of shape (P, K, 6), N·m.

    Args:
        grid: the runs; they carry motor torques.
        hooks: the effects in the model.
        effects: their parameters, shapes (P, Q).
        rates: ω at the grid's nodes, shape (R, P, M + 1, 3), rad/s.
    """
    gimbals = effective_gimbals(grid, hooks, effects)
    if gimbals is None:
        return []
    latency = torque_latency(grid.gimbal_runs)
    torques = []
    for index, run in enumerate(grid.gimbal_runs):
        at, time = _torque_time(run), grid.node_time[index]
        needed = _frictionless(run, time, gimbals, rates[index], index)
        torque = Smooth(time, needed).between(np.broadcast_to(at - latency, (len(needed), len(at))))
        torque = torque - latency * tachometer_gain(run.gimbals) * gimbal_motion(run)(at, 2)
        gimbal_rate = gimbal_motion(run)(at, 1)[None]
        for hook, value in zip(hooks, effects, strict=True):
            torque = hook.motor_torque(torque, value, gimbal_rate)
        torques.append(torque)
    return torques


@lru_cache(maxsize=_REMEMBERED)
def torque_latency(runs: tuple[GimbalRun, ...]) -> float:
    """Return the latency of the motor torques' samples, s: half of the period through which they are held.

    A motor holds its demand through a control period and gives, at its end, what the middle needed, less the damping
    of its tachometer loop: τ(t) - τ'·a - k_v d̈·a. The latency a is the one that fits the measured torques, with all
    units and runs together, beside any friction of each; zero where the servo is not known.
    """
    periods = [run.gimbals.servo.period for run, _ in _with_torques(runs) if run.gimbals.servo is not None]
    if not periods:
        return 0.0
    latency, _ = _simple_fit(runs)
    return min(max(latency, 0.0), max(periods))


def unexplained_torques(runs: tuple[GimbalRun, ...]) -> list[Array]:
    """Return the compared torques of every run less what motion, latency and friction need, shape (K, M), N·m."""
    return _simple_fit(runs)[1]


@lru_cache(maxsize=_REMEMBERED)
def _simple_fit(runs: tuple[GimbalRun, ...]) -> tuple[float, list[Array]]:
    """Return the latency, s, that fits the torques of all runs beside each unit's friction, and the residual."""
    sent = list(_with_torques(runs))
    columns = [np.column_stack([_change_by_latency(run), _friction(run)]) for run, _ in sent]
    missed = [_missed(run, torque) for run, torque in sent]
    every = np.concatenate(columns)
    scale = np.maximum(np.linalg.norm(every, axis=0), np.finfo(float).tiny)
    found = np.linalg.lstsq(every / scale, np.concatenate(missed), rcond=None)[0] / scale
    left = [each - own @ found for each, own in zip(missed, columns, strict=True)]
    return float(found[0]), [each.reshape(-1, torque.shape[1]) for each, (_, torque) in zip(left, sent, strict=True)]


def tachometer_gain(gimbals: GimbalTelemetry) -> Array | float:
    """Return k_v of the loop inside the motors, N·m·s/rad; zero where the servo is not known."""
    return 0.0 if gimbals.servo is None else gimbals.servo.bandwidth * gimbals.cluster.gimbal_axis_inertia


def _change_by_latency(run: GimbalRun) -> Array:
    """Return what a latency of one second would change in a run's motor torques, shape (M K,), N·m/s."""
    at = _torque_time(run)
    return np.asarray(-(_needed(run)(at, 1) + tachometer_gain(run.gimbals) * gimbal_motion(run)(at, 2)).ravel())


def _friction(run: GimbalRun) -> Array:
    """Return what viscous and dry friction of one unit each would need of the motors, shape (M K, 2 M)."""
    rate = gimbal_motion(run)(_torque_time(run), 1)
    units = rate.shape[1]
    each = [np.eye(units) * of[:, None] for of in (rate, direction_of(rate))]
    return np.concatenate(each, axis=2).reshape(-1, 2 * units)


def _missed(run: GimbalRun, torque: UnitSeries) -> Array:
    """Return a run's motor torques less those that its measured motion needs, shape (M K,), N·m."""
    return np.asarray((torque[torques_compared(run)] - _needed(run)(_torque_time(run))).ravel())


def _torque_time(run: GimbalRun) -> Series:
    """Return when the angles show what the compared torques are of, shape (K,), s; within the gyro's samples."""
    return np.clip(run.actuator_time[torques_compared(run)] + run.gimbals.angles_late, *run.gyro_time[[0, -1]])


@lru_cache(maxsize=_REMEMBERED)
def _needed(run: GimbalRun) -> CubicSpline:
    """Return the torque that a run's gimbals need by its measured motion, (M,), N·m."""
    cluster, time = run.gimbals.cluster, run.actuator_time
    motion, body = gimbal_motion(run), body_motion(run)(np.clip(time, run.gyro_time[0], run.gyro_time[-1]))
    _, turned = rate_across(cluster.gimbal_axis_B, cluster.spin_axis_B, motion(time), body)
    return run.through(cluster.gimbal_axis_inertia * motion(time, 2) - cluster.rotor_momentum * turned)


def _frictionless(run: GimbalRun, time: Array, gimbals: Gimbals, body_rate: Array, index: int) -> Array:
    """Return the torque that a run's gimbals need at the nodes, shape (P, N, M), N·m."""
    cluster = gimbals.cluster
    gimbal_B = np.swapaxes(gimbals.gimbal_axis_B, -1, -2)
    spinning, turned = along_units(gimbals, body_rate, index)
    acceleration = gimbal_motion(run)(time, 2) + node_slopes(body_rate, time[1] - time[0]) @ gimbal_B
    own = cluster.rotor_transverse_inertia - cluster.rotor_spin_inertia
    load = (at_nodes(gimbals.rotor_momentum, index) - own * spinning) * turned
    return np.asarray(cluster.gimbal_axis_inertia * acceleration - load)


def _with_torques(runs: Iterable[GimbalRun]) -> Iterator[tuple[GimbalRun, UnitSeries]]:
    """Yield the runs that carry motor torques, with these, shape (K, M), N·m."""
    for run in runs:
        if run.gimbals.torque is not None and np.isfinite(run.gimbals.torque).all(axis=1).any():
            yield run, run.gimbals.torque
