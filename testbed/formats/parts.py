"""What the files share: how a part of one is described, lists of fixed length, provenance."""

from __future__ import annotations

from typing import Annotated, TypeAlias

from pydantic import BaseModel, ConfigDict, Field, ValidationError


class Part(BaseModel):
    """One object of a file. It has these keys and no others.

    The text below a key is its description in the JSON Schema and on the site. A key that may hold null is there all
    the same; one with a default may be left out.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False, use_attribute_docstrings=True)


def first_fault(form: type[Part], content: object) -> str | None:
    """Return the first thing in a file's content that no version of testbed writes; None where there is nothing.

    Keys that are missing, or that are not known, may be those of another version.

    Args:
        form: what the file holds.
        content: as JSON has it.
    """
    try:
        form.model_validate(content, strict=True)
    except ValidationError as error:
        faults = (each for each in error.errors() if each["type"] not in ("missing", "extra_forbidden"))
        return next((f"{'.'.join(map(str, each['loc']))}: {each['msg'].lower()}" for each in faults), None)
    return None


_SIX = Field(min_length=6, max_length=6)
_THREE = Field(min_length=3, max_length=3)

Six: TypeAlias = Annotated[list[float], _SIX]
"""A number for each inertia parameter, in the order J11, J22, J33, J23, J13, J12."""
SixOrNull: TypeAlias = Annotated[list[float | None], _SIX]
"""The same; null where there is no finite number."""
Three: TypeAlias = Annotated[list[float], _THREE]
"""A number for each body axis: x, y, z."""
ThreeOrNull: TypeAlias = Annotated[list[float | None], _THREE]
"""The same; null where there is none."""


class InputFile(Part):
    """A file that was read."""

    path: str
    """As it was given."""
    sha256: str
    """Hash of its content, hexadecimal."""
    size: int
    """Length of its content, bytes."""


class FilesProvenance(Part):
    """What decides a result that is made of files alone.

    Further keys hold text: what else decides, such as `seed`, `runs` or `model_sha256`, and a `version_...` of each
    package.
    """

    model_config = ConfigDict(extra="allow")
    __pydantic_extra__: dict[str, str]

    version_testbed: str
    """Version of this package."""
    inputs: list[InputFile]
    """Every file that was read."""


class Provenance(FilesProvenance):
    """What decides the result: the same inputs, seed and versions give it again.

    Further keys hold text: what else decides, such as `seed`, `runs` or `model_sha256`, and a `version_...` of each
    package.
    """

    scenario_sha256: str
    """Hash of the scenario file, hexadecimal."""


class Parameters(Part):
    """The inertia of a platform."""

    theta_kg_m2: Six
    """θ = J11, J22, J33, J23, J13, J12 in body axes, about the centre of mass, kg·m²."""
    center_of_mass_offset_m: Three | None = Field(default=None)
    """Where the centre of mass is from the pivot of an air bearing, body axes, m; absent in another environment."""


class Estimate(Part):
    """An estimate of the inertia."""

    theta_kg_m2: Six
    """θ̂ = J11, J22, J33, J23, J13, J12 in body axes, kg·m²."""
    std_kg_m2: Six
    """Standard deviation of each parameter, everything considered, kg·m²."""
    noise_std_kg_m2: Six
    """Standard deviation by noise alone, of the gyro and, in measured records, of the actuators' telemetry, kg·m²."""
    body_theta_kg_m2: Six
    """The most likely inertia that a rigid body can have; θ̂ itself where that is a body's, kg·m²."""
    constant_torque_N_m: dict[str, float] | None = Field(default=None)
    """Constant torques estimated together with θ, by frame and axis such as `inertial_x`, N·m; absent without."""
    constant_torque_std_N_m: dict[str, float] | None = Field(default=None)
    """Their standard deviations, N·m; absent without."""
    center_of_mass_offset_m: Three | None = Field(default=None)
    """Where the centre of mass is from the pivot of an air bearing, estimated together with θ, body axes, m; absent in
    another environment."""
    center_of_mass_offset_std_m: Three | None = Field(default=None)
    """Its standard deviations, everything considered, m; absent likewise."""


class Agreement(Part):
    """A χ² test of whether estimates agree."""

    chi_square: float
    """χ² of their differences, a pure number."""
    freedom: int
    """Its degrees of freedom."""
    p_value: float
    """Chance of differences as large, if all is well, 0 to 1."""


class EstimatorsAgreement(Agreement):
    """A χ² test of an efficient estimator against a robust one, which a wrong model biases differently."""

    efficient: str
    """Estimator with the smallest standard deviations."""
    robust: str
    """Estimator that it is compared with."""


class ResidualCheck(Part):
    """Whether a residual is the stated noise."""

    estimator: str
    """Whose residual it is."""
    size: float
    """Root mean square in standard deviations of the stated noise; 1 where model and noise are right."""
    size_p_value: float
    """Chance of a residual as large, if model and noise are as stated, 0 to 1."""
    whiteness_p_value: float | None
    """Chance of autocorrelations as large, if the noise is white, 0 to 1; null where samples are too few."""


class NeglectedTorque(Part):
    """A constant torque that is not estimated, and how small a one already matters."""

    fixed_in: str
    """Frame in which it is constant: `body` or `inertial`."""
    size_N_m: float
    """Torque that moves a parameter by one standard deviation, along the worst axis, N·m."""
    moves: str
    """The parameter that it moves, such as `J13`."""


class Checks(Part):
    """What speaks for or against the estimates of a record."""

    residual: ResidualCheck
    """The residual of the most efficient estimator."""
    estimators_agreement: EstimatorsAgreement | None
    """Whether an efficient and a robust estimator agree; null where fewer than two can be compared."""
    neglected_torque: list[NeglectedTorque]
    """Constant torques that are not estimated."""
