"""The noise in which the impulses of wheels' motors are compared, estimated from themselves by maximum likelihood."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import scipy

from testbed.arrays import Array, Units
from testbed.prediction.wheel_impulses import ImpulseNoise, Impulses, impulse_scale, without_correlation

IMPULSE_UNKNOWNS = 5
"""Of a wheel: how an impulse follows its command and the two before, viscous and dry friction. They stand for any lag,
factor and friction, so that none of these passes for noise; a bearing that warms has other frictions in every run."""
_COMMANDS = slice(0, 3)
"""Which of these say how an impulse follows its command."""
_FEWEST = 20
"""Impulses for each column from which it is found how columns explain them.

Source: chosen, five times what the noise of impulses is estimated from (`SETTINGS.wheel_numbers_per_unknown`)."""
SURELY = 5.0
"""Standard errors by which commands have to differ from what is believed of them: by chance in three of ten million."""
_RATIOS = np.logspace(-6.0, 4.0, 31)
"""ρ Δt / s² between which it is searched: at the first a thousand intervals add up before the torque's noise counts, at
the last the tachometer has none."""
_LEAST = 1e-3
"""Share of a wheel's own impulses that their noise is at least, as of the gimbals' channels: it keeps simulated wheels
without noise from an infinite weight."""
_BETWEEN = 1e-2
"""The same share for what is asked for between samples, where control periods pass without one: steering bends commands
in each. It adds up from interval to interval, as the noise of a torque. A spline misses up to 0.003 of the impulses of
mixed, alike in all runs, whose commands are sampled in one period of five; in noise of less, a factor of 1e-4 and a lag
of 0.07 ms had names. As noise that cancels from one interval to the next, as a tachometer's does, a healthy rig had a
dry friction of ten standard deviations."""


class ImpulseFit(NamedTuple):
    """What impulses say of themselves.

    Attributes:
        noise: of them.
        factor: of the torque that the C wheels' motion takes over the one that was asked for, shape (C,).
        factor_std: its standard error, shape (C,).
    """

    noise: ImpulseNoise
    factor: Units
    factor_std: Units


class _OneWheel(NamedTuple):
    """The fit of one wheel's impulses in noise of a given ratio: its deviance, s², and the factor with its variance."""

    deviance: float
    variance: float
    factor: float
    factor_variance: float


def wheels_with(impulses: Sequence[Impulses], fewest: int) -> tuple[int, ...]:
    """Return the wheels of which so many impulses without lost samples are in all runs; none that stands still."""
    wheels = range(len(impulses[0].kept)) if impulses else range(0)
    complete = [each.complete for each in impulses]
    return tuple(wheel for wheel in wheels if sum(len(each.kept[wheel]) for each in complete) >= fewest)


def impulse_fit(impulses: Sequence[Impulses], wheels: tuple[int, ...], *, commanded: bool) -> ImpulseFit:
    """Return the noise of impulses, and how far the wheels follow what was asked for; by those without lost samples.

    Args:
        impulses: of every run.
        wheels: those that are compared, C of them.
        commanded: whether they are those of commands.
    """
    interval, count = float(np.median(np.concatenate([each.interval for each in impulses]))), len(wheels)
    units = [
        ImpulseNoise(commanded, wheels, np.ones(count), np.full(count, ratio / interval), interval) for ratio in _RATIOS
    ]
    impulses = [each.complete for each in impulses]
    by_wheel = list(zip(*(_fits(impulses, unit) for unit in units), strict=True))
    best = [int(np.argmin([fit.deviance for fit in fits])) for fits in by_wheel]
    found = [fits[ratio] for fits, ratio in zip(by_wheel, best, strict=True)]
    of_wheels = [np.concatenate([each.needed[each.kept[wheel], wheel] for each in impulses]) for wheel in wheels]
    moved = np.array([needed.std() for needed in of_wheels])
    variance = np.maximum([each.variance for each in found], (_LEAST * moved) ** 2) + np.finfo(float).tiny
    unsampled = max(each.between for each in impulses) * _BETWEEN * moved
    torque = np.maximum(variance * _RATIOS[best], unsampled**2) / interval
    return ImpulseFit(
        noise=ImpulseNoise(commanded, wheels, np.sqrt(variance), torque, interval),
        factor=np.array([each.factor for each in found]),
        factor_std=np.sqrt([each.factor_variance for each in found]),
    )


