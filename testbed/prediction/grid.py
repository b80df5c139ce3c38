"""The measured runs of a data set on the grid of their integration, side by side.

Arrays have the runs on their first axis and parameter sets on their second: (R, P, ...). What does not depend on
parameters has P = 1.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from testbed.arrays import Array, Flags, Series
from testbed.cmg.cluster import Cluster
from testbed.cmg.wheels import Wheels, no_wheels
from testbed.errors import InputError
from testbed.estimation.held import step_within
from testbed.estimation.telemetry import (
    ALL_AXES,
    CommandedRun,
    GimbalRun,
    Telemetry,
    Thrusters,
    covered_part,
    has_gimbals,
    is_commanded,
)
from testbed.prediction.tachometer import without_tachometer_noise
from testbed.prediction.wheel_impulses import ImpulseNoise

_ALIKE = 2.0
"""Times the shortest run of a part is its longest: as all take as many steps, at most half of them are too many."""
_WASTED = 1.5
"""Times as many steps as the runs need, from which they are integrated in parts: each costs what calls cost."""
PAUSE = 1.0
"""s between the runs, laid end to end: fifty times the spread of a touch, so that none is in two runs, and an estimated
instant stays in its own."""
LONGEST_STEP = 1.0 / 64.0
"""s. The motions of 1 rad/s and 5 Hz that such platforms make are integrated to 1e-7 rad/s with it (a test says so)."""
_STEPS_A_SAMPLE = 8.0
"""Where samples come more slowly than so many steps, steps are longer: no faster motion shows. A platform of 100 kg on
orbit, sampled at 4 Hz, turns alike to 3e-13 rad/s with 1/32 s, and with a flexible appendage of 4 Hz to 1e-7.

With four a sample a diagnosis at 10 Hz took 0.8 of the time, and a next flight that turns fast promised a drag 70 sigma
and showed it by 2 (tests/unit/test_next_flights.py)."""
_ROUNDING = 1e-9
"""Steps by which a whole number of them may be missed: times are differences of numbers with sixteen digits."""
_LONGEST_OF_ALL = 1.0 / 32.0
"""s, however slow the samples are: with it a touch, of 20 ms, still gives its angular impulse to a thousandth."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Gimbals:
    """M CMG units along the grid, as telemetry and parameters have them.

    Attributes:
        cluster: the units; their inertias, which no parameter changes.
        angle: d, shape (R, P, T, M), rad.
        rate: ḋ, shape (R, P, T, M), rad/s.
        rotor_momentum: Js·Ω, shape (R, P, T, M), N·m·s.
        gimbal_axis_B: g, shape (P, M, 3), body axes.
        spin_axis_B: s at gimbal angle zero, shape (P, M, 3), body axes.
    """

    cluster: Cluster
    angle: Array
    rate: Array
    rotor_momentum: Array
    gimbal_axis_B: Array
    spin_axis_B: Array


