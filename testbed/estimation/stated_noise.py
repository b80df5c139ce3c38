"""The gyro's noise as a run states it: white, beside a bias that wanders.

With errors e = B n of the samples, n white of standard deviation σ, least squares over B⁻¹ times residual and columns
are most likely, and an estimate that e moves by G e, whatever it is made by, has the covariance σ² G B Bᵀ Gᵀ.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from testbed.arrays import Array, Regressor, Series
from testbed.estimation.slow_bias import SlowBias
from testbed.estimation.telemetry import Telemetry

_Filter = Callable[[SlowBias, Array, Series, Array], Array]


def whitened(telemetry: Telemetry, rows: Regressor) -> Regressor:
    """Return B⁻¹ times rows of all gyro samples, shape (..., 3N, C); the rows themselves where no bias wanders.

    Args:
        telemetry: one run, or flights side by side.
        rows: grouped by sample, in any unit.
    """
    return _filtered(telemetry, rows, SlowBias.whitened, telemetry.gyro_time)


def with_bias(telemetry: Telemetry, white: Regressor) -> Regressor:
    """Return B times rows, the inverse of `whitened`; arguments as there."""
    return _filtered(telemetry, white, SlowBias.wandering, telemetry.gyro_time)


def influence_of_errors(telemetry: Telemetry, gain: Array) -> Array:
    """Return G of errors of the samples, shape (..., P, 3N), from that of what is white in them: times B⁻¹.

    Args:
        telemetry: one run, or flights side by side.
        gain: ∂θ̂/∂n, shape (..., P, 3N).
    """
    return _filtered(telemetry, gain.mT, SlowBias.whitened_back, telemetry.gyro_time).mT


def influence_of_white(telemetry: Telemetry, influence: Array, time: Series | None = None) -> Array:
    """Return how what is white in the samples moves an estimate, G B, shape (..., P, 3N).

    Args:
        telemetry: one run, or flights side by side.
        influence: G, ∂θ̂/∂e, shape (..., P, 3N).
        time: of the samples, shape (N,), s; those of all where None.
    """
    return _filtered(telemetry, influence.mT, SlowBias.wandering_back, telemetry.gyro_time if time is None else time).mT


def white_variance(telemetry: Telemetry, of_residual: Array | float) -> Array | float:
    """Return σ² of what is white, (rad/s)²: by a residual, or as it is stated where that holds a bias's course.

    Args:
        telemetry: one run, or flights side by side.
        of_residual: by the residual of an estimator that does not take the bias's course off, shape (...).
    """
    return np.full_like(of_residual, telemetry.gyro_noise**2) if wanders(telemetry) else of_residual


def wanders(telemetry: Telemetry) -> bool:
    """Return whether a bias is stated to wander beside noise: beside none at all it is seen exactly."""
    return telemetry.slow_bias is not None and telemetry.gyro_noise > 0.0


def _filtered(telemetry: Telemetry, rows: Regressor, by: _Filter, time: Series) -> Regressor:
    """Return rows, shape (..., 3N, C), through a filter that takes them by sample, axis, and all else."""
    if telemetry.slow_bias is None or not wanders(telemetry):
        return rows
    by_sample = rows.reshape(-1, len(time), 3, rows.shape[-1]).transpose(1, 2, 0, 3)
    passed = by(telemetry.slow_bias, by_sample, time, np.full(3, telemetry.gyro_noise))
    # Sums over a flight's rows are the same to the last bit only if these lie in the memory as when it is alone.
    return np.ascontiguousarray(passed.transpose(2, 0, 1, 3)).reshape(rows.shape)
