"""Euler's equation behind the prefilter: linear in the inertia, and free of derivatives of measurements.

With L = J(d) ω + h, d/dt L + ω × L = τ. The filter F(s) = 1/(γs + 1) from zero state gives s F x = (x - F x)/γ but for
the start, where integration by parts leaves the response to the initial value:

    (L - F L)/γ + F[ω × L] - F τ = f(t) L(0),   f(t) = exp(-t/γ)/γ.

So a record that starts in motion adds three columns and three unknowns, L(0); no sample is differentiated or trusted
alone. Source: paper eqs. (7), (22), (32).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicHermiteSpline, CubicSpline
from scipy.linalg import block_diag

from testbed.arrays import Array, Regressor, Response, Series, Vectors3
from testbed.dynamics.inertia import cross_matrix, momentum_regressor
from testbed.estimation.actuation import actuation
from testbed.estimation.lag import first_order_lag
from testbed.estimation.telemetry import Telemetry, stretches

FINE_STEP = 1.0 / 256.0
"""s; products of rates are filtered on this grid. At the gyro's own 16 Hz they would leave up to 1e-5 kg·m²."""


@dataclass(frozen=True, kw_only=True)
class FilteredEquation:
    """The filtered equation Ψ θ' = Y at the gyro's times, θ' = θ and the unknown initial momenta.

    Attributes:
        time: shape (N,), s.
        body_rate: the ω that it was made of, shape (N, 3), rad/s.
        breaks: samples at which the filter starts anew, the first not counted.
        regressor: Ψ, shape (3N, 6 + 3S), S the number of unknown initial momenta.
        response: Y, shape (3N,), N·m.
    """

    time: Series
    body_rate: Vectors3
    breaks: tuple[int, ...]
    regressor: Regressor
    response: Response


def filtered_equation(
    telemetry: Telemetry, body_rate: Vectors3, prefilter_time: float, fine_step: float = FINE_STEP
) -> FilteredEquation:
    """Return Ψ_f and Y_f of a body rate, measured or of an instrument.

    A gap in the telemetry starts the filter anew, with its own unknown momentum.

    Args:
        telemetry: the actuators' part, the times, and whether the initial momentum is known.
        body_rate: ω at the gyro's times, shape (N, 3), rad/s.
        prefilter_time: γ, s.
        fine_step: longest step of the grid on which products are filtered, s.

    Source: paper eqs. (7), (15), (22).
    """
    parts = [
        _stretch(telemetry, stretch, body_rate[stretch], prefilter_time, fine_step)
        for stretch in stretches(telemetry.gyro_time)
    ]
    momenta = block_diag(*(part.regressor[:, 6:] for part in parts))
    return FilteredEquation(
        time=np.concatenate([part.time for part in parts]),
        body_rate=np.concatenate([part.body_rate for part in parts]),
        breaks=tuple(np.cumsum([len(part.time) for part in parts[:-1]], dtype=int).tolist()),
        regressor=np.hstack([np.concatenate([part.regressor[:, :6] for part in parts]), momenta]),
        response=np.concatenate([part.response for part in parts]),
    )


def _stretch(
    telemetry: Telemetry, stretch: slice, body_rate: Vectors3, prefilter_time: float, fine_step: float
) -> FilteredEquation:
    """Return the equation of one run without gaps, its own momentum columns last where it is unknown."""
    time = telemetry.gyro_time[stretch]
    grid = np.linspace(time[0], time[-1], int(np.ceil((time[-1] - time[0]) / fine_step)) + 1)
    fine_rate = np.asarray(CubicSpline(time, body_rate)(grid))  # finer first, products afterwards
    fine_momentum, torque_B = _known_momentum(telemetry, grid, fine_rate)
    momentum, _ = _known_momentum(telemetry, time, body_rate)

    def filtered(signal: Array) -> Array:
        return _filtered_at(time, grid, signal, prefilter_time)

    turning = filtered(cross_matrix(fine_rate) @ momentum_regressor(fine_rate))
    swing = momentum_regressor((body_rate - filtered(fine_rate)) / prefilter_time)  # s F Γ(ω)
    known_swing = (momentum - filtered(fine_momentum)) / prefilter_time
    response = filtered(torque_B - np.cross(fine_rate, fine_momentum)) - known_swing  # eq. (7), filtered: (22)
    regressor = np.concatenate([swing + turning, _start_columns(telemetry, stretch, prefilter_time)], axis=2)
    return FilteredEquation(
        time=time,
        body_rate=body_rate,
        breaks=(),
        regressor=regressor.reshape(response.size, -1),
        response=response.ravel(),
    )


def _start_columns(telemetry: Telemetry, stretch: slice, prefilter_time: float) -> Array:
    """Return -f(t) I, shape (N, 3, 3), or (N, 3, 0) where the momentum at the stretch's start is known to be zero."""
    time = telemetry.gyro_time[stretch]
    zero = telemetry.initial_momentum == "zero" and (stretch.start == 0 or telemetry.applied_torque is None)
    decay = np.exp(-(time - time[0]) / prefilter_time) / prefilter_time
    return np.asarray(-decay[:, None, None] * np.eye(3)[:, : 0 if zero else 3])


def _known_momentum(telemetry: Telemetry, time: Series, body_rate: Vectors3) -> tuple[Vectors3, Vectors3]:
    """Return h + (J(d) - J(0)) ω and the applied torque at given times, body axes."""
    known = actuation(telemetry, time)
    shifted = np.matvec(known.inertia_change_B, body_rate)
    return known.cluster_momentum_B + shifted, known.applied_torque_B


def _filtered_at(time: Series, grid: Series, signal: Array, prefilter_time: float) -> Array:
    """Return F x at the given times, x on the grid with any trailing shape."""
    output = first_order_lag(signal, grid[1] - grid[0], prefilter_time)
    slope = (signal - output) / prefilter_time
    return np.asarray(CubicHermiteSpline(grid, output, slope)(time))