@dataclass(frozen=True, kw_only=True, eq=False)
class Grid:
    """Runs side by side; each has its own step, all have the same number of steps; those of `parts` are alike.

    Attributes:
        runs: telemetry of each, only what the actuators' telemetry covers.
        time: every half step, shape (R, T), s, T = 2M + 1; even entries are the nodes.
        step: of each run, shape (R,), s.
        gimbals: as telemetry has them; None for a platform that has none or does not send its gimbal angles.
        wheel_momentum: Jw Ω of the reaction wheels, shape (R, 1, T, W), N·m·s.
        wheels: the array that they are; without any, none.
        cluster_momentum_B: h of the wheels, or as the platform reports it where neither gimbal angles nor wheel speeds
            are sent, shape (R, 1, T, 3), N·m·s.
        applied_torque_B: shape (R, 1, L + T, 3), N·m; also at the L half steps before the first sample that telemetry
            covers in every run, because actuators that are slow still respond to them.
        thrust: of single actuators as commanded, at the times of `applied_torque_B`, shape (R, 1, L + T, M), N; None
            where their commands are not known.
        follows_commands: whether the gimbals follow their commands but for a lag, so that rates can be predicted.
        wheel_noise: in what noise the impulses of the wheels' motors are compared; None where they are not.
        number: of each run among all that are fitted together, shape (R,).
        earlier: how long the runs before it last together, shape (R,), s.
        longest_step: s.
    """

    runs: tuple[Telemetry, ...]
    time: Array
    step: Series
    gimbals: Gimbals | None
    wheel_momentum: Array
    wheels: Wheels
    cluster_momentum_B: Array
    applied_torque_B: Array
    thrust: Array | None = None
    follows_commands: bool = False
    wheel_noise: ImpulseNoise | None = None
    number: NDArray[np.intp]
    earlier: Series
    longest_step: float

    @cached_property
    def parts(self) -> tuple[Grid, ...]:
        """The runs on grids of their own by length; the grid itself where their lengths are alike."""
        spans = np.ptp(self.time, axis=1)
        if len(spans) * spans.max() <= _WASTED * spans.sum():
            return (self,)
        parts, left = [], np.argsort(-spans, kind="stable")
        while left.size:
            alike = _ALIKE * spans[left] > spans[left[0]]
            parts.append(self._part(np.sort(left[alike])))
            left = left[~alike]
        return tuple(parts)

    @cached_property
    def sample_time(self) -> Array:
        """Times of the gyro's samples of each run, shape (R, N), s; of one with fewer than N the last one again."""
        most = max(len(run.gyro_time) for run in self.runs)
        return np.stack([np.pad(run.gyro_time, (0, most - len(run.gyro_time)), mode="edge") for run in self.runs])

    @cached_property
    def measured_rate(self) -> Array:
        """ω at the nodes on lines between the gyro's samples, of each run, shape (R, M + 1, 3), rad/s."""
        pairs = zip(self.node_time, self.runs, strict=True)
        return np.stack(
            [
                np.column_stack([np.interp(nodes, run.gyro_time, axis) for axis in run.body_rate.T])
                for nodes, run in pairs
            ]
        )

    @cached_property
    def gyro_interval(self) -> Series:
        """The usual one between the gyro's samples, of each run, shape (R,), s."""
        return np.array([np.median(np.diff(run.gyro_time)) for run in self.runs])

    @cached_property
    def actuator_interval(self) -> Series:
        """The usual one between the actuators' samples, of each run, shape (R,), s."""
        return np.array([np.median(np.diff(run.actuator_time)) for run in self.runs])

    def _part(self, which: NDArray[np.intp]) -> Grid:
        return replace(
            grid_of([self.runs[index] for index in which], self.longest_step),
            follows_commands=self.follows_commands,
            wheel_noise=self.wheel_noise,
            number=self.number[which],
            earlier=self.earlier[which],
        )

    @property
    def thrusters(self) -> Thrusters | None:
        """Where the single actuators are, and which way they push; None where their commands are not known."""
        return self.runs[0].thrusters

    @property
    def torque_held(self) -> bool:
        """Whether an applied torque is held from sample to sample."""
        return self.runs[0].torque_held

    @property
    def momentum_held(self) -> bool:
        """Whether momenta go along chords, because the wheels' motors hold their torque between samples."""
        return self.runs[0].momentum_held

    @property
    def live(self) -> Flags:
        """About which body axes each run turns, shape (R, 3)."""
        return np.array([run.live for run in self.runs])

    @property
    def turns_freely(self) -> bool:
        """Whether no run is held by a bearing about any axis."""
        return all(run.live == ALL_AXES for run in self.runs)

    @property
    def node_time(self) -> Array:
        """Ends of the steps, shape (R, M + 1), s."""
        return self.time[:, ::2]

    @property
    def gimbal_runs(self) -> tuple[GimbalRun, ...]:
        """The runs where they send their gimbal angles, else none."""
        return tuple(filter(has_gimbals, self.runs))

    @property
    def commanded_runs(self) -> tuple[CommandedRun, ...]:
        """The runs that carry the commanded gimbal rates, and whose servo is known."""
        return tuple(filter(is_commanded, self.runs))


