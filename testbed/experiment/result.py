"""The figures of a run in the form of result.json."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from testbed.arrays import Array
from testbed.assembly.platform import Body
from testbed.dynamics.environment import Pivoted
from testbed.dynamics.inertia import theta_of
from testbed.estimation.agreement import Agreement
from testbed.estimation.combine import CombinedEstimate
from testbed.estimation.estimate import Estimate
from testbed.experiment.aligning import aligning_result
from testbed.experiment.checking import Checks, Compared
from testbed.experiment.experiment import Estimation, Experiment
from testbed.experiment.flying import FlownRun
from testbed.maneuver.design import Design

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
        "truth": parameters_of(experiment.truth),
        "nominal": parameters_of(experiment.nominal),
        "estimates": {} if estimation is None else estimates_of(estimation.by_name, estimation.pivot),
        "alignments": None if experiment.aligning is None else aligning_result(experiment.aligning),
        "failures": {} if estimation is None else dict(estimation.failures),
        "checks": None if estimation is None else checks_result(estimation.checks),
        "bound_std_kg_m2": None if bound is None else _numbers(bound),
        **({} if estimation is None else offset_bound_of(estimation)),
        **_flight(experiment.flown),
        "design": None if design is None else design_of(design),
    }


def parameters_of(body: Body) -> dict[str, Any]:
    """Return a platform's inertia, and where on a pivot its centre of mass is."""
    offset = {}
    if isinstance(body.environment, Pivoted):
        offset = {"center_of_mass_offset_m": _numbers(body.environment.offset_B)}
    return {"theta_kg_m2": _numbers(theta_of(body.inertia)), **offset}


def offset_bound_of(estimation: Estimation) -> dict[str, Any]:
    """Return the bound of the offset of the centre of mass; nothing without a pivot."""
    bound = estimation.offset_bound_std
    return {} if bound is None else {"bound_center_of_mass_offset_std_m": _numbers(bound)}


def estimates_of(
    by_name: Mapping[str, Estimate] | Mapping[str, CombinedEstimate], pivot: Pivoted | None = None
) -> dict[str, Any]:
    """Return each estimator's answer by its name.

    θ̂ with its standard deviations, everything considered; those by the gyro's noise alone; the most likely inertia that
    a body has; and what was estimated jointly, constant torques and on a pivot the place of the centre of mass.
    """
    return {
        name: {
            "theta_kg_m2": _numbers(estimate.theta),
            "std_kg_m2": _numbers(estimate.std),
            "noise_std_kg_m2": _numbers(estimate.noise_std),
            "body_theta_kg_m2": _numbers(estimate.body_theta),
            **_constant_torque(estimate),
            **_offset(estimate, pivot),
        }
        for name, estimate in by_name.items()
    }


def checks_result(checks: Checks | None) -> dict[str, Any] | None:
    """Return the checks of a record's estimates; p-values hold for a complete model and the stated noise."""
    if checks is None:
        return None
    residual = checks.residual
    return {
        "residual": {
            "estimator": checks.best,
            "size": residual.size,
            "size_p_value": residual.size_p_value,
            "whiteness_p_value": residual.whiteness_p_value if np.isfinite(residual.whiteness_p_value) else None,
        },
        "estimators_agreement": compared_result(checks.compared),
        "neglected_torque": [
            {"fixed_in": each.frame, "size_N_m": each.size, "moves": each.parameter} for each in checks.neglected
        ],
    }


def compared_result(compared: Compared | None) -> dict[str, Any] | None:
    """Return how an efficient and a robust estimator agree."""
    if compared is None:
        return None
    return {"efficient": compared.efficient, "robust": compared.robust, **agreement_result(compared.agreement)}


def agreement_result(agreement: Agreement) -> dict[str, Any]:
    """Return how well estimates agree."""
    return {"chi_square": agreement.chi_square, "freedom": agreement.freedom, "p_value": agreement.p_value}


def _constant_torque(estimate: Estimate | CombinedEstimate) -> dict[str, Any]:
    if not isinstance(estimate, Estimate) or not estimate.constant_torque.size:
        return {}
    names, torque, std = estimate.torque_names, estimate.constant_torque, estimate.constant_torque_std
    return {
        "constant_torque_N_m": dict(zip(names, _numbers(torque), strict=True)),
        "constant_torque_std_N_m": dict(zip(names, _numbers(std), strict=True)),
    }


def _offset(estimate: Estimate | CombinedEstimate, pivot: Pivoted | None) -> dict[str, Any]:
    if pivot is None:
        return {}
    offset = pivot.offset_B + estimate.offset_error
    return {
        "center_of_mass_offset_m": _numbers(offset),
        "center_of_mass_offset_std_m": _numbers(estimate.offset_std),
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
    """Return every start of a design, counted from 1; the cost of one that broke a limit is null."""
    return [
        {
            "start": start.number,
            "cost": start.cost if np.isfinite(start.cost) else None,
            "seconds": start.seconds,
            "status": start.status,
        }
        for start in design.starts
    ]


def _flight(flown: FlownRun) -> dict[str, Any]:
    summary = flown.summary
    return {
        "tracking": {"rms_rad_s": _numbers(summary.tracking_rms), "max_rad_s": _numbers(summary.tracking_max)},
        "limits": {
            **summary.limit_use,
            "saturated_s": summary.saturated,
            "rotor_clamped_s": summary.rotor_clamped,
            "min_singularity_measure": summary.min_singularity_measure,
            **({"largest_tilt_rad": summary.largest_tilt} if flown.tilt_limit is not None else {}),
        },
        "conservation": {"momentum_drift_relative": summary.momentum_drift},
    }


def _numbers(values: Array) -> list[float]:
    return [float(value) for value in np.asarray(values)]
