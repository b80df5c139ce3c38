"""The role that every estimator plays, what it may be told, and what it answers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, Protocol

import numpy as np

from testbed.arrays import Array, Covariance, Matrix3, Series, Theta, Vector3, Vectors3
from testbed.estimation.telemetry import Telemetry


@dataclass(frozen=True, kw_only=True, eq=False)
class EstimationSettings:
    """What an estimator is told beside the measurements; compared as `Telemetry` is.

    Attributes:
        nominal_theta: the nominal model's inertia, kg·m²; simulates the instrument and sizes what is identifiable.
        prefilter_time: γ of F(s) = 1/(γs + 1), s. Source: paper eq. (32).
        instrument: what the instrument is made of: the reference rate, a simulation of the nominal model, or
            simulations with the estimate so far.
        reference_rate: ω_ref(t), times of shape (N,) to rates of shape (N, 3), rad/s; needed by the first kind only.
    """

    nominal_theta: Theta
    prefilter_time: float = 0.8
    instrument: Literal["reference", "nominal", "iterated"] = "iterated"
    reference_rate: Callable[[Series], Vectors3] | None = None


@dataclass(frozen=True, kw_only=True)
class Estimate:
    """An estimate of the inertia, with its uncertainty.

    Attributes:
        theta: θ̂, shape (6,), kg·m².
        covariance: of θ̂, shape (6, 6), kg²·m⁴.
        initial_momentum_B: the platform's whole momentum at the first sample used, N·m·s, body axes; zero where known.
        initial_momentum_covariance: shape (3, 3), N²·m²·s²; zero where known.
        residual_time: shape (N,), s.
        residual: measured - predicted, shape (N, 3), in `residual_unit`.
        residual_unit: N·m, or rad/s.
        residual_sigma: its standard deviation with the parameters' degrees of freedom taken off.
        iterations: rounds until the answer.
    """

    theta: Theta
    covariance: Covariance
    initial_momentum_B: Vector3
    initial_momentum_covariance: Matrix3
    residual_time: Series
    residual: Vectors3
    residual_unit: Literal["N·m", "rad/s"]
    residual_sigma: float
    iterations: int

    @property
    def std(self) -> Theta:
        """Standard deviation of θ̂, shape (6,), kg·m²."""
        return np.sqrt(np.diag(self.covariance))


class Estimator(Protocol):
    """Estimates the inertia from one run."""

    def __call__(self, telemetry: Telemetry, settings: EstimationSettings) -> Estimate:
        """Return the estimate.

        Raises:
            InputError: too few samples, or a setting that the estimator needs is missing.
            UnidentifiableError: the run does not determine all parameters; the message names the directions.
        """
        ...


def estimate_of(
    telemetry: Telemetry,
    parameters: Array,
    covariance: Array,
    *,
    time: Series,
    residual: Array,
    unit: Literal["N·m", "rad/s"],
    sigma: float,
    iterations: int,
) -> Estimate:
    """Return the estimate that a solution's parameters are, the inertia first and the first momentum after it.

    Args:
        telemetry: says whether a momentum was estimated.
        parameters: shape (P,).
        covariance: shape (P, P).
        time: of the residual, shape (N,), s.
        residual: measured - predicted, 3N numbers.
        unit: of the residual.
        sigma: of the residual.
        iterations: rounds.
    """
    unknown = telemetry.initial_momentum == "estimated"
    return Estimate(
        theta=parameters[:6],
        covariance=covariance[:6, :6],
        initial_momentum_B=parameters[6:9] if unknown else np.zeros(3),
        initial_momentum_covariance=covariance[6:9, 6:9] if unknown else np.zeros((3, 3)),
        residual_time=time,
        residual=residual.reshape(-1, 3),
        residual_unit=unit,
        residual_sigma=sigma,
        iterations=iterations,
    )
