"""montecarlo.json of a campaign."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from testbed.formats.parts import Part, Provenance, SixOrNull, ThreeOrNull


class OffsetFigures(Part):
    """The centre of mass on an air bearing, from the pivot, over the completed runs; lists in body axes x, y, z."""

    mean_m: ThreeOrNull
    """Mean truth plus mean error, m."""
    std_m: ThreeOrNull
    """Scatter: standard deviation of the errors, m."""
    claimed_std_m: ThreeOrNull
    """Mean of the standard deviations that the estimator states, m."""
    bias_in_standard_errors: ThreeOrNull
    """Mean error over its standard error, a pure number."""
    coverage_95: ThreeOrNull
    """Share of its 95 % intervals that hold the truth, 0 to 1."""
    scatter_over_bound: ThreeOrNull
    """Scatter over the Cramér-Rao bound's standard deviation, a pure number."""


class EstimatorFigures(Part):
    """One estimator over the completed runs; lists in the order J11, J22, J33, J23, J13, J12.

    Null stands where there is no finite number, as where no run was completed.
    """

    runs: int
    """Number of runs in which it gave an estimate."""
    mean_kg_m2: SixOrNull
    """Mean truth plus mean error, kg·m²."""
    std_kg_m2: SixOrNull
    """Scatter: standard deviation of the errors, kg·m²."""
    claimed_std_kg_m2: SixOrNull
    """Mean of the standard deviations that it states, kg·m²."""
    bias_in_standard_errors: SixOrNull
    """Mean error over its standard error, a pure number."""
    coverage_95: SixOrNull
    """Share of its 95 % intervals that hold the truth, 0 to 1."""
    scatter_over_bound: SixOrNull
    """Scatter over the Cramér-Rao bound's standard deviation, a pure number."""
    center_of_mass_offset: OffsetFigures | None = None
    """The same figures of the centre of mass; absent but on an air bearing."""


class FailedRun(Part):
    """A run that was not completed."""

    run: int
    """Number of the run, from 0."""
    seed: int
    """Its seed: `testbed run SCENARIO --seed` with it flies the run again."""
    message: str
    """What happened."""


class Unestimated(Part):
    """An estimator that gave no estimate of some completed runs."""

    estimator: str
    """Its name: `ls`, `iv`, `iv_momentum`, `output_error`."""
    runs: int
    """Number of these runs."""
    message: str
    """The most frequent reason."""


class EngineCheck(Part):
    """Runs that were flown by MuJoCo and by the compiled equations of motion, both from the same seeds."""

    runs: int
    """How many."""
    largest_difference_rad_s: float
    """Largest difference of their true body rates at the control ticks, about any axis, rad/s."""
    run: int
    """Number of the run in which it is."""


class CampaignResult(Part):
    """montecarlo.json: bias, scatter and coverage of every estimator over many flights."""

    schema_version: Annotated[Literal[1], Field(alias="schema")]
    """Version of this format."""
    scenario: str
    """Name of the scenario."""
    seed: int
    """Seed of the campaign, from which every run's is made."""
    runs: int
    """Number of runs, failed ones included."""
    failed: int
    """Number of runs that were not completed."""
    estimates: dict[str, EstimatorFigures]
    """By estimator: `ls`, `iv`, `iv_momentum`, `output_error`; one that gave fewer than two estimates is absent."""
    bound_std_kg_m2: SixOrNull
    """Standard deviation at the Cramér-Rao bound, root mean square over the runs, kg·m²."""
    true_theta_kg_m2: SixOrNull
    """Mean of the true θ over the runs, kg·m²."""
    failures: list[FailedRun]
    """Every failed run."""
    unestimated: list[Unestimated] = Field(default_factory=list)
    """Estimators that gave no estimate of some completed runs; absent where there are none."""
    seconds: float
    """Time that flying and estimating took, s."""
    simulated_s: float
    """Flight time of all completed runs together, s."""
    engine_check: EngineCheck | None = None
    """How far the engines come out apart; absent but with `--check`."""
    provenance: Provenance
    """What decides the result."""
