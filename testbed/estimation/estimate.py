"""The interface of every estimator: its settings and its result."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal, Protocol

import numpy as np

from testbed.arrays import Array, Covariance, Indices, Matrix3, Series, Theta, Vector3, Vectors3
from testbed.dynamics.environment import Pivoted, parallel_axes
from testbed.dynamics.inertia import theta_of
from testbed.dynamics.inertia_unit import inertia_words
from testbed.estimation.answer import Answer
from testbed.estimation.stated_noise import with_bias
from testbed.estimation.telemetry import Telemetry
from testbed.estimation.uncertainty import EXACT, Uncertainty


@dataclass(frozen=True, kw_only=True, eq=False)
class EstimationSettings:
    """What an estimator knows beside the measurements; compared as `Telemetry` is.

    Attributes:
        nominal_theta: the nominal model's inertia, on a pivot about that, kg·m²; simulates the instrument and sizes
            what is identifiable.
        prefilter_time: γ of F(s) = 1/(γs + 1), s. Source: paper eq. (32).
        instrument: what the instrument is made of: the reference rate, a simulation of the nominal model, or
            simulations with the estimate so far.
        reference_rate: ω_ref(t), times of shape (N,) to rates of shape (N, 3), rad/s; needed by the first kind only.
        uncertainty: what is uncertain of actuators and gyro.
        telemetry_noise: whether noise of the actuators' telemetry counts where a motion is integrated: of one record
            that is measured, not of a campaign's flights.
    """

    nominal_theta: Theta
    prefilter_time: float = 0.8
    instrument: Literal["reference", "nominal", "iterated"] = "iterated"
    reference_rate: Callable[[Series], Vectors3] | None = None
    uncertainty: Uncertainty = EXACT
    telemetry_noise: bool = False


@dataclass(frozen=True, kw_only=True, repr=False)
class Estimate(Answer):
    """An estimate from one record, with its uncertainty.

    Attributes:
        initial_momentum_B: total angular momentum at the first sample used, N·m·s, body axes; zero where known.
        initial_momentum_covariance: shape (3, 3), N²·m²·s²; zero where known.
        constant_torque: that was estimated jointly, by component, shape (K,), N·m.
        constant_torque_std: its standard deviations by the gyro's noise, shape (K,), N·m.
        torque_names: of its components, such as `inertial_x`.
        residual_time: shape (N,), s.
        residual: measured - predicted, shape (N, 3), in `residual_unit`.
        residual_unit: N·m, or rad/s.
        white_residual: without what a bias that is stated to wander foretells, shape (N, 3); a torque as it is.
        residual_sigma: standard deviation of that with the parameters' degrees of freedom taken off.
        iterations: rounds until the answer.
        influence: ∂θ̂/∂e of an error e of each gyro sample, shape (6, 3N), kg·m² per rad/s, in the order of the
            residual, and three rows more for the offset on a pivot; None once what follows from it is known.
        by_telemetry: the part of the covariance, of all these, that noise of the actuators' telemetry makes; None where
            it is left out.
    """

    initial_momentum_B: Vector3
    initial_momentum_covariance: Matrix3
    constant_torque: Array
    constant_torque_std: Array
    torque_names: tuple[str, ...]
    residual_time: Series
    residual: Vectors3
    residual_unit: Literal["N·m", "rad/s"]
    white_residual: Vectors3
    residual_sigma: float
    iterations: int
    influence: Array | None = None
    by_telemetry: Covariance | None = None

    def __repr__(self) -> str:
        return f"Estimate: {inertia_words(self.theta, self.std)}"

    @property
    def acting(self) -> Array:
        """The unknown torques in the order of `Telemetry.torque_of`: N·m, then the offset's error, m."""
        return np.concatenate([self.constant_torque, self.offset_error])

    def turned_theta(self, pivot: Pivoted | None) -> Theta:
        """Return θ̂ about the point that the platform turns about, shape (6,), kg·m²; θ̂ is about the centre of mass."""
        return self.theta if pivot is None else self.theta + _about_pivot(pivot, self.offset_error)

    def about_center_of_mass(self, pivot: Pivoted | None) -> Estimate:
        """Return the estimate of an inertia about a pivot as one about the centre of mass.

        Covariances stay: 2 m c times the offset's standard deviation of 1e-7 m is below 1 % of that of J, for any
        offset c to 0.1 m of a table of 20 kg (scenarios/air_bearing.toml).
        """
        return self if pivot is None else replace(self, theta=self.theta - _about_pivot(pivot, self.offset_error))


