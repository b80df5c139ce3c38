"""The noise in which the impulses of wheels' motors are compared, estimated from themselves by maximum likelihood."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from testbed.arrays import Array, Units
from testbed.prediction.wheel_impulses import ImpulseNoise, Impulses, impulse_scale, without_correlation

IMPULSE_UNKNOWNS = 5
"""Of a wheel: how an impulse follows its command and the two before, viscous and dry friction. They stand for any lag,
factor and friction, so that none of these passes for noise."""
_COMMANDS = slice(0, 3)
"""Which of these say how an impulse follows its command."""
_RATIOS = np.logspace(-6.0, 4.0, 31)
"""ρ Δt / s² between which it is searched: at the first a thousand intervals add up before the torque's noise counts, at
the last the tachometer has none."""
_LEAST = 1e-3
"""Share of a wheel's own impulses that their noise is at least, as of the gimbals' channels: it keeps simulated wheels
without noise from an infinite weight."""


class ImpulseFit(NamedTuple):
    """What impulses say of themselves.

    Attributes:
        noise: of them.
        factor: of the torque that the wheels' motion takes over the one that was asked for, shape (W,).
        factor_std: its standard error, shape (W,).
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


def impulse_fit(impulses: Sequence[Impulses], *, commanded: bool) -> ImpulseFit:
    """Return the noise of impulses, and how far the wheels follow what was asked for.

    Args:
        impulses: of every run.
        commanded: whether they are those of commands.
    """
    interval = float(np.median(np.concatenate([each.interval for each in impulses])))
    wheels = impulses[0].torque.shape[1]
    by_ratio = [_fits(impulses, ImpulseNoise(commanded, np.ones(wheels), np.full(wheels, ratio / interval), interval))
                for ratio in _RATIOS]  # fmt: skip
    best = [min(range(len(_RATIOS)), key=lambda ratio: by_ratio[ratio][wheel].deviance) for wheel in range(wheels)]
    found = [by_ratio[ratio][wheel] for wheel, ratio in enumerate(best)]
    moved = np.concatenate([each.needed[each.kept] for each in impulses]).std(axis=0)
    variance = np.maximum([each.variance for each in found], (_LEAST * moved) ** 2) + np.finfo(float).tiny
    return ImpulseFit(
        noise=ImpulseNoise(commanded, np.sqrt(variance), variance * _RATIOS[best] / interval, interval),
        factor=np.array([each.factor for each in found]),
        factor_std=np.sqrt([each.factor_variance for each in found]),
    )


def _fits(impulses: Sequence[Impulses], unit: ImpulseNoise) -> list[_OneWheel]:
    """Return the fit of every wheel in noise of s = 1."""
    parts = [without_correlation(each, unit, _columns(each)[:, each.kept]) for each in impulses]
    white = np.concatenate(parts, axis=1) / unit.sigma
    scale = np.concatenate([impulse_scale(each, unit) for each in impulses]) / unit.sigma
    return [_fit(white[:, :, wheel], scale[:, wheel]) for wheel in range(white.shape[2])]


def _fit(columns: Array, scale: Array) -> _OneWheel:
    """Return the fit of the first of the columns, shape (1 + C, K), by the others."""
    lengths = np.maximum(np.linalg.norm(columns[1:], axis=1), np.finfo(float).tiny)
    others = (columns[1:] / lengths[:, None]).T
    inverse = np.linalg.pinv(others)
    values = inverse @ columns[0]
    left, freedom = columns[0] - others @ values, len(others) - IMPULSE_UNKNOWNS
    variance = float(left @ left) / freedom
    one = np.zeros(len(values))
    one[_COMMANDS] = 1.0 / lengths[_COMMANDS]
    return _OneWheel(
        deviance=freedom * float(np.log(variance + np.finfo(float).tiny)) - 2.0 * float(np.log(scale).sum()),
        variance=variance,
        factor=float(one @ values),
        factor_variance=variance * float(np.square(one @ inverse).sum()),
    )


def _columns(impulses: Impulses) -> Array:
    """Return what the motion took, then what may explain it, shape (1 + 5, L, W), N·m·s."""
    asked = impulses.asked
    before = np.concatenate([asked[:1], asked[:-1]])
    further = np.concatenate([before[:1], before[:-1]])
    return np.stack([impulses.needed, asked, before, further, impulses.turned, impulses.directed])
