"""Output error for inertia and alignments together: the values of all of them that make the measured rates most likely.

Conservation of momentum, J(d) ω + h(d; p) = Rᵀ H₀, is predicted as `testbed.estimation.motion` does, with the cluster's
momentum a function of the alignments p. The initial momentum is estimated along: a cluster out of alignment carries
some even at rest.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from testbed.arrays import Array, Flags, Indices, Regressor, Theta, Vector3
from testbed.errors import InputError
from testbed.estimation.alignment_model import (
    KINDS,
    Alignment,
    SampledGimbals,
    alignment_of,
    drive_at,
    held_momentum,
    sampled_gimbals,
    working_units,
)
from testbed.estimation.alignment_observability import Observability, observability
from testbed.estimation.estimate import EstimationSettings
from testbed.estimation.identifiability import without_momentum
from testbed.estimation.levenberg_marquardt import Searches
from testbed.estimation.likelihood import most_likely, require_physical
from testbed.estimation.momentum_equation import mean_momentum
from testbed.estimation.motion import Motion, simulate
from testbed.estimation.preparation import identifiable_part, likely_theta
from testbed.estimation.sensitivity import rate_sensitivity
from testbed.estimation.stated_noise import whitened
from testbed.estimation.telemetry import Telemetry


@dataclass(frozen=True, kw_only=True)
class AlignmentEstimate:
    """Inertia and alignments from one record, relative to a mean momentum scale of zero.

    Attributes:
        parameters: in the order of `parameter_names`, shape (P,), kg·m², rad, and shares; where not determined, the
            value that moves the least.
        covariance: of what is determined of them, shape (P, P), of the rank of the observability's basis.
        initial_momentum_B: of the whole platform at the first sample, N·m·s, body axes.
        observability: what the record determines, and what not.
        residual_sigma: rad/s, the unknowns' degrees of freedom taken off.
        iterations: rounds until the answer.
    """

    parameters: Array
    covariance: Array
    initial_momentum_B: Vector3
    observability: Observability
    residual_sigma: float
    iterations: int

    @property
    def std(self) -> Array:
        """Standard deviations, shape (P,); NaN where the record does not determine the parameter."""
        return np.where(self.observability.determined, np.sqrt(np.diag(self.covariance)), np.nan)


def estimated_alignments(telemetry: Telemetry, settings: EstimationSettings) -> AlignmentEstimate:
    """Estimate the inertia and each unit's misalignment, encoder zero and momentum scale from one run.

    The covariance is that of the linearised problem at the answer, scaled by its residual, on what is determined.

    Args:
        telemetry: one run with encoders, its initial momentum to be estimated.
        settings: the nominal inertia, which the search starts near.

    Raises:
        InputError: too few samples, no encoders, or no minimum.
        UnidentifiableError: the motion leaves directions of the inertia itself open.

    Source: paper eqs. (1), (4), (12), (13).
    """
    if telemetry.initial_momentum == "zero":
        raise InputError(
            'alignments need initial_momentum = "estimated": a misaligned cluster holds momentum even at rest'
        )
    part = identifiable_part(telemetry, settings)
    record = sampled_gimbals(part)
    theta = likely_theta(part, settings.nominal_theta)
    aligned = np.zeros(len(KINDS) * len(record.cluster.rotor_momentum))
    start = _Unknowns(parameters=np.concatenate([theta, aligned]), momentum_B=mean_momentum(part, theta))
    observable = _observability(part, record, start)
    answer = _search(part, record, start, observable)
    return _estimate(start, observable, answer)


def relative_parameters(theta: Theta, alignment: Alignment, working: Flags) -> Array:
    """Return parameters in the order of `parameter_names`, shape (P,), relative to a mean momentum scale of zero.

    (1 + k) and J are divided by the mean of 1 + k: what no motion tells apart becomes the same numbers.

    Args:
        theta: kg·m².
        alignment: with scales of any mean.
        working: which units' rotors carry momentum, shape (M,).
    """
    mean = float(np.mean(1.0 + alignment.momentum_scale[working]))
    scale = np.where(working, (1.0 + alignment.momentum_scale) / mean - 1.0, 0.0)
    return np.concatenate([theta / mean, replace(alignment, momentum_scale=scale).parameters])


@dataclass(frozen=True, kw_only=True)
class _Unknowns:
    parameters: Array
    momentum_B: Vector3

    @property
    def theta(self) -> Theta:
        return self.parameters[:6]

    @property
    def alignment(self) -> Alignment:
        return alignment_of(self.parameters[6:])


def _motion(record: SampledGimbals, unknowns: _Unknowns) -> Motion:
    require_physical(unknowns.theta)
    return simulate(drive_at(record, unknowns.alignment), unknowns.theta, unknowns.momentum_B)


def _columns(record: SampledGimbals, unknowns: _Unknowns, motion: Motion) -> Regressor:
    """∂ω/∂(θ, alignments, L₀), shape (3N, P + 3)."""
    alignment = unknowns.alignment
    held = held_momentum(record, alignment, motion)
    return rate_sensitivity(drive_at(record, alignment), motion, held).reshape(-1, len(unknowns.parameters) + 3)


def _observability(telemetry: Telemetry, record: SampledGimbals, start: _Unknowns) -> Observability:
    columns = without_momentum(_columns(record, start, _motion(record, start)), unknowns=len(start.parameters))
    return observability(columns, telemetry.gyro_noise, start.theta, working_units(record.cluster))


def _search(telemetry: Telemetry, record: SampledGimbals, start: _Unknowns, observable: Observability) -> Searches:
    """Search over coordinates in the basis of the observable directions, and over the initial momentum."""

    def motion(values: Array, _: Indices) -> Motion:
        return _motion(record, _moved(start, observable, values[0]))

    def sensitivity(values: Array, _: Indices, at: Motion) -> Regressor:
        columns = _columns(record, _moved(start, observable, values[0]), at)
        return np.hstack([columns[:, :-3] @ _steps(observable), columns[:, -3:]])

    first = np.concatenate([np.zeros(observable.basis.shape[1]), start.momentum_B])
    return most_likely(telemetry.body_rate[None], first[None], motion, sensitivity, partial(whitened, telemetry))


def _steps(observable: Observability) -> Array:
    """Parameters per coordinate, shape (P, r), SI."""
    return np.asarray(observable.scale[:, None] * observable.basis)


def _moved(start: _Unknowns, observable: Observability, values: Array) -> _Unknowns:
    return _Unknowns(parameters=start.parameters + _steps(observable) @ values[:-3], momentum_B=values[-3:])


def _estimate(start: _Unknowns, observable: Observability, answer: Searches) -> AlignmentEstimate:
    residual, columns, values = answer.residual[0], answer.columns[0], answer.unknowns[0]
    variance = float(residual @ residual) / (residual.size - values.size)
    covariance = variance * np.linalg.inv(columns.T @ columns)  # eqs. (12), (13)
    steps, end = _steps(observable), _moved(start, observable, values)
    return AlignmentEstimate(
        parameters=end.parameters,
        covariance=steps @ covariance[:-3, :-3] @ steps.T,
        initial_momentum_B=end.momentum_B,
        observability=observable,
        residual_sigma=float(np.sqrt(variance)),
        iterations=int(answer.rounds[0]),
    )
