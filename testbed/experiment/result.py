"""The figures of a run in the form of result.json."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from testbed.arrays import Array
from testbed.dynamics.inertia import theta_of
from testbed.estimation.combine import CombinedEstimate
from testbed.estimation.estimate import Estimate
from testbed.experiment.aligning import aligning_result
from testbed.experiment.experiment import Experiment
from testbed.maneuver.design import Design
from testbed.simulation.summary import FlightSummary

SCHEMA = 1


def result_of(experiment: Experiment) -> dict[str, Any]:
    """Return what result.json holds; parts that the run does not have are null."""
    estimation, design = experiment.estimation, experiment.plan.design
    bound = None if estimation is None else estimation.bound_std
    return {
        "schema": SCHEMA,
        "scenario": experiment.scenario.name,
        "seed": experiment.seed,
        "outcome": experiment.outcome,
        "message": experiment.flown.divergence or None,
        "truth": {"theta_kg_m2": _numbers(theta_of(experiment.truth.inertia))},
        "nominal": {"theta_kg_m2": _numbers(theta_of(experiment.nominal.inertia))},
        "estimates": {} if estimation is None else estimates_of(estimation.by_name),
        "alignments": None if experiment.aligning is None else aligning_result(experiment.aligning),
        "failures": {} if estimation is None else dict(estimation.failures),
        "bound_std_kg_m2": None if bound is None else _numbers(bound),
        **_flight(experiment.flown.summary),
        "design": None if design is None else design_of(design),
    }


def estimates_of(by_name: Mapping[str, Estimate] | Mapping[str, CombinedEstimate]) -> dict[str, Any]:
    """Return each estimator's θ̂ and standard deviations by its name."""
    return {
        name: {"theta_kg_m2": _numbers(estimate.theta), "std_kg_m2": _numbers(estimate.std)}
        for name, estimate in by_name.items()
    }


def design_of(design: Design) -> dict[str, Any]:
    """Return the metrics of Ψ_fᵀΨ_f and the time of one start."""
    information = design.information
    return {
        "criterion": design.criterion,
        "parametrization": design.parametrization,
        "min_eigenvalue": float(information.min_eigenvalue),
        "trace_inverse": float(information.trace_inverse),
        "determinant": float(information.determinant),
        "condition_number": float(information.condition_number),
        "seconds": float(design.seconds),
    }


def starts_of_design(design: Design) -> list[dict[str, Any]]:
    """Return every start of a design; the cost of one that broke a limit is null."""
    return [
        {
            "start": start.index,
            "cost": start.cost if np.isfinite(start.cost) else None,
            "seconds": start.seconds,
            "status": start.status,
        }
        for start in design.starts
    ]


def _flight(summary: FlightSummary) -> dict[str, Any]:
    return {
        "tracking": {"rms_rad_s": _numbers(summary.tracking_rms), "max_rad_s": _numbers(summary.tracking_max)},
        "limits": {
            **summary.limit_use,
            "saturated_s": summary.saturated,
            "rotor_clamped_s": summary.rotor_clamped,
            "min_singularity_measure": summary.min_singularity_measure,
        },
        "conservation": {"momentum_drift_relative": summary.momentum_drift},
    }


def _numbers(values: Array) -> list[float]:
    return [float(value) for value in np.asarray(values)]
