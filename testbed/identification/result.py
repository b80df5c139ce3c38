"""The inertia from measured records in the form of estimates.json."""

from __future__ import annotations

from typing import Any

from testbed.arrays import Theta
from testbed.experiment.experiment import Estimation
from testbed.experiment.result import (
    SCHEMA,
    agreement_result,
    checks_result,
    compared_result,
    estimates_of,
    offset_bound_of,
)
from testbed.identification.identify import Identification
from testbed.scenario.body import BodyScenario


def identification_result(
    identification: Identification, scenario: BodyScenario, nominal_theta: Theta
) -> dict[str, Any]:
    """Return what estimates.json holds.

    Args:
        identification: the records and what they say.
        scenario: the nominal model and the estimators.
        nominal_theta: of the nominal model, kg·m².
    """
    combined = identification.combined
    return {
        "schema": SCHEMA,
        "scenario": scenario.name,
        "nominal": {"theta_kg_m2": nominal_theta.tolist()},
        "records": {name: _record(estimation) for name, estimation in identification.estimations.items()},
        "combined": estimates_of(combined.by_name, combined.pivot),
        "combined_checks": {
            "runs_agreement": {name: agreement_result(each) for name, each in combined.runs_agreement.items()},
            "estimators_agreement": compared_result(combined.compared),
        },
        "notices": list(identification.notices),
        "left_out": list(identification.refused),
    }


def _record(estimation: Estimation) -> dict[str, object]:
    bound = estimation.bound_std
    return {
        "estimates": estimates_of(estimation.by_name, estimation.pivot),
        "failures": dict(estimation.failures),
        "bound_std_kg_m2": None if bound is None else bound.tolist(),
        **offset_bound_of(estimation),
        "initial_momentum": estimation.initial_momentum,
        "zero_momentum_p_value": estimation.zero_momentum_p_value,
        "outliers": estimation.outliers,
        "checks": checks_result(estimation.checks),
    }
