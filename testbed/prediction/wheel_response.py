"""What the motors of reaction wheels should have given, by their commands or currents, beside what the wheels took."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import chain

import numpy as np

from testbed.arrays import Array, Series
from testbed.prediction.grid import Grid
from testbed.prediction.hooks import Hooks
from testbed.prediction.wheel_impulses import (
    ImpulseNoise,
    Impulses,
    delayed,
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


def measured_impulses(grid: Grid) -> list[list[Array]]:
    """Return what each compared wheel's motion took of its motor in every run, as compared, shape (K, 1), N·m·s."""
    return _by_wheel([without_correlation(each, noise, each.needed) for each, noise in _compared(grid)])


def predicted_impulses(grid: Grid, hooks: Sequence[Hooks], effects: Sequence[Array]) -> list[Array]:
    """Return what the motors should have given, as compared, of wheel after wheel, in every run, (P, K, 1), N·m·s.

    Args:
        grid: the runs; their wheels are compared.
        hooks: the effects in the model.
        effects: their parameters, shapes (P, Q).
    """
    given = [without_correlation(each, noise, impulses_with(each, hooks, effects)) for each, noise in _compared(grid)]
    return list(chain.from_iterable(_by_wheel(given)))


def impulses_with(impulses: Impulses, hooks: Sequence[Hooks], effects: Sequence[Array]) -> Array:
    """Return the impulses that motors give to wheels with effects, less what these take, shape (P, L, W), N·m·s.

    As they show in wheels of the believed inertia.

    Args:
        impulses: that they were asked for.
        hooks: the effects.
        effects: their parameters, shapes (P, Q).
    """
    wheels = impulses.torque.shape[1]
    placed, none = list(zip(hooks, effects, strict=True)), np.zeros((1, wheels))
    lag = sum((hook.wheel_lag(value, wheels) for hook, value in placed), none)
    delay = sum((hook.wheel_delay(value, wheels) for hook, value in placed), none)
    given = delayed(impulses, lagged(impulses, np.asarray(lag)), np.asarray(delay))
    for hook, value in placed:
        given = hook.wheel_impulse(given, value, impulses)
    larger = sum((hook.wheel_inertia_error(value, wheels) for hook, value in placed), none)
    if not np.any(larger):
        return given
    # By the believed inertia, as the other side is: were both sides in another one, the noise would shrink with it.
    return np.asarray(impulses.friction + (given - impulses.friction) / (1.0 + np.asarray(larger))[:, None])


def compared_wheels(grid: Grid) -> tuple[int, ...]:
    """Return the indices of the wheels whose impulses are compared."""
    return () if grid.wheel_noise is None else grid.wheel_noise.wheels


def impulse_times(grid: Grid, wheel: int) -> list[Series]:
    """Return the ends of the intervals in which a wheel's impulses are compared, of every run, shape (K,), s."""
    pairs = zip(grid.runs, _compared(grid), strict=True)
    return [run.actuator_time[impulses.kept[wheel] + 1] for run, (impulses, _) in pairs]


def _by_wheel(of_runs: Sequence[Sequence[Array]]) -> list[list[Array]]:
    """Return the wheels' impulses of every run, shape (..., K), as those of every wheel, blocks of one column."""
    return [[block[..., None] for block in of_wheel] for of_wheel in zip(*of_runs, strict=True)]


def _compared(grid: Grid) -> Iterator[tuple[Impulses, ImpulseNoise]]:
    noise = grid.wheel_noise
    if noise is not None:
        for each in all_impulses(grid, commanded=noise.commanded):
            yield each, noise
