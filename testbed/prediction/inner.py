"""What the gimbals' inner telemetry should have shown: motor torques, and gimbal rates against what was asked of them.

The gimbal's own motion is measured, so that its equation of motion is not integrated but read:
τ = (Jg + Jt)(d̈ + g·ω̇) - Js Ω ω·t + (Jt - Js)(ω·s)(ω·t), and friction beside it.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.interpolate import CubicSpline

from testbed.arrays import Array, Flags, Series
from testbed.estimation.telemetry import Telemetry
from testbed.prediction.grid import Gimbals, Grid
from testbed.prediction.hooks import Hooks
from testbed.prediction.integration import effective_gimbals
from testbed.prediction.smooth import Smooth

SETTLING = 0.1
"""s. How long a servo needs to take up its work: what the motors do until then is not compared."""


def has_torques(grid: Grid) -> bool:
    """Return whether the runs carry motor torques that can be predicted."""
    return grid.gimbals is not None and all(run.gimbal_torque is not None for run in grid.runs)


def has_commands(grid: Grid) -> bool:
    """Return whether the runs carry the rates that were asked of the gimbals."""
    return grid.gimbals is not None and all(run.gimbal_rate_command is not None for run in grid.runs)


def measured_torques(grid: Grid) -> list[Array]:
    """Return the motor torques of every run that are compared, each of shape (K, 6), N·m."""
    return [_of(run.gimbal_torque)[compared(run)] for run in grid.runs]


def measured_rates(grid: Grid) -> list[Array]:
    """Return the gimbals' mean rate between the compared samples of every run, each of shape (K - 1, 6), rad/s."""
    return [_mean_slopes(*_angles(run)) for run in grid.runs]


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
    torques = []
    for index, run in enumerate(grid.runs):
        time, at = grid.node_time[index], run.actuator_time[compared(run)]
        rate = _of_run(gimbals.rate, index)
        torque = CubicSpline(time, _frictionless(grid, gimbals, rates[index], index), axis=1)(at)
        gimbal_rate = CubicSpline(time, rate, axis=1)(at)
        for hook, value in zip(hooks, effects, strict=True):
            torque = hook.motor_torque(torque, value, gimbal_rate)
        torques.append(torque)
    return torques


def gimbal_rates(grid: Grid, hooks: Sequence[Hooks], effects: Sequence[Array]) -> list[Array]:
    """Return the predicted mean gimbal rates between samples of every run, each of shape (P, K - 1, 6), rad/s.

    Args:
        grid: the runs; they carry commands.
        hooks: the effects in the model.
        effects: their parameters, shapes (P, Q).
    """
    lag = sum((hook.servo_lag(value) for hook, value in zip(hooks, effects, strict=True)), np.zeros((1, 6)))
    return lagging_rates(grid, lag)


def lagging_rates(grid: Grid, lag: Array) -> list[Array]:
    """Return the mean rates of gimbals that follow their commands with a lag, each of shape (P, K - 1, 6), rad/s.

    Of the mean of a rate x behind a lag T of the command u, x̄ = ū - T Δx / Δt.

    Args:
        grid: the runs; they carry commands.
        lag: T, shape (P, 6), s.
    """
    return [_commanded_rates(run, time, lag) for run, time in zip(grid.runs, grid.time, strict=True)]


def compared(run: Telemetry) -> Flags:
    """Return which actuator samples lie within the gyro's and after the servos have taken up their work, shape (K,)."""
    return np.asarray((run.actuator_time >= run.gyro_time[0] + SETTLING) & (run.actuator_time <= run.gyro_time[-1]))


def _frictionless(grid: Grid, gimbals: Gimbals, body_rate: Array, run: int) -> Array:
    """Return the torque that a run's gimbals need at the nodes, shape (P, M + 1, 6), N·m."""
    cluster, time = grid.cluster, grid.node_time[run]
    assert cluster is not None
    spin_B, gimbal_B = (np.swapaxes(axes, -1, -2) for axes in (gimbals.spin_axis_B, gimbals.gimbal_axis_B))
    transverse_B = np.swapaxes(np.cross(gimbals.gimbal_axis_B, gimbals.spin_axis_B), -1, -2)
    angle = _of_run(gimbals.angle, run)
    along_spin, along_transverse = body_rate @ spin_B, body_rate @ transverse_B
    turned = np.cos(angle) * along_transverse - np.sin(angle) * along_spin
    spinning = np.cos(angle) * along_spin + np.sin(angle) * along_transverse
    acceleration = _slopes(time, _of_run(gimbals.rate, run)) + _slopes(time, body_rate) @ gimbal_B
    own = cluster.rotor_transverse_inertia - cluster.rotor_spin_inertia
    load = (_of_run(gimbals.rotor_momentum, run) - own * spinning) * turned
    return np.asarray(cluster.gimbal_axis_inertia * acceleration - load)


def _commanded_rates(run: Telemetry, time: Series, lag: Array) -> Array:
    at, _ = _angles(run)
    command = CubicSpline(run.actuator_time, _of(run.gimbal_rate_command))
    rates = _mean_slopes(at, command.antiderivative()(at))[None]
    if not np.any(lag):
        return rates
    sets = lag.reshape(-1)
    asked = np.tile(command(time).T[..., None], (len(lag), 1, 1))
    shown = Smooth(time, asked).at(at, sets, np.zeros(len(sets)))[..., 0]
    behind = np.moveaxis(shown.reshape(len(lag), 6, -1), 1, 2)
    return rates - lag[:, None] * _mean_slopes(at, behind)


def _angles(run: Telemetry) -> tuple[Series, Array]:
    """Return the times and the angles of the samples that are compared."""
    keep = compared(run)
    return run.actuator_time[keep], np.unwrap(_of(run.gimbal_angle), axis=0)[keep]


def _mean_slopes(time: Series, values: Array) -> Array:
    """Return the differences of values, shape (..., K, 6), over those of their times, shape (..., K - 1, 6)."""
    return np.asarray(np.diff(values, axis=-2) / np.diff(time)[:, None])


def _slopes(time: Series, values: Array) -> Array:
    return np.asarray(CubicSpline(time, values, axis=-2)(time, 1))


def _of_run(values: Array, run: int) -> Array:
    """Return what stands along the grid at the nodes of one run, shape (P, M + 1, 6)."""
    return values[run if len(values) > 1 else 0, :, ::2]


def _of(channel: Array | None) -> Array:
    assert channel is not None
    return channel