def grid_of(telemetry: Sequence[Telemetry], longest_step: float | None = None) -> Grid:
    """Put runs on the grid of their integration.

    Args:
        telemetry: of the runs, at least one; all with the same channels.
        longest_step: s; as their samples ask for where None.

    Raises:
        InputError: too few samples in a run, or runs whose channels differ.
    """
    runs = tuple(covered_part(run) for run in telemetry)
    _require_alike(runs)
    runs = tuple(without_tachometer_noise(runs))
    longest_step = _longest_step(runs) if longest_step is None else longest_step
    spans = np.array([run.gyro_time[-1] - run.begin for run in runs])
    steps = max(2, math.ceil(spans.max() / _step_within_samples(runs, longest_step) - _ROUNDING))
    time = np.stack([np.linspace(run.begin, run.gyro_time[-1], 2 * steps + 1) for run in runs])
    wheel_momentum, wheels = _wheels(runs, time)
    reported_B = _of_all([_reported_momentum(run, at) for run, at in zip(runs, time, strict=True)], time)
    with_lead = _with_lead(runs, time)
    return Grid(
        runs=runs,
        time=time,
        step=spans / steps,
        gimbals=_gimbals(list(filter(has_gimbals, runs)), time),
        wheel_momentum=wheel_momentum,
        wheels=wheels,
        cluster_momentum_B=reported_B + wheel_momentum @ wheels.axis_B if wheels.axis_B.size else reported_B,
        applied_torque_B=_of_all(
            [_applied_torque(run, at) for run, at in zip(runs, with_lead, strict=True)], with_lead
        ),
        thrust=_thrust(runs, with_lead),
        number=np.arange(len(runs)),
        earlier=np.cumsum(spans) - spans,
        longest_step=longest_step,
    )


def with_late_angles(grid: Grid, late: float) -> Grid:
    """Return runs whose gimbals' angles are later than their torques, by so many seconds; the same where they are."""
    if all(run.gimbals.angles_late == late for run in grid.gimbal_runs):
        return grid
    runs = tuple(
        run if run.gimbals is None else replace(run, gimbals=replace(run.gimbals, angles_late=late))
        for run in grid.runs
    )
    return replace(grid, runs=runs)


def thruster_count(grid: Grid) -> int:
    """Return how many single actuators there are whose commands are known."""
    return 0 if grid.thrust is None else int(grid.thrust.shape[-1])


def unit_count(grid: Grid) -> int:
    """Return M, how many units the runs have; none of a platform that does not send its gimbal angles."""
    return 0 if grid.gimbals is None else grid.gimbals.angle.shape[-1]


def wheel_count(grid: Grid) -> int:
    """Return W, how many reaction wheels the runs have."""
    return len(grid.wheels.axis_B)


def begin_of_runs(grid: Grid) -> Series:
    """Return what has to be added to each run's times to lay the runs end to end, shape (R,), s; the first from 0."""
    return np.asarray(grid.earlier + PAUSE * grid.number - grid.time[:, 0])


def run_at(grid: Grid, instant: float) -> int:
    """Return the run in which an instant lies, s, counted in the runs laid end to end."""
    late = instant - begin_of_runs(grid)
    return int(np.flatnonzero(late >= grid.time[:, 0] - 0.5 * PAUSE)[-1])


def at_nodes(values: Array, run: int) -> Array:
    """Return what stands along the grid at the nodes of one run, shape (P, N, M) of N nodes and M units."""
    return values[run if len(values) > 1 else 0, :, ::2]


def _require_alike(runs: Sequence[Telemetry]) -> None:
    channels: dict[str, list[object]] = {
        "gimbal_angle": [run.gimbals for run in runs],
        "rotor_momentum": [run.gimbals and run.gimbals.rotor_momentum for run in runs],
        "wheel_speed": [run.wheels for run in runs],
        "cluster_momentum": [run.cluster_momentum for run in runs],
        "applied_torque": [run.applied_torque for run in runs],
        "motor_thrust": [run.thrust for run in runs],
        "an environment": [run.surroundings for run in runs],
    }
    for channel, of_runs in channels.items():
        if len({each is None for each in of_runs}) > 1:
            raise InputError(f"some runs have {channel} and others do not; give runs with the same channels")