class Coefficients(NamedTuple):
    """What one wheel's motion took of each of C columns, shape (C,), and the covariance of that, shape (C, C)."""

    values: Array
    covariance: Array


def explained_by_wheel(
    impulses: Sequence[Impulses], columns: Sequence[Array], shown: int, *, commanded: bool
) -> list[Coefficients]:
    """Return how columns explain what each wheel's motion took, by least squares in the noise of the impulses.

    Of wheels with enough impulses for it; of one that lacks any of the first columns, as one that coasts, nothing.

    Args:
        impulses: of every run, in whose noise.
        columns: of every run what the motion took, then what may explain it, shape (1 + C, L, W), N·m·s.
        shown: how many of the latter a wheel must not lack.
        commanded: whether the impulses are those of commands.
    """
    wheels = wheels_with(impulses, _FEWEST * (len(columns[0]) - 1)) if impulses else ()
    if not wheels:
        return []
    noise = impulse_fit(impulses, wheels, commanded=commanded).noise
    pairs = zip(impulses, columns, strict=True)
    of_runs = zip(*(without_correlation(each, noise, own) for each, own in pairs), strict=True)
    by_wheel = [np.concatenate(of_wheel, axis=-1) for of_wheel in of_runs]
    return [_least_squares(each) for each in by_wheel if each[1 : 1 + shown].any(axis=1).all()]


def _least_squares(columns: Array) -> Coefficients:
    """Return how the first of the columns, shape (1 + C, K), consists of the others."""
    length = np.maximum(np.linalg.norm(columns[1:], axis=1), np.finfo(float).tiny)
    needed, others = columns[0], (columns[1:] / length[:, None]).T
    inverse = np.linalg.pinv(others)
    values = inverse @ needed
    variance = float(np.square(needed - others @ values).sum()) / (len(needed) - len(values))
    part = inverse / length[:, None]
    return Coefficients(values / length, variance * part @ part.T)


def _fits(impulses: Sequence[Impulses], unit: ImpulseNoise) -> list[_OneWheel]:
    """Return the fit of every wheel in noise of s = 1."""
    white = zip(*(without_correlation(each, unit, _columns(each)) for each in impulses), strict=True)
    scale = zip(*(impulse_scale(each, unit) for each in impulses), strict=True)
    return [
        _fit(_of_all_runs(columns) / sigma, np.concatenate(scales) / sigma)
        for columns, scales, sigma in zip(white, scale, unit.sigma, strict=True)
    ]


def _of_all_runs(columns: Sequence[Array]) -> Array:
    """Return columns of runs, shapes (1 + 5, K), as those of all together, frictions of every run's own behind them."""
    common = 1 + _COMMANDS.stop
    own = scipy.linalg.block_diag(*(each[common:] for each in columns))
    return np.concatenate([np.concatenate([each[:common] for each in columns], axis=-1), own])


def _fit(columns: Array, scale: Array) -> _OneWheel:
    """Return the fit of the first of the columns, shape (1 + C, K), by the others."""
    lengths = np.linalg.norm(columns[1:], axis=1)
    asked_nothing = not lengths[_COMMANDS].all()  # of a wheel that coasts, how it follows is not known
    unknowns, lengths = int(np.count_nonzero(lengths)), np.where(lengths > 0.0, lengths, 1.0)
    others = (columns[1:] / lengths[:, None]).T
    inverse = np.linalg.pinv(others)
    values = inverse @ columns[0]
    left, freedom = columns[0] - others @ values, len(others) - unknowns
    variance = float(left @ left) / freedom
    one = np.zeros(len(values))
    one[_COMMANDS] = 1.0 / lengths[_COMMANDS]
    return _OneWheel(
        deviance=freedom * float(np.log(variance + np.finfo(float).tiny)) - 2.0 * float(np.log(scale).sum()),
        variance=variance,
        factor=float(one @ values),
        factor_variance=np.inf if asked_nothing else variance * float(np.square(one @ inverse).sum()),
    )


def _columns(impulses: Impulses) -> Array:
    """Return what the motion took, then what may explain it, shape (1 + 5, L, W), N·m·s."""
    # All commands through the same interval: where its stamps are off, so are these, and no sum of them is free of it.
    last, interval = impulses.last, impulses.interval[:, None]
    before = np.concatenate([last[:1], last[:-1]])
    further = np.concatenate([before[:1], before[:-1]])
    followed = [impulses.asked, interval * before, interval * further]
    return np.stack([impulses.needed, *followed, impulses.turned, impulses.directed])
