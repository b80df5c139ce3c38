"""How white gyro noise enters the two linear equations: MᵀZ of noise M e, for the covariance of an IV estimate.

Neither equation's noise is white. The prefilter takes the low frequencies out, eq. (21) being an approximation, and
the attitude of the momentum equation is the integral of the gyro. Both are linear maps of the gyro's noise to first
order, so that their share is computed rather than guessed from a residual of a few hundred numbers.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from testbed.arrays import Array, Matrices3, Series, Vectors3
from testbed.dynamics.inertia import cross_matrix, inertia_of
from testbed.estimation.actuation import actuation
from testbed.estimation.lag import impulse_power, transposed_lag
from testbed.estimation.prefilter import FilteredEquation
from testbed.estimation.regression import Solution
from testbed.estimation.telemetry import Telemetry


@dataclass(frozen=True, kw_only=True)
class NoiseImage:
    """What an instrument sees of the equation's noise M e, e the gyro's.

    Attributes:
        image: MᵀZ, shape (3N, P).
        power: mean variance of the equation's rows for unit variance of e.
    """

    image: Array
    power: float


def filtered_noise(
    telemetry: Telemetry, equation: FilteredEquation, solution: Solution, prefilter_time: float
) -> NoiseImage:
    """Return the noise of the filtered equation, M e = J e/γ + F[(ω× J - L× - J/γ) e], as the instrument sees it.

    Args:
        telemetry: the actuators' part.
        equation: of the measured rates.
        solution: its instrument, and the inertia to take for J.
        prefilter_time: γ, s.
    """
    inertia_B, momentum_B = _inertia_and_momentum(telemetry, equation, solution)
    direct = inertia_B / prefilter_time
    lagged = cross_matrix(equation.body_rate) @ inertia_B - cross_matrix(momentum_B) - direct
    step = float(np.median(np.diff(equation.time)))
    rows = solution.instrument.reshape(len(equation.time), 3, -1)
    parts = [transposed_lag(part, step, prefilter_time) for part in np.split(rows, equation.breaks)]
    image = _transposed(direct) @ rows + _transposed(lagged) @ np.concatenate(parts)
    pendulum = pendulum_of(telemetry, solution, equation.time)
    if pendulum is not None:
        image += pendulum.integrated_back(pendulum.turned(_transposed(pendulum.torque_B) @ np.concatenate(parts)))
    first, later = impulse_power(step, prefilter_time)
    power = np.sum((direct + first * lagged) ** 2) + later * np.sum(lagged**2)
    return NoiseImage(image=image.reshape(solution.instrument.shape), power=float(power) / solution.residual.size)


@dataclass(frozen=True, kw_only=True)
class PendulumNoise:
    """How gravity on a pivot carries the gyro's noise: its torque is taken along the noisy gyro's own integral.

    With the attitude's error φ = Rᵀ ∫ R e dt, body axes, the vertical is off by u × φ, and the torque m g u × c by
    -m g c × (u × φ).

    Attributes:
        time: shape (N,), s.
        matrix_NB: R, shape (N, 3, 3).
        torque_B: m g c× u×, by which an error of the attitude enters -τ, shape (N, 3, 3), N·m.
    """

    time: Series
    matrix_NB: Matrices3
    torque_B: Matrices3

    def turned(self, rows_B: Array) -> Array:
        """Return R times rows in body axes, shape (N, 3, P)."""
        return np.asarray(self.matrix_NB @ rows_B)

    def integrated_back(self, rows_N: Array) -> Array:
        """Return (∫ R e dt)ᵀ of rows in N, shape (N, 3, P): Rᵀ times what follows each sample."""
        return np.asarray(_transposed(self.matrix_NB) @ following(self.time, rows_N))


def pendulum_of(telemetry: Telemetry, solution: Solution, time: Series) -> PendulumNoise | None:
    """Return what gravity on a pivot does with the gyro's noise; None where it does nothing.

    Args:
        telemetry: with the surroundings.
        solution: with the offset's error behind all other unknowns.
        time: shape (N,), s.
    """
    around, pivot = telemetry.surroundings, telemetry.pivot
    if around is None or pivot is None or around.exact:
        return None
    matrix_NB = around.attitude(time)
    up, offset = cross_matrix(matrix_NB[:, 2]), cross_matrix(pivot.offset_B + solution.parameters[-3:])
    return PendulumNoise(
        time=time,
        matrix_NB=matrix_NB,
        torque_B=pivot.weight * offset @ up,
    )


def following(time: Series, rows: Array) -> Array:
    """Return the transpose of an integral from the first sample, by the trapezoidal rule, shape (N, 3, P)."""
    return np.asarray(_widths(time) * _sums_from(rows))


def _sums_from(rows: Array) -> Array:
    """Return the sums of rows from each sample on, of its own row half, shape (..., N, 3, P)."""
    sums = np.cumsum(rows[..., ::-1, :, :], axis=-3)[..., ::-1, :, :]
    return np.asarray(sums - rows / 2.0)


def _widths(time: Series) -> Array:
    """Return what each sample stands for in the trapezoidal rule, shape (N, 1, 1), s."""
    return np.asarray(np.gradient(time) * np.where(time == time[0], 0.5, 1.0))[:, None, None]


def _inertia_and_momentum(
    telemetry: Telemetry, equation: FilteredEquation, solution: Solution
) -> tuple[Matrices3, Vectors3]:
    """Return J(d) and L = J(d) ω + h at the equation's times."""
    known = actuation(telemetry, equation.time)
    inertia_B = inertia_of(solution.parameters[:6]) + known.inertia_change_B
    return inertia_B, np.matvec(inertia_B, equation.body_rate) + known.cluster_momentum_B


def attitude_noise(
    instrument: Array,
    scale: Matrices3,
    time: Series,
    matrix_NB: Matrices3,
    momentum_B: Vectors3,
    pendulum: PendulumNoise | None = None,
) -> Array:
    """Return Mᵀ Z of the scaled momentum equation, M e = e - J⁻¹ Rᵀ ∫ R (L × e) dt, shape (..., N, 3, P).

    An error R e dt of the attitude turns the torques that follow, and by the sample's time what was held before: it is
    off by that angle times the momentum at its own time, wherever torques drive that afterwards.

    Args:
        instrument: Z, rows scaled by J⁻¹, shape (..., N, 3, P).
        scale: J(d)⁻¹, shape (..., N, 3, 3), 1/(kg·m²).
        time: shape (N,), s.
        matrix_NB: R, shape (..., N, 3, 3).
        momentum_B: L, shape (..., N, 3), N·m·s.
        pendulum: gravity on a pivot, whose torque carries the noise too; None without one.
    """
    seen = matrix_NB @ (_transposed(scale) @ instrument)
    turning = _transposed(matrix_NB @ cross_matrix(momentum_B))
    image = instrument - _widths(time) * (turning @ _sums_from(seen))  # the rule transposed
    if pendulum is None:
        return np.asarray(image)
    rows_B = _transposed(pendulum.torque_B) @ (_transposed(pendulum.matrix_NB) @ following(time, seen))
    return np.asarray(image + pendulum.integrated_back(pendulum.turned(rows_B)))


def _transposed(matrices: Array) -> Array:
    return np.swapaxes(matrices, -1, -2)
