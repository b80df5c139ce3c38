"""Predictions of the gyro's samples, and their exact derivatives with respect to every parameter."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import lru_cache
from itertools import compress
from typing import Any, TypeAlias

import numpy as np

from testbed.arrays import Array, Vectors3
from testbed.prediction.equations import COMPLEX_STEP
from testbed.prediction.grid import Grid
from testbed.prediction.gyro import acts_in_gyro, acts_on_clocks, gyro_errors, readings, reads_otherwise
from testbed.prediction.hooks import Hooks, overrides
from testbed.prediction.integration import GRIDS, Values, distinct_sets, motion_of, node_rates
from testbed.prediction.kernels import answers
from testbed.prediction.motor_torques import has_torques, motor_torques
from testbed.prediction.servo_response import servo_responses
from testbed.prediction.smoothed import body_motion, taken_off
from testbed.prediction.wheel_response import predicted_impulses

Predictor: TypeAlias = Callable[[Grid, Sequence[Hooks], Values], list[Array]]
"""From the runs, the effects and P parameter sets to blocks of predictions, each with the sets on its first axis."""

_AT_ONCE = 400_000
"""Instants of all runs and sets that are integrated together: beyond it memory grows and time does not fall."""
_FEWEST_SETS = 64
"""Of which a batch is made, however long the runs are: derivatives of a model by inertia, initial rate and effects, in
general fewer than 64 columns, stay in one batch."""


def predicted(grid: Grid, hooks: Sequence[Hooks], values: Values) -> list[Array]:
    """Return the predicted gyro samples of every run, each of shape (P, N, 3), rad/s.

    Args:
        grid: the runs.
        hooks: the effects in the model.
        values: parameter sets, P of them.

    Raises:
        InputError: the motion leaves the finite numbers.
    """
    return _of_parts(grid, values, lambda part, own: readings(part, hooks, own.effects, node_rates(part, hooks, own)))


def _of_parts(grid: Grid, values: Values, predict: Callable[[Grid, Values], list[Array]]) -> list[Array]:
    """Return blocks of all runs, each part of them integrated by itself."""
    if len(grid.parts) == 1:
        return predict(grid, values)
    by_part = [predict(part, values.of_runs(part.number)) for part in grid.parts]
    blocks: list[Array] = [np.empty(0)] * sum(map(len, by_part))
    for part, own in zip(grid.parts, by_part, strict=True):
        for index, block in enumerate(own):
            kind, run = divmod(index, len(part.runs))
            blocks[kind * len(grid.runs) + int(part.number[run])] = block
    return blocks


def without_gyro_errors(grid: Grid, hooks: Sequence[Hooks], values: Values) -> Grid:
    """Return the runs with the gyro errors that the effects in a model predict.

    The gimbals' channels are predicted with the body rate that the gyro shows. A late or biased gyro that is not
    modelled looks like friction, and the rate of another instant like a misalignment of a gimbal.

    Args:
        grid: the runs.
        hooks: the effects in the model.
        values: of its parameters, P = 1.
    """
    count, acting = len(grid.runs), any(acts_in_gyro(hook) or acts_on_clocks(hook) for hook in hooks)
    blocks = _of_parts(grid, values, lambda part, own: _gyro_errors(part, hooks, own)) if acting else []
    none: list[Vectors3 | None] = [None] * count
    errors, of_readings = blocks[:count] or none, blocks[count:] or none
    if all(run.gyro_error is error for run, error in zip(grid.runs, errors, strict=True)):
        return grid
    each = zip(grid.runs, errors, of_readings, strict=True)
    runs = tuple(replace(run, gyro_error=error, reading_error=reading) for run, error, reading in each)
    return replace(grid, runs=runs)


def _gyro_errors(grid: Grid, hooks: Sequence[Hooks], values: Values) -> list[Array]:
    """Return what each run's gyro is off by, and then the part that effects on its readings make, if there are any."""
    rates, misreading = node_rates(grid, hooks, values), list(map(reads_otherwise, hooks))
    errors = gyro_errors(grid, hooks, values.effects, rates)
    if any(misreading):
        some = list(compress(hooks, misreading)), list(compress(values.effects, misreading))
        errors += gyro_errors(grid, *some, rates)
    return errors


def predicted_channels(grid: Grid, hooks: Sequence[Hooks], values: Values) -> list[Array]:
    """Return all that is compared: every run's gyro samples, motor torques, servo responses, impulses of wheels.

    Blocks of shape (P, N, 3), (P, N, 6) or, of each wheel, (P, K, 1), in the units of the channel; block b belongs to
    run b modulo the runs. All but the gyro's are there if the runs carry what they are compared with.

    Args:
        grid: the runs.
        hooks: the effects in the model.
        values: parameter sets, P of them.

    Raises:
        InputError: the motion leaves the finite numbers.
    """
    blocks = _of_parts(grid, values, lambda part, own: _channels(part, hooks, own))
    sets = values.sets
    return [block if len(block) == sets else np.broadcast_to(block, (sets, *block.shape[1:])) for block in blocks]


