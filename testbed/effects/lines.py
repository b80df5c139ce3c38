"""Lines in the gyro's readings whose size and phase are not known: what the readings say of one in every run."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable
from functools import partial

import numpy as np
import scipy
from typing_extensions import override

from testbed.arrays import Array, Matrix3, Vector3, Vectors3
from testbed.effects.noise_effect import Finding, NoiseEffect, Readings

_ALIASED = 1e-6
"""Share of the larger singular value of the normal matrix of a line's two columns below which they are one: a line at
half the gyro's rate, whose phase does not show."""

_PHASES = 256
"""Phases over which a line of a known size is averaged: a likelihood of e^500 is then as narrow as three of them."""


class LineEffect(NoiseEffect):
    """An effect that shows as a line in the gyro's readings, of one size, its phase free in every run."""

    @abstractmethod
    def line(self, component: str, readings: Readings, part: int) -> Array | None:
        """Return the line of size one in a run, at phases of 0 and 90 degrees; None where a run has none.

        Args:
            component: where the effect sits.
            readings: against the present model.
            part: index of the run.

        Returns:
            Shape (N, 3, 2), rad/s.
        """

    @override
    def found(self, component: str, readings: Readings) -> Finding | None:
        return found_lines(readings, partial(self.line, component, readings))

    @override
    def held_out_gain(self, component: str, values: Array, readings: Readings) -> float:
        return held_out_gain_of_lines(readings, partial(self.line, component, readings), float(values[0]))


def found_lines(readings: Readings, columns_of: Callable[[int], Array | None]) -> Finding | None:
    """Return what the readings say of a line of one size, its phase free in every run; None where a run has no line.

    Args:
        readings: against the present model.
        columns_of: from a run's index to the line of size one at phases of 0 and 90 degrees, shape (N, 3, 2), rad/s.
    """
    lines = [_line_fit(part, readings, columns_of(part)) for part in range(len(readings.runs))]
    if None in lines:
        return None
    fits = [each for each in lines if each is not None]
    gain, freedom = sum(fit[1] for fit in fits), 2 * len(fits)
    squares = np.array([fit[0] @ fit[0] for fit in fits])
    errors = np.array([np.trace(fit[2]) for fit in fits])  # noise alone has such squares
    size = float(np.sqrt(max(np.mean(squares - errors), 0.0)))
    explained = [fit[3] for fit in fits]
    return Finding(
        values=np.array([size]),
        std=np.array([np.sqrt(np.mean(errors) / freedom)]),
        chi_square_reduction=gain,
        freedom=freedom,
        p_value=float(scipy.stats.chi2.sf(gain, freedom)),
        variance=np.asarray(np.mean(np.concatenate(explained) ** 2, axis=0)),
        explained=explained,
    )


def held_out_gain_of_lines(readings: Readings, columns_of: Callable[[int], Array | None], size: float) -> float:
    """Return twice the logarithm of how much more probable a line of a size, of any phase, makes readings.

    Args:
        readings: of runs from which the size was not estimated.
        columns_of: as `found_lines`.
        size: of the line, in units of the columns.
    """
    gain = 0.0
    phase = 2.0 * np.pi * np.arange(_PHASES) / _PHASES
    lines = size * np.column_stack([np.cos(phase), np.sin(phase)])
    for part, residual in enumerate(readings.residual):
        columns = columns_of(part)
        if columns is None:
            continue
        white = readings.whitened(columns, part).reshape(-1, 2)
        slope = white.T @ readings.whitened(residual, part).ravel()
        likelihood = lines @ slope - 0.5 * np.einsum("pi,ij,pj->p", lines, white.T @ white, lines)
        gain += 2.0 * float(scipy.special.logsumexp(likelihood) - np.log(_PHASES))
    return gain


def tremor(
    position_B: Vector3, across_B: Vectors3, beside_B: Vectors3, speed: Array, angle: Array, inertia: Matrix3
) -> Array:
    """Return the body rates for an unbalanced rotor of one kg·m at φ₀ of 0 and 90 degrees, shape (N, 3, 2), rad/s.

    The total angular momentum does not change by it: ω = -J⁻¹ Ω r × (f cos φ + s sin φ).

    Args:
        position_B: r, of the rotor, m.
        across_B: f, normal to the rotor's axis, shape (3,) or (N, 3).
        beside_B: s, normal to both, the same.
        speed: Ω, a number or of shape (N, 1), rad/s.
        angle: φ - φ₀, shape (N,), rad.
        inertia: J, kg·m².
    """
    columns = []
    for lead in (0.0, 0.5 * np.pi):
        turn = (angle + lead)[:, None]
        ahead_B = np.cos(turn) * across_B + np.sin(turn) * beside_B
        columns.append(-speed * np.linalg.solve(inertia, np.cross(position_B, ahead_B).T).T)
    return np.stack(columns, axis=-1)


def _line_fit(part: int, readings: Readings, columns: Array | None) -> tuple[Array, float, Array, Array] | None:
    """Return a run's (U cos φ₀, U sin φ₀), the χ² that they explain, their covariance, and what they explain."""
    if columns is None:
        return None
    white = readings.whitened(columns, part).reshape(-1, 2)
    residual = readings.whitened(readings.residual[part], part).ravel()
    covariance = np.asarray(np.linalg.pinv(white.T @ white, rcond=_ALIASED))
    values = covariance @ (white.T @ residual)
    return values, float(values @ (white.T @ residual)), covariance, columns @ values
