"""What the motors of reaction wheels should have given, by their commands or currents, beside what the wheels took."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from testbed.arrays import Array
from testbed.estimation.telemetry import Telemetry
from testbed.prediction.grid import Grid
from testbed.prediction.hooks import Hooks
from testbed.prediction.wheel_impulses import (
    ImpulseNoise,
    Impulses,
    impulses_of,
    lagged,
    without_correlation,
)


def all_impulses(grid: Grid, *, commanded: bool) -> list[Impulses]:
    """Return the impulses of every run's wheels; none where a run lacks the channel.

    Args:
        grid: the runs.
        commanded: by the torques that were commanded, or else by those that were measured.
    """
    found = [impulses_of(run, commanded=commanded) for run in grid.runs]
    return [] if None in found else [each for each in found if each is not None]


def measured_impulses(grid: Grid) -> list[Array]:
    """Return what the wheels' motion took of their motors in every run, each of shape (K, W), N·m·s, as compared."""
    return [without_correlation(each, noise, each.needed[each.kept]) for each, noise in _compared(grid)]


def predicted_impulses(grid: Grid, hooks: Sequence[Hooks], effects: Sequence[Array]) -> list[Array]:
    """Return what the motors should have given in every run, each of shape (P, K, W), N·m·s, as compared.

    Args:
        grid: the runs; their wheels are compared.
        hooks: the effects in the model.
        effects: their parameters, shapes (P, Q).
    """
    blocks = []
    for impulses, noise in _compared(grid):
        given = impulses_with(impulses, hooks, effects)[:, impulses.kept]
        blocks.append(without_correlation(impulses, noise, given))
    return blocks


def impulses_with(impulses: Impulses, hooks: Sequence[Hooks], effects: Sequence[Array]) -> Array:
    """Return the impulses that motors give to wheels with effects, less what these take, shape (P, L, W), N·m·s.

    Args:
        impulses: that they were asked for.
        hooks: the effects.
        effects: their parameters, shapes (P, Q).
    """
    wheels = impulses.torque.shape[1]
    lag = sum(
        (hook.wheel_lag(value, wheels) for hook, value in zip(hooks, effects, strict=True)), np.zeros((1, wheels))
    )
    given = lagged(impulses, np.asarray(lag))
    for hook, value in zip(hooks, effects, strict=True):
        given = hook.wheel_impulse(given, value, impulses)
    return given


def compared_runs(grid: Grid) -> list[tuple[Telemetry, Impulses]]:
    """Return the runs whose wheels are compared, with their impulses."""
    return [(run, each) for run, (each, _) in zip(grid.runs, _compared(grid), strict=True)]


def _compared(grid: Grid) -> Iterator[tuple[Impulses, ImpulseNoise]]:
    noise = grid.wheel_noise
    if noise is not None:
        for each in all_impulses(grid, commanded=noise.commanded):
            yield each, noise