def _channels(grid: Grid, hooks: Sequence[Hooks], values: Values) -> list[Array]:
    blocks = readings(grid, hooks, values.effects, node_rates(grid, hooks, values))
    for channels, shown in ((_torques, _shows_in_torques), (_responses, _acts_inside)):
        seen = list(map(shown, hooks))
        blocks += _of_sets(channels, grid, list(compress(hooks, seen)), list(compress(values.effects, seen)))
    return blocks


_Channels: TypeAlias = Callable[[Grid, Sequence[Hooks], Sequence[Array]], list[Array]]
"""From the runs, effects and their parameters to blocks of some channels of the actuators."""


def _of_sets(channels: _Channels, grid: Grid, hooks: Sequence[Hooks], effects: Sequence[Array]) -> Sequence[Array]:
    """Return the channels of sets most of which differ in what does not change them."""
    if not hooks:
        return _of_telemetry(channels, grid)
    distinct, place = distinct_sets(effects)
    blocks = channels(grid, hooks, distinct)
    return [np.broadcast_to(block, (len(distinct[0]), *block.shape[1:]))[place] for block in blocks]


@lru_cache(maxsize=2 * GRIDS)
def _of_telemetry(channels: _Channels, grid: Grid) -> tuple[Array, ...]:
    """Return channels without any effect that they show: no parameter of the body changes them."""
    return tuple(channels(grid, [], []))


def _torques(grid: Grid, hooks: Sequence[Hooks], effects: Sequence[Array]) -> list[Array]:
    """Return the gimbals' motor torques, with effects that act inside the units, or on what the gyro reads."""
    return motor_torques(grid, hooks, effects, _measured_rates(grid, hooks, effects)) if has_torques(grid) else []


def _responses(grid: Grid, hooks: Sequence[Hooks], effects: Sequence[Array]) -> list[Array]:
    """Return what gimbals and wheels make of their commands, with effects that act inside them."""
    responses = servo_responses(grid, hooks, effects) if grid.follows_commands else []
    return responses + ([] if grid.wheel_noise is None else predicted_impulses(grid, hooks, effects))


_INSIDE = ("motor_torque", "servo_lag", "gimbals", "wheel_impulse", "wheel_inertia_error", "wheel_lag", "wheel_delay")
"""Parts of the contract that change the channels of gimbals and wheels."""


def _acts_inside(hook: Hooks) -> bool:
    """Return whether an effect acts inside the units.

    All others leave servo responses and impulses as they are, and effects on the body the motor torques too: these hold
    less than a hundredth of the gyro's information on the body's motion, and errors of their own model must not count.
    """
    return hook.predicts_gimbals and overrides(hook, *_INSIDE)


def _shows_in_torques(hook: Hooks) -> bool:
    """Return whether an effect shows in the gimbals' motor torques.

    At zero momentum a gyro's scale or turned axis is the same as a different inertia, and only the motors, which work
    against ω, tell them apart. A gyro's delays move them no more than errors of their model do.
    """
    return _acts_inside(hook) or reads_otherwise(hook)


def _measured_rates(grid: Grid, hooks: Sequence[Hooks], effects: Sequence[Array]) -> Array:
    """Return ω at the nodes by the gyro, smoothed, less what its readings are off by, shape (R, P, M + 1, 3), rad/s.

    What was taken off of the readings by other values of the same effects is put back first.
    """
    rates, sets = [], max(map(len, effects), default=1)
    for run, time, number in zip(grid.runs, grid.node_time, grid.number.tolist(), strict=True):
        known = body_motion(run)(time)
        read: Array = np.broadcast_to(known, (sets, *known.shape))
        for hook, value in zip(hooks, effects, strict=True):
            read = hook.gyro_reading(read, value, time, number)
        rates.append(known + taken_off(run, time) + (known - read))
    return np.stack(rates)


def common_size(effects: Sequence[Array]) -> int:
    """Return the number of parameters that all runs share: θ, and those of the effects."""
    return 6 + sum(int(value.shape[-1]) for value in effects)


def predicted_with_derivatives(
    grid: Grid,
    hooks: Sequence[Hooks],
    values: Values,
    columns: range | None = None,
    predict: Predictor = predicted,
) -> tuple[list[Array], list[Array]]:
    """Return the prediction of one parameter set and its derivatives.

    Args:
        grid: the runs.
        hooks: the effects in the model.
        values: one parameter set, P = 1.
        columns: which derivatives; all of them where absent.
        predict: the gyro's samples alone, or all channels.

    Returns:
        Of every block the samples, shape (N, 3), rad/s, and ∂ω̄/∂(θ, effects, what is the run's own: ω₀, and where they
        are free the turn of its first attitude and the trim), shape (N, 3, C + own_size), with C from `common_size`, or
        the columns asked for.
    """
    wanted = range(common_size(values.effects) + values.own_size) if columns is None else columns
    parts = [_columns(grid, hooks, values, wanted[batch], predict) for batch in _batches(grid, len(wanted))]
    samples = [reading.real[0] for reading in parts[0]]
    by_block = zip(*parts, strict=True)
    return samples, [np.concatenate([_imaginary(part) for part in block], axis=-1) for block in by_block]