def _longest_step(runs: Sequence[Telemetry]) -> float:
    """Return the longest step, s, for motions as fast as the samples of these runs can show."""
    interval = min(float(np.median(np.diff(time))) for run in runs for time in (run.gyro_time, run.actuator_time))
    return float(np.clip(interval / _STEPS_A_SAMPLE, LONGEST_STEP, _LONGEST_OF_ALL))


def _step_within_samples(runs: Sequence[Telemetry], longest_step: float) -> float:
    """Return the longest step, s, that sees every sample of an applied torque, which may jump from one to the next.

    Where it is held from sample to sample, half an interval holds whole steps: the motion has its corners at nodes if
    the gyro samples in phase.
    """
    if runs[0].applied_torque is None:
        return longest_step
    interval = min(float(np.median(np.diff(run.actuator_time))) for run in runs)
    if runs[0].torque_held:
        # What follows its jumps with a lag bends behind them: nodes farther apart than samples would not show it.
        read = min(float(np.median(np.diff(run.gyro_time))) for run in runs)
        return step_within(interval, min(longest_step, read))
    return min(longest_step, 2.0 * interval)


def _with_lead(runs: Sequence[Telemetry], time: Array) -> Array:
    """Return the grid's times with those half steps before them that the actuators' telemetry covers in every run."""
    if runs[0].applied_torque is None:
        return time
    half = time[:, 1] - time[:, 0]
    covered = time[:, 0] - [run.actuator_time[0] for run in runs]
    before = np.arange(-math.floor((covered / half).min()), 0)
    return np.concatenate([time[:, :1] + half[:, None] * before, time], axis=1)


def _gimbals(runs: Sequence[GimbalRun], time: Array) -> Gimbals | None:
    if not runs:
        return None
    cluster = runs[0].gimbals.cluster
    splines = [run.through(np.unwrap(run.gimbals.angle, axis=0)) for run in runs]
    pairs = list(zip(splines, time, strict=True))
    return Gimbals(
        cluster=cluster,
        angle=np.stack([spline(at) for spline, at in pairs])[:, None],
        rate=np.stack([spline(at, 1) for spline, at in pairs])[:, None],
        rotor_momentum=np.stack([_rotor_momentum(run, at) for run, at in zip(runs, time, strict=True)])[:, None],
        gimbal_axis_B=cluster.gimbal_axis_B[None],
        spin_axis_B=cluster.spin_axis_B[None],
    )


def _rotor_momentum(run: GimbalRun, time: Series) -> Array:
    spin = run.gimbals.rotor_momentum
    return np.tile(run.gimbals.cluster.rotor_momentum, (len(time), 1)) if spin is None else run.through(spin)(time)


def _reported_momentum(run: Telemetry, time: Series) -> Array | None:
    if run.cluster_momentum is None or run.gimbals is not None or run.wheels is not None:
        return None
    return np.asarray(run.momentum_through(run.cluster_momentum)(time))


def _applied_torque(run: Telemetry, time: Series) -> Array | None:
    return None if run.applied_torque is None else run.driven(run.applied_torque, time)


def _wheels(runs: Sequence[Telemetry], time: Array) -> tuple[Array, Wheels]:
    """Return the wheels' momenta along the grid, shape (R, 1, T, W), and the array."""
    sent = [(run, run.wheels) for run in runs if run.wheels is not None]
    if not sent:
        return np.zeros((len(runs), 1, 1, 0)), no_wheels()
    along = [run.momentum_through(wheels.best_momentum)(at) for (run, wheels), at in zip(sent, time, strict=True)]
    return np.stack(along)[:, None], sent[0][1].wheels


def _thrust(runs: Sequence[Telemetry], time: Array) -> Array | None:
    pairs = zip(runs, time, strict=True)
    along = [run.driven(run.thrust, at) for run, at in pairs if run.thrust is not None]
    return np.stack(along)[:, None] if len(along) == len(runs) else None


def _of_all(along: Sequence[Array | None], time: Array) -> Array:
    """Return a channel along the grid, shape (R, 1, T, 3); zero of runs that do not have it or do not use it."""
    parts = [np.zeros((len(at), 3)) if each is None else each for each, at in zip(along, time, strict=True)]
    return np.stack(parts)[:, None]
