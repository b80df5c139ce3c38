"""Alignments from a simulated flight, beside what was built."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from testbed.arrays import Array
from testbed.assembly.estimators import estimation_settings
from testbed.assembly.platform import PlatformModel
from testbed.assembly.telemetry import telemetry_of
from testbed.dynamics.inertia import theta_of
from testbed.errors import InputError
from testbed.estimation.alignment import AlignmentEstimate, estimated_alignments, relative_parameters
from testbed.estimation.alignment_model import Alignment, working_units
from testbed.estimation.alignment_observability import (
    CONVENTION,
    Observability,
    parameter_names,
    parameter_units,
    unit_count,
)
from testbed.records.record import Record
from testbed.scenario.scenario import Scenario
from testbed.scenario.values import per_unit


@dataclass(frozen=True, kw_only=True)
class Aligning:
    """The alignments as estimated from a flight.

    Attributes:
        estimate: None where there is none.
        failure: why there is none; empty otherwise.
        true_parameters: in the estimate's order and relative to the same mean momentum scale, shape (P,).
    """

    estimate: AlignmentEstimate | None
    failure: str
    true_parameters: Array


def align_flight(scenario: Scenario, nominal: PlatformModel, truth: PlatformModel, record: Record) -> Aligning:
    """Estimate inertia and alignments from a flight; one that gives no estimate is still worth keeping.

    Args:
        scenario: sensors and what is known of the initial momentum.
        nominal: what is believed of the units.
        truth: what flew, to be put beside the estimate.
        record: of the flight.
    """
    estimate, failure = None, ""
    try:
        settings = estimation_settings(scenario, nominal, maneuver=None)
        estimate = estimated_alignments(telemetry_of(record, scenario, nominal), settings)
    except InputError as error:
        failure = str(error)
    except np.linalg.LinAlgError:
        failure = "the alignments cannot be determined: the record's equations are singular"
    return Aligning(estimate=estimate, failure=failure, true_parameters=true_parameters(scenario, nominal, truth))


def true_parameters(scenario: Scenario, nominal: PlatformModel, truth: PlatformModel) -> Array:
    """Return inertia and alignments as built, relative to a mean momentum scale of zero, shape (P,)."""
    units = scenario.gyros.units
    scale = 1.0 + np.array(per_unit(scenario.tachometer.scale_factor_error, units, 0.0))
    read = scale * nominal.cluster.rotor_spin_inertia
    built = Alignment(
        misalignment=np.array(per_unit(scenario.truth.gimbal_axis_misalignment_rad, units, (0.0, 0.0))),
        encoder_zero=np.array(per_unit(scenario.encoder.zero_rad, units, 0.0)),
        momentum_scale=truth.cluster.rotor_spin_inertia / read - 1.0,
    )
    return relative_parameters(theta_of(truth.inertia), built, working_units(nominal.cluster))


def null_space_lines(observability: Observability) -> Iterator[str]:
    """Return the directions that a record does not identify, a line each, the common scale and its convention first."""
    common = observability.common_scale
    yield f"{common.name}: ±{common.std:.0%} at best, by the gimbals' own inertia alone; {CONVENTION}"
    for each in observability.others:
        seen = f"±{each.std:.2g} (rad, shares) at best" if np.isfinite(each.std) else "not seen at all"
        yield f"{each.name}: {seen}; the parameters are not moved along it"


def aligning_result(aligning: Aligning) -> dict[str, Any]:
    """Return what result.json says of the alignments."""
    estimate = aligning.estimate
    if estimate is None:
        return {"message": aligning.failure, "parameters": {}, "null_space": []}
    units = unit_count(len(estimate.parameters))
    rows = zip(
        parameter_names(units),
        parameter_units(units),
        estimate.parameters,
        estimate.std,
        aligning.true_parameters,
        strict=True,
    )
    return {
        "message": None,
        "parameters": {
            name: {
                "value": float(value),
                "std": float(std) if np.isfinite(std) else None,
                "true": float(true),
                "unit": unit,
            }
            for name, unit, value, std, true in rows
        },
        "null_space": list(null_space_lines(estimate.observability)),
    }