def derivatives_at(
    grid: Grid,
    hooks: Sequence[Hooks],
    values: Values,
    starts: Array,
    shown: Sequence[int],
    predict: Predictor = predicted,
) -> list[Array]:
    """Return ∂ω̄/∂(parameters of one more effect) at several values of them, of every block, shape (S, N, 3, K).

    Args:
        grid: the runs.
        hooks: the effects in the model, the further one last.
        values: one parameter set of the model without the further one, P = 1.
        starts: values of the further effect's parameters, shape (S, K), of which it is too small to move the body.
        shown: which parameters' derivatives are asked for; those of the others are zero.
        predict: the gyro's samples alone, or all channels.
    """
    steps = 1j * COMPLEX_STEP * np.eye(starts.shape[1])[shown]
    sets = (starts[:, None] + steps).reshape(-1, starts.shape[1])
    batches = [sets[batch] for batch in _batches(grid, len(sets))]
    parts = [predict(grid, hooks, replace(values, effects=(*values.effects, batch), specks=1)) for batch in batches]
    return [_at_starts(np.concatenate(block), starts, shown) for block in zip(*parts, strict=True)]


def torque_responses(
    grid: Grid, hooks: Sequence[Hooks], values: Values, knots: int, which: range | None = None
) -> list[Array]:
    """Return ∂ω̄/∂torque on the body at knots, of every run, shapes (N, 3, 3 * knots), rad/s per N·m.

    Args:
        grid: the runs.
        hooks: the effects in the model.
        values: one parameter set, P = 1.
        knots: of each run, evenly from its first sample to its last; the torque is linear between them.
        which: of them; None for all.
    """
    some = range(knots) if which is None else which
    blocks = _of_parts(grid, values, lambda part, own: _torque_responses(part, hooks, own, knots, some))
    return [np.moveaxis(block, 0, -1) for block in blocks]


def _torque_responses(grid: Grid, hooks: Sequence[Hooks], values: Values, knots: int, which: range) -> list[Array]:
    motion, in_gyro = motion_of(grid, hooks, values), any(map(acts_in_gyro, hooks))
    knot, axis = np.divmod(np.arange(3 * which.start, 3 * which.stop), 3)
    parts: list[list[Array]] = []
    for some in _batches(grid, len(knot)):
        along = motion.along
        apart = (grid.time.shape[1] - 1) / (knots - 1)
        changes = answers(motion.by_torque, along.tangents, motion.rate_by_state, knot[some], axis[some], apart)
        if in_gyro:
            rates = motion.rates[:, None] + 1j * COMPLEX_STEP * changes
            parts.append([each.imag / COMPLEX_STEP for each in readings(grid, hooks, values.effects, rates)])
        else:  # what the gyro reads is linear in the motion
            parts.append(readings(grid, [], [], changes))
    return [np.concatenate(of_run) for of_run in zip(*parts, strict=True)]


def _batches(grid: Grid, sets: int) -> list[slice]:
    """Return which parameter sets are integrated together."""
    size = max(_FEWEST_SETS, _AT_ONCE // max(part.time.size for part in grid.parts))
    return [slice(first, first + size) for first in range(0, sets, size)]


def _at_starts(reading: Array, starts: Array, shown: Sequence[int]) -> Array:
    """Return the derivatives of a block, shape (S, N, 3, K), from its predictions, shape (S * len(shown), N, 3)."""
    derivatives = np.zeros((*starts.shape, *reading.shape[1:]))
    derivatives[:, shown] = reading.imag.reshape(len(starts), len(shown), *reading.shape[1:]) / COMPLEX_STEP
    return np.moveaxis(derivatives, 1, -1)


def _columns(grid: Grid, hooks: Sequence[Hooks], values: Values, block: range, predict: Predictor) -> list[Array]:
    """Predict with one parameter after the other a complex step away from its value."""
    step: Any = np.zeros((len(block), common_size(values.effects) + values.own_size), dtype=np.complex128)
    step[np.arange(len(block)), block] = 1j * COMPLEX_STEP
    theta, *effects, own = np.split(step, np.cumsum([6, *(value.shape[-1] for value in values.effects)]), axis=1)
    trim, turn = values.trim, values.first_turn
    return predict(
        grid,
        hooks,
        Values(
            theta=values.theta + theta,
            initial_rate=values.initial_rate + own[:, :3],
            effects=tuple(value + change for value, change in zip(values.effects, effects, strict=True)),
            trim=None if trim is None else trim + own[:, -3:],
            first_turn=None if turn is None else turn + own[:, 3:6],
            as_trial=values.as_trial,
        ),
    )


def _imaginary(reading: Array) -> Array:
    return (reading.imag / COMPLEX_STEP).transpose(*range(1, reading.ndim), 0)