class EstimatorSideBySide(Protocol):
    """Estimates the inertia from flights that stand side by side on leading axes; what it says of one is its alone."""

    def __call__(self, telemetry: Telemetry, settings: EstimationSettings) -> list[Estimate]:
        """Return an estimate for each flight.

        Raises:
            InputError: as `Estimator`, of any of the flights, or these take different ways.
        """
        ...


class Estimator(Protocol):
    """Estimates the inertia from one run."""

    def __call__(self, telemetry: Telemetry, settings: EstimationSettings) -> Estimate:
        """Return the estimate.

        Raises:
            InputError: too few samples, or a setting that the estimator needs is missing.
            UnidentifiableError: the run does not determine all parameters; the message names the directions.
        """
        ...


def _about_pivot(pivot: Pivoted, offset_error: Vector3) -> Theta:
    """Return what θ about a pivot is more than about the estimated centre of mass, shape (6,), kg·m²."""
    return theta_of(parallel_axes(pivot.mass, pivot.offset_B + offset_error))


def estimates_of(
    telemetry: Telemetry,
    parameters: Array,
    covariance: Array,
    *,
    influence: Array,
    residual: Array,
    sigma: Array,
    iterations: Indices | int,
) -> list[Estimate]:
    """Return the estimates of flights side by side, or of one, from residuals of all of the gyro's samples, rad/s.

    Args:
        telemetry: of all.
        parameters: shape (..., P); what follows as in `estimate_of`.
        covariance: shape (..., P, P).
        influence: shape (..., P, 3N).
        residual: what is white of it, shape (..., 3N), rad/s.
        sigma: shape (...).
        iterations: shape (...), or the same of all.
    """
    rounds = np.broadcast_to(iterations, parameters.shape[:-1])
    measured = with_bias(telemetry, residual[..., None])[..., 0]
    return [
        estimate_of(
            telemetry,
            parameters[flight],
            covariance[flight],
            influence=influence[flight],
            time=telemetry.gyro_time,
            residual=measured[flight],
            white_residual=residual[flight],
            unit="rad/s",
            sigma=float(sigma[flight]),
            iterations=int(rounds[flight]),
        )
        for flight in np.ndindex(parameters.shape[:-1])
    ]


def estimate_of(
    telemetry: Telemetry,
    parameters: Array,
    covariance: Array,
    *,
    influence: Array,
    time: Series,
    residual: Array,
    unit: Literal["N·m", "rad/s"],
    sigma: float,
    iterations: int,
    white_residual: Array | None = None,
) -> Estimate:
    """Return the estimate that a solution's parameters are: the inertia first, then momenta, torques last.

    Args:
        telemetry: states whether a momentum was estimated.
        parameters: shape (P,).
        covariance: shape (P, P).
        influence: of errors of the gyro's samples on the parameters, shape (P, 3N).
        time: of the residual, shape (N,), s.
        residual: measured - predicted, 3N numbers.
        unit: of the residual.
        sigma: of the residual.
        iterations: rounds.
        white_residual: 3N numbers, as of `Estimate`; the residual itself where None.
    """
    unknown = telemetry.initial_momentum == "estimated"
    stds = np.sqrt(np.diag(covariance))
    acting, torques = telemetry.torque_of(parameters), len(telemetry.torque_names)
    offset = np.arange(len(parameters))[len(parameters) - len(acting) + torques :]
    return Estimate(
        theta=parameters[:6],
        covariance=covariance[:6, :6],
        initial_momentum_B=parameters[6:9] if unknown else np.zeros(3),
        initial_momentum_covariance=covariance[6:9, 6:9] if unknown else np.zeros((3, 3)),
        constant_torque=acting[:torques],
        constant_torque_std=telemetry.torque_of(stds)[:torques],
        torque_names=telemetry.torque_names,
        residual_time=time,
        residual=residual.reshape(-1, 3),
        residual_unit=unit,
        white_residual=(residual if white_residual is None else white_residual).reshape(-1, 3),
        residual_sigma=sigma,
        iterations=iterations,
        offset_error=parameters[offset],
        offset_covariance=covariance[np.ix_(offset, offset)],
        offset_cross_covariance=covariance[:6, offset],
        offset_considered=np.zeros((len(offset), 0)),
        offset_spread=np.zeros((len(offset), len(offset))),
        influence=influence[np.concatenate([np.arange(6), offset])],
    )
