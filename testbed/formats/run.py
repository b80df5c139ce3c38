"""result.json of a run."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from testbed.formats.parts import Checks, Estimate, Parameters, Part, Provenance, Six, Three


class Tracking(Part):
    """True body rate minus reference."""

    rms_rad_s: Three
    """Root mean square about each body axis, rad/s."""
    max_rad_s: Three
    """Largest magnitude about each body axis, rad/s."""


class Limits(Part):
    """How far the actuators were driven; fractions of a limit are the largest of the flight, 1 at the limit."""

    gimbal_rate: float | None = None
    """Fraction of the gimbal rate's limit; absent without control moment gyros."""
    gimbal_torque: float | None = None
    """Fraction of the gimbal torque's limit; absent without control moment gyros."""
    cluster_momentum: float
    """Fraction of the cluster momentum's limit about the worst body axis."""
    cluster_torque: float
    """Fraction of the cluster torque's limit about the worst body axis."""
    wheel_torque: float | None = None
    """Fraction of the reaction wheels' torque limit; absent without wheels."""
    wheel_speed: float | None = None
    """Fraction of the speed at which a wheel is at its momentum limit; absent without wheels."""
    saturated_s: float
    """Time in which any gimbal, or the torque of any wheel, was at a limit, s."""
    rotor_clamped_s: float
    """Time in which any rotor or wheel was at its momentum limit, s."""
    min_singularity_measure: float | None
    """Smallest singularity measure on the way; 1 at the best, 0 where a direction of torque is lost; null without
    control moment gyros."""
    largest_tilt_rad: float | None = None
    """Largest angle between the body z axis and the vertical, rad; absent but on an air bearing."""


class Conservation(Part):
    """How well the simulation conserves momentum."""

    momentum_drift_relative: float
    """max |H_N(t) - H_N(0)| over the sum of the rotors' momenta, without what the environment did; a pure number."""


class Design(Part):
    """The designed maneuver's information Ψ_fᵀΨ_f, eq. (32); Ψ_f is in N·m per kg·m², which is 1/s²."""

    criterion: Literal["D", "A", "E", "condition"]
    """What was optimised."""
    parametrization: Literal["gimbal", "body_rate", "actuator"]
    """What the splines describe."""
    min_eigenvalue: float
    """Smallest eigenvalue of Ψ_fᵀΨ_f, 1/s⁴."""
    trace_inverse: float
    """Trace of (Ψ_fᵀΨ_f)⁻¹, s⁴."""
    determinant: float
    """Determinant of Ψ_fᵀΨ_f, 1/s²⁴."""
    condition_number: float
    """Condition number of Ψ_fᵀΨ_f, a pure number."""
    seconds: float
    """Computing time of one start of the optimiser, s."""


class AlignmentParameter(Part):
    """An inertia parameter or an alignment, estimated together with all others."""

    value: float
    """The estimate, in `unit`."""
    std: float | None
    """Its standard deviation, in `unit`; null where the record does not show it."""
    true: float
    """The value that was flown, in `unit`."""
    unit: Literal["kg·m²", "rad", "1"]
    """Of value, std and true; `1` for a pure number."""


class Alignments(Part):
    """Inertia and alignments of the units, estimated together."""

    message: str | None
    """Why there is no estimate; null where there is one."""
    parameters: dict[str, AlignmentParameter]
    """By name, such as `J11` or `momentum scale of cmg3`; empty without an estimate."""
    null_space: list[str]
    """Directions that the record does not identify, a sentence each."""


class RunResult(Part):
    """result.json: truth, estimates and figures of one flight."""

    schema_version: Annotated[Literal[1], Field(alias="schema")]
    """Version of this format."""
    scenario: str
    """Name of the scenario."""
    seed: int
    """Seed of all sensor noise, and of the dispersions where there are any."""
    outcome: Literal["completed", "diverged"]
    """Whether the flight reached its end."""
    message: str | None
    """When and how the flight diverged; null where it was completed."""
    truth: Parameters
    """The platform that flew."""
    nominal: Parameters
    """The platform that controller and estimators believe in."""
    estimates: dict[str, Estimate]
    """By estimator: `ls`, `iv`, `iv_momentum`, `output_error`; empty where the flight diverged."""
    alignments: Alignments | None
    """Null where the scenario does not ask for them."""
    failures: dict[str, str]
    """Why an estimator gave no estimate, by estimator."""
    checks: Checks | None
    """Null where there is no estimate to check."""
    bound_std_kg_m2: Six | None
    """Square root of the Cramér-Rao bound's diagonal for the motion as flown, kg·m²; null where there is no bound."""
    bound_center_of_mass_offset_std_m: Three | None = None
    """The bound's standard deviations of the centre of mass on an air bearing, m; absent in another environment."""
    tracking: Tracking
    """How well the maneuver was flown."""
    limits: Limits
    """How far the actuators were driven."""
    conservation: Conservation
    """What should not have changed in flight."""
    design: Design | None
    """The maneuver's design; null where the scenario gives the maneuver."""
    provenance: Provenance
    """What decides the result."""
