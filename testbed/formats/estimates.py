"""estimates.json of records measured elsewhere."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from testbed.formats.parts import (
    Agreement,
    Checks,
    Estimate,
    EstimatorsAgreement,
    Parameters,
    Part,
    Provenance,
    Six,
    Three,
)


class RecordEstimates(Part):
    """What one record says of the inertia."""

    estimates: dict[str, Estimate]
    """By estimator: `ls`, `iv`, `iv_momentum`, `output_error`."""
    failures: dict[str, str]
    """Why an estimator gave no estimate, by estimator."""
    bound_std_kg_m2: Six | None
    """Square root of the Cramér-Rao bound's diagonal at the most efficient estimate, kg·m²; null without one."""
    bound_center_of_mass_offset_std_m: Three | None = None
    """The same of the centre of mass on an air bearing, m; absent in another environment."""
    initial_momentum: Literal["estimated", "zero"]
    """Whether the initial momentum was estimated, or taken to be zero."""
    zero_momentum_p_value: float | None
    """Chance of this record if the initial momentum was zero, 0 to 1; null where that was not assumed."""
    outliers: int
    """Number of gyro samples that were left out as outliers."""
    checks: Checks | None
    """Null where there is no estimate to check."""


class CombinedChecks(Part):
    """Whether the records may be taken together."""

    runs_agreement: dict[str, Agreement]
    """Whether the records agree with each other, by estimator; empty for a single record."""
    estimators_agreement: EstimatorsAgreement | None
    """Whether an efficient and a robust estimator agree over all records; null where they cannot be compared."""


class EstimatesResult(Part):
    """estimates.json: the inertia from every record, and from all of them together."""

    schema_version: Annotated[Literal[1], Field(alias="schema")]
    """Version of this format."""
    scenario: str
    """Name of the scenario."""
    nominal: Parameters
    """The nominal model."""
    records: dict[str, RecordEstimates]
    """By name of the record."""
    combined: dict[str, Estimate]
    """The average of all records with the inverse covariances as weights, by estimator; on an air bearing with the
    centre of mass."""
    combined_checks: CombinedChecks
    """What speaks for or against the combination."""
    notices: list[str]
    """What a reader has to know, a sentence each."""
    left_out: list[str]
    """Records that could not be used, each with the reason."""
    provenance: Provenance
    """What decides the result."""
