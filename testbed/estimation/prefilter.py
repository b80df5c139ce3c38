"""Euler's equation behind the prefilter: linear in the inertia, and free of derivatives of measurements.

With L = J(d) ω + h, d/dt L + ω × L = τ. The filter F(s) = 1/(γs + 1) from zero state gives s F x = (x - F x)/γ but for
the start, where integration by parts leaves the response to the initial value:

    (L - F L)/γ + F[ω × L] - F τ = f(t) L(0),   f(t) = exp(-t/γ)/γ.

So a record that starts in motion adds three columns and three unknowns, L(0); no sample is differentiated or trusted
alone. Source: paper eqs. (7), (22), (32).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.interpolate import BSpline, CubicSpline
from scipy.linalg import block_diag

from testbed.arrays import Array, Regressor, Response, Series, Vectors3
from testbed.dynamics.inertia import momentum_regressor, rate_products, turning_regressor
from testbed.estimation.actuation import Actuation, actuation
from testbed.estimation.gaps import stretches
from testbed.estimation.lag import first_order_lag
from testbed.estimation.motion import torque_basis
from testbed.estimation.telemetry import Telemetry
from testbed.rotation.vectors import cross

FINE_STEP = 1.0 / 256.0
"""s; products of rates are filtered on this grid. At the gyro's own 16 Hz they would leave up to 1e-5 kg·m²."""


@dataclass(frozen=True, kw_only=True)
class FilteredEquation:
    """The filtered equation Ψ θ' = Y at the gyro's times, θ' = θ, the unknown initial momenta and constant torques.

    Attributes:
        time: shape (N,), s.
        body_rate: the ω that it was made of, shape (N, 3), rad/s.
        breaks: samples at which the filter starts anew, the first not counted.
        regressor: Ψ, shape (3N, 6 + 3S + K), S the number of unknown initial momenta, K of constant torques.
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
    last = parts[0].regressor.shape[1] - telemetry.torque_unknowns
    momenta = block_diag(*(part.regressor[:, 6:last] for part in parts))
    return FilteredEquation(
        time=np.concatenate([part.time for part in parts]),
        body_rate=np.concatenate([part.body_rate for part in parts]),
        breaks=tuple(np.cumsum([len(part.time) for part in parts[:-1]], dtype=int).tolist()),
        regressor=np.hstack(
            [
                np.concatenate([part.regressor[:, :6] for part in parts]),
                momenta,
                np.concatenate([part.regressor[:, last:] for part in parts]),
            ]
        ),
        response=np.concatenate([part.response for part in parts]),
    )


def _stretch(
    telemetry: Telemetry, stretch: slice, body_rate: Vectors3, prefilter_time: float, fine_step: float
) -> FilteredEquation:
    """Return the equation of one run without gaps: columns of the inertia, its own momentum, the torques."""
    time = telemetry.gyro_time[stretch]
    grid, known, fine_known = _known(telemetry, stretch.start, stretch.stop, fine_step)
    fine_rate = _joined(time, body_rate, telemetry.corners, grid)  # finer first, products afterwards
    fine_momentum = _known_momentum(fine_known, fine_rate)
    fine_torque = fine_known.applied_torque_B - cross(fine_rate, fine_momentum)

    def filtered(signal: Array) -> Array:
        return _filtered_at(time, grid, signal, prefilter_time)

    turning = turning_regressor(filtered(rate_products(fine_rate)))
    swing = momentum_regressor((body_rate - filtered(fine_rate)) / prefilter_time)  # s F Γ(ω)
    known_swing = (_known_momentum(known, body_rate) - filtered(fine_momentum)) / prefilter_time
    response = filtered(fine_torque) - known_swing  # eq. (7), filtered: (22)
    held = telemetry.held_torque
    if held is not None:  # F τ by its impulse since the start, which has no jumps
        response += (held(time) - held(time[0]) - filtered(held(grid) - held(time[0]))) / prefilter_time
    columns = [swing + turning, _start_columns(telemetry, stretch, prefilter_time)]
    if telemetry.torque_unknowns:
        columns.append(-filtered(torque_basis(telemetry, grid)))
    regressor = np.concatenate(columns, axis=2)
    return FilteredEquation(
        time=time,
        body_rate=body_rate,
        breaks=(),
        regressor=regressor.reshape(response.size, -1),
        response=response.ravel(),
    )


def _joined(time: Series, body_rate: Vectors3, corners: BSpline | None, at: Series) -> Vectors3:
    """Return a sampled rate between its samples: on a cubic spline, but for what bends between them."""
    if corners is None:
        return np.asarray(CubicSpline(time, body_rate)(at))
    return np.asarray(CubicSpline(time, body_rate - corners(time))(at) + corners(at))


@lru_cache(maxsize=2)  # the rounds of an estimator ask for the same stretches in turn
def _known(telemetry: Telemetry, first: int, last: int, fine_step: float) -> tuple[Series, Actuation, Actuation]:
    """Return the fine grid of a stretch, and the actuators at its samples and on the grid."""
    time = telemetry.gyro_time[first:last]
    grid = np.linspace(time[0], time[-1], int(np.ceil((time[-1] - time[0]) / fine_step)) + 1)
    return grid, actuation(telemetry, time), actuation(telemetry, grid)


def _start_columns(telemetry: Telemetry, stretch: slice, prefilter_time: float) -> Array:
    """Return -f(t) I, shape (N, 3, 3), or (N, 3, 0) where the momentum at the stretch's start is known to be zero."""
    time = telemetry.gyro_time[stretch]
    zero = telemetry.initial_momentum == "zero" and (stretch.start == 0 or telemetry.applied_torque is None)
    decay = np.exp(-(time - time[0]) / prefilter_time) / prefilter_time
    return np.asarray(-decay[:, None, None] * np.eye(3)[:, : 0 if zero else 3])


def _known_momentum(known: Actuation, body_rate: Vectors3) -> Vectors3:
    """Return h + (J(d) - J(0)) ω, body axes."""
    return np.asarray(known.cluster_momentum_B + np.matvec(known.inertia_change_B, body_rate))


def _filtered_at(time: Series, grid: Series, signal: Array, prefilter_time: float) -> Array:
    """Return F x at the given times, x on the grid with any trailing shape; between them on cubics by its slope."""
    output = first_order_lag(signal, grid[1] - grid[0], prefilter_time)
    before = np.clip(np.searchsorted(grid, time, side="right") - 1, 0, len(grid) - 2)
    after, step = before + 1, grid[1] - grid[0]
    place = ((time - grid[before]) / step).reshape(-1, *[1] * (signal.ndim - 1))
    ratio = step / prefilter_time
    start, end = output[before], output[after]
    leaving, coming = (ratio * (signal[index] - output[index]) for index in (before, after))  # F x = ∫ (x - F x)/γ dt
    bend = (1.0 - place) * (leaving - (end - start)) - place * (coming - (end - start))
    return np.asarray(start + place * (end - start) + place * (1.0 - place) * bend)
