"""Figures 5 and 6: what the longest flight sent, and the total torque of a flight that was not used."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from testbed.arrays import Series, Theta, Vectors3
from testbed.estimation.actuation import actuation
from testbed.estimation.momentum_equation import mean_momentum
from testbed.estimation.prefilter import filtered_equation
from testbed.estimation.telemetry import Telemetry


@dataclass(frozen=True, kw_only=True)
class Figure5:
    """Input and output of one flight.

    Attributes:
        time: shape (N,), s.
        body_rate: gyro, shape (N, 3), rad/s, body axes.
        cluster_momentum_B: from encoders and tachometers, shape (N, 3), N·m·s, body axes.
    """

    time: Series
    body_rate: Vectors3
    cluster_momentum_B: Vectors3


@dataclass(frozen=True, kw_only=True)
class Figure6:
    """Total torque of one flight, both sides of eq. (7) behind the prefilter, so that nothing is differentiated.

    Attributes:
        time: shape (N,), s.
        measured_B: F[-ḣ - ω × h], the gimbals' share of the inertia included, shape (N, 3), N·m.
        estimated_B: F[ψ] θ̂ of the campaign, shape (N, 3), N·m.
        nominal_B: F[ψ] θ of the CAD model, shape (N, 3), N·m.
        estimated_misfit: rms of measured - estimated over the rms of measured.
        nominal_misfit: the same for the CAD model.
    """

    time: Series
    measured_B: Vectors3
    estimated_B: Vectors3
    nominal_B: Vectors3
    estimated_misfit: float
    nominal_misfit: float


def figure5(telemetry: Telemetry) -> Figure5:
    """Return what a flight sent in its usable time. Source: paper Fig. 5."""
    time = telemetry.gyro_time
    return Figure5(
        time=time,
        body_rate=telemetry.body_rate,
        cluster_momentum_B=actuation(telemetry, time).cluster_momentum_B,
    )


def figure6(telemetry: Telemetry, theta: Theta, nominal_theta: Theta, prefilter_time: float) -> Figure6:
    """Compare the total torque of a flight with what an inertia makes of its motion. Source: paper Fig. 6.

    The momentum at the start is the only thing that is fitted to the flight, to each inertia anew.

    Args:
        telemetry: one run without gaps, its initial momentum unknown.
        theta: the estimate, from other flights, kg·m².
        nominal_theta: of the CAD model, kg·m².
        prefilter_time: γ, s.
    """
    equation = filtered_equation(telemetry, telemetry.body_rate, prefilter_time)
    start = equation.regressor[:, 6:]  # -f(t) of each axis: F[ẋ] = s F x - f(t) x(0)
    known = actuation(telemetry, equation.time[:1])
    first = known.cluster_momentum_B[0] + known.inertia_change_B[0] @ telemetry.body_rate[0]
    measured_B = (equation.response - start @ first).reshape(-1, 3)

    def of(inertia: Theta) -> Vectors3:
        turning = mean_momentum(telemetry, inertia) - first  # J ω(0)
        return np.asarray(equation.regressor[:, :6] @ inertia + start @ turning).reshape(-1, 3)

    estimated_B, nominal_B = of(theta), of(nominal_theta)
    return Figure6(
        time=equation.time,
        measured_B=measured_B,
        estimated_B=estimated_B,
        nominal_B=nominal_B,
        estimated_misfit=_misfit(measured_B, estimated_B),
        nominal_misfit=_misfit(measured_B, nominal_B),
    )


def _misfit(measured_B: Vectors3, predicted_B: Vectors3) -> float:
    return float(np.sqrt(np.sum((measured_B - predicted_B) ** 2) / np.sum(measured_B**2)))
