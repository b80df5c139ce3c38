"""The columns of a campaign's data set: the same in every part of it, whatever its runs were like."""

from __future__ import annotations

from collections.abc import Iterator

import pyarrow as pa

from testbed.dynamics.inertia import PARAMETER_NAMES
from testbed.scenario.environment import AirBearing
from testbed.scenario.scenario import Scenario

_FLIGHT = (
    *(f"tracking_rms_{axis}_rad_s" for axis in "xyz"),
    "saturated_s",
    "min_singularity_measure",
    "momentum_drift_relative",
    "first_contact_s",
)


def parameter_columns(prefix: str) -> tuple[str, ...]:
    """Return the six columns of a θ or of its standard deviations, in the order of θ.

    Args:
        prefix: `true`, `bound_std`, an estimator's name, or that with `_std`.
    """
    return tuple(f"{prefix}_{name}_kg_m2" for name in PARAMETER_NAMES)


def offset_columns(prefix: str) -> tuple[str, ...]:
    """Return the three columns of the place of the centre of mass on an air bearing, or of its standard deviations.

    Args:
        prefix: as in `parameter_columns`.
    """
    return tuple(f"{prefix}_center_of_mass_offset_{axis}_m" for axis in "xyz")


FAILURE = "_failure"
"""Behind an estimator's name: why it gave no estimate of a flight."""


def schema_of(scenario: Scenario) -> pa.Schema:
    """Return the columns of a scenario's campaigns; a run that has no such value leaves it null."""
    return pa.schema(list(_fields(scenario)))


def _fields(scenario: Scenario) -> Iterator[pa.Field]:
    yield pa.field("run", pa.int64(), nullable=False)
    yield pa.field("seed", pa.int64(), nullable=False)
    yield pa.field("outcome", pa.string(), nullable=False)
    yield pa.field("message", pa.string(), nullable=False)
    estimators = scenario.estimation.estimators
    for prefix in ("true", "bound_std", *(part for name in estimators for part in (name, f"{name}_std"))):
        yield from (pa.field(column, pa.float64()) for column in parameter_columns(prefix))
        if isinstance(scenario.environment, AirBearing):
            yield from (pa.field(column, pa.float64()) for column in offset_columns(prefix))
    yield from (pa.field(f"{name}{FAILURE}", pa.string()) for name in estimators)
    yield from (pa.field(column, pa.float64()) for column in _FLIGHT)
