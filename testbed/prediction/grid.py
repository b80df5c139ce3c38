"""The measured runs of a data set on the grid of their integration, side by side.

Arrays have the runs on their first axis and parameter sets on their second: (R, P, ...). What does not depend on
parameters has P = 1.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from testbed.arrays import Array, Series, Units
from testbed.cmg.cluster import Cluster
from testbed.errors import InputError
from testbed.estimation.telemetry import Telemetry, covered_part

LONGEST_STEP = 1.0 / 64.0
"""s. The motions of 1 rad/s and 5 Hz that such platforms make are integrated to 1e-7 rad/s with it (a test says so)."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Gimbals:
    """The CMG units along the grid, as telemetry and parameters have them.

    Attributes:
        angle: d, shape (R, P, T, M), rad.
        rate: ḋ, shape (R, P, T, M), rad/s.
        rotor_momentum: Js·Ω, shape (R, P, T, M), N·m·s.
        gimbal_axis_B: g, shape (P, M, 3), body axes.
        spin_axis_B: s at gimbal angle zero, shape (P, M, 3), body axes.
    """

    angle: Array
    rate: Array
    rotor_momentum: Array
    gimbal_axis_B: Array
    spin_axis_B: Array


@dataclass(frozen=True, kw_only=True, eq=False)
class Grid:
    """Runs side by side; each has its own step, all have the same number of steps.

    Attributes:
        runs: telemetry of each, only what the actuators' telemetry covers.
        time: every half step, shape (R, T), s, T = 2M + 1; even entries are the nodes.
        step: of each run, shape (R,), s.
        cluster: the units; None for a platform that has none or does not send its gimbal angles.
        gimbals: as telemetry has them; None likewise.
        cluster_momentum_B: h as the platform reports it where gimbal angles are not sent, shape (R, 1, T, 3), N·m·s.
        applied_torque_B: shape (R, 1, L + T, 3), N·m; also at the L half steps before the first sample that telemetry
            covers in every run, because actuators that are slow still respond to them.
        follows_commands: whether the gimbals follow their commands but for a lag, so that rates can be predicted.
    """

    runs: tuple[Telemetry, ...]
    time: Array
    step: Series
    cluster: Cluster | None
    gimbals: Gimbals | None
    cluster_momentum_B: Array
    applied_torque_B: Array
    follows_commands: bool = False

    @property
    def node_time(self) -> Array:
        """Ends of the steps, shape (R, M + 1), s."""
        return self.time[:, ::2]


def grid_of(telemetry: Sequence[Telemetry], longest_step: float = LONGEST_STEP) -> Grid:
    """Put runs on the grid of their integration.

    Args:
        telemetry: of the runs, at least one; all with the same channels.
        longest_step: s.

    Raises:
        InputError: too few samples in a run, or runs whose channels differ.
    """
    runs = tuple(covered_part(run) for run in telemetry)
    _require_alike(runs)
    spans = np.array([run.gyro_time[-1] - run.gyro_time[0] for run in runs])
    steps = max(2, math.ceil(spans.max() / min(longest_step, _resolving_step(runs))))
    time = np.stack([np.linspace(run.gyro_time[0], run.gyro_time[-1], 2 * steps + 1) for run in runs])
    cluster = runs[0].cluster if runs[0].gimbal_angle is not None else None
    return Grid(
        runs=runs,
        time=time,
        step=spans / steps,
        cluster=cluster,
        gimbals=None if cluster is None else _gimbals(runs, cluster, time),
        cluster_momentum_B=_sampled(runs, "cluster_momentum", time),
        applied_torque_B=_sampled(runs, "applied_torque", _with_lead(runs, time)),
    )


def unit_count(grid: Grid) -> int:
    """Return M, how many units the runs have; none of a platform that does not send its gimbal angles."""
    return 0 if grid.cluster is None else len(grid.cluster.rotor_momentum)


def at_nodes(values: Array, run: int) -> Array:
    """Return what stands along the grid at the nodes of one run, shape (P, N + 1, M)."""
    return values[run if len(values) > 1 else 0, :, ::2]


def telemetry_spline(run: Telemetry, channel: str) -> CubicSpline:
    """Return the cubic spline through a run's samples of an actuator channel that it has."""
    return CubicSpline(run.actuator_time, getattr(run, channel))


def _require_alike(runs: Sequence[Telemetry]) -> None:
    for channel in ("gimbal_angle", "rotor_momentum", "cluster_momentum", "applied_torque"):
        if len({getattr(run, channel) is None for run in runs}) > 1:
            raise InputError(f"some runs have {channel} and others do not; give runs with the same channels")


def _resolving_step(runs: Sequence[Telemetry]) -> float:
    """Return the longest step, s, that sees every sample of an applied torque, which may jump from one to the next."""
    if runs[0].applied_torque is None:
        return math.inf
    return 2.0 * min(float(np.median(np.diff(run.actuator_time))) for run in runs)


def _with_lead(runs: Sequence[Telemetry], time: Array) -> Array:
    """Return the grid's times with those half steps before them that the actuators' telemetry covers in every run."""
    if runs[0].applied_torque is None:
        return time
    half = time[:, 1] - time[:, 0]
    covered = time[:, 0] - [run.actuator_time[0] for run in runs]
    before = np.arange(-math.floor((covered / half).min()), 0)
    return np.concatenate([time[:, :1] + half[:, None] * before, time], axis=1)


def _gimbals(runs: Sequence[Telemetry], cluster: Cluster, time: Array) -> Gimbals:
    splines = [CubicSpline(run.actuator_time, np.unwrap(_angles(run), axis=0)) for run in runs]
    pairs = list(zip(splines, time, strict=True))
    return Gimbals(
        angle=np.stack([spline(at) for spline, at in pairs])[:, None],
        rate=np.stack([spline(at, 1) for spline, at in pairs])[:, None],
        rotor_momentum=np.stack(
            [_rotor_momentum(run, cluster.rotor_momentum, at) for run, at in zip(runs, time, strict=True)]
        )[:, None],
        gimbal_axis_B=cluster.gimbal_axis_B[None],
        spin_axis_B=cluster.spin_axis_B[None],
    )


def _angles(run: Telemetry) -> Array:
    assert run.gimbal_angle is not None
    return run.gimbal_angle


def _rotor_momentum(run: Telemetry, nominal: Units, time: Series) -> Array:
    if run.rotor_momentum is None:
        return np.tile(nominal, (len(time), 1))
    return np.asarray(telemetry_spline(run, "rotor_momentum")(time))


def _sampled(runs: Sequence[Telemetry], channel: str, time: Array) -> Array:
    """Return a channel along the grid, shape (R, 1, T, 3); zero where the runs do not have it or it is not in use."""
    unused = channel == "cluster_momentum" and runs[0].gimbal_angle is not None
    if unused or getattr(runs[0], channel) is None:
        return np.zeros((len(runs), 1, time.shape[1], 3))
    return np.stack([telemetry_spline(run, channel)(at) for run, at in zip(runs, time, strict=True)])[:, None]
