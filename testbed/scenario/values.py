"""Types of the values in a scenario: ranges, lists of fixed length, inertia matrices, files beside the scenario."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal, TypeAlias, TypeVar

import numpy as np
from pydantic import AfterValidator, BeforeValidator, Discriminator, Field, Strict, Tag, ValidationInfo

from testbed.limits import LARGEST_SEED
from testbed.quantities import LONGEST, Angle, BodyRate, Place, Velocity
from testbed.signals import MOST_UNITS

_Entry = TypeVar("_Entry")

_ROUNDING = 1e-9
"""Relative slack on physical inequalities: far above rounding, far below any hardware's tolerance."""

_LEAST_MOMENT = 1e-9
"""kg·m²; the smallest principal moment of a platform. A chip satellite of 4 g and 35 mm has 4e-7."""


def per_unit(values: tuple[_Entry, ...], units: int, none: _Entry) -> tuple[_Entry, ...]:
    """Return a value for each of so many units: those of a list, or none where it is empty."""
    return values or (none,) * units


def _entries(count: int) -> BeforeValidator:
    def check(value: object) -> object:
        if isinstance(value, list | tuple) and len(value) != count:
            raise ValueError(f"has {len(value)} entries instead of {count}")
        return value

    return BeforeValidator(check)


def _physical_inertia(inertia: Inertia) -> Inertia:
    matrix = np.array(inertia)
    if not np.array_equal(matrix, matrix.T):
        raise ValueError("is not symmetric; write each product of inertia twice, with the sign of eq. (3)")
    smallest, middle, largest = moments = np.linalg.eigvalsh(matrix)
    shown = ", ".join(f"{moment:.4g}" for moment in moments)
    if smallest <= 0.0:
        raise ValueError(f"is not positive definite: its principal moments are {shown}")
    if smallest < _LEAST_MOMENT:
        raise ValueError(f"has the principal moments {shown}; the least that any platform has is {_LEAST_MOMENT}")
    if largest > (smallest + middle) * (1.0 + _ROUNDING):
        raise ValueError(f"belongs to no body: of its principal moments {shown} the largest exceeds the others' sum")
    return inertia


def _unit_quaternion(quat: tuple[float, ...]) -> tuple[float, ...]:
    norm = float(np.linalg.norm(quat))
    if abs(norm - 1.0) > 1e-6:  # six decimals written in the file pass
        raise ValueError(f"has the norm {norm:.6g} instead of 1")
    return quat


def _unit_vector(vector: tuple[float, ...]) -> tuple[float, ...]:
    norm = float(np.linalg.norm(vector))
    if norm == 0.0:
        raise ValueError("is zero, which has no direction")
    if abs(norm - 1.0) > 1e-6:  # as of a quaternion
        raise ValueError(f"has the length {norm:.6g} instead of 1; divide it by that")
    return vector


def _located(path: Path, info: ValidationInfo) -> Path:
    if info.context is None:
        return path
    located = Path(info.context["folder"]) / path
    if not located.is_file():
        raise ValueError(f"there is no file {located}; paths are relative to the scenario's folder")
    return located


def _distinct(values: tuple[Any, ...]) -> tuple[Any, ...]:
    if len(set(values)) != len(values):
        raise ValueError("names an entry twice")
    return values


def _many_or_one(value: object) -> str:
    return "many" if isinstance(value, list | tuple) else "one"


Step: TypeAlias = Annotated[float, Field(ge=1e-6, le=1)]
"""s."""
Duration: TypeAlias = Annotated[float, Field(ge=1e-3, le=LONGEST)]
"""s; within a millisecond no platform turns by what a gyro sees."""
PrefilterTime: TypeAlias = Annotated[float, Field(ge=1e-3, le=1e3)]
"""s. Beyond these a prefilter passes a flight of seconds unchanged, or nothing of it."""
Rate: TypeAlias = Annotated[float, Field(ge=1e-3, le=1e5)]
"""Hz; within a flight of an hour, 3 samples at the least."""
Share: TypeAlias = Annotated[float, Field(ge=1e-3, le=1)]
Seed: TypeAlias = Annotated[int, Field(ge=0, le=LARGEST_SEED)]
Three: TypeAlias = Annotated[tuple[_Entry, _Entry, _Entry], Strict(False), _entries(3)]
Four: TypeAlias = Annotated[tuple[_Entry, _Entry, _Entry, _Entry], Strict(False), _entries(4)]
Six: TypeAlias = Annotated[tuple[_Entry, _Entry, _Entry, _Entry, _Entry, _Entry], Strict(False), _entries(6)]
Axes: TypeAlias = Annotated[tuple[Literal["x", "y", "z"], ...], Strict(False), AfterValidator(_distinct)]
"""Body axes, each once."""
Places: TypeAlias = Three[Place]
Velocities: TypeAlias = Three[Velocity]
BodyRates: TypeAlias = Three[BodyRate]
PerUnit: TypeAlias = Annotated[tuple[_Entry, ...], Strict(False), Field(max_length=MOST_UNITS)]
"""A value for each unit of the cluster; an empty list stands for zero everywhere."""
Angles: TypeAlias = PerUnit[Angle]
Pair: TypeAlias = Annotated[tuple[_Entry, _Entry], Strict(False), _entries(2)]
_Product: TypeAlias = Annotated[float, Field(ge=-1e9, le=1e9)]
_Component: TypeAlias = Annotated[float, Field(ge=-2, le=2)]
Inertia: TypeAlias = Annotated[
    tuple[Three[_Product], Three[_Product], Three[_Product]],
    Strict(False),
    _entries(3),
    AfterValidator(_physical_inertia),
]
UnitQuaternion: TypeAlias = Annotated[Four[_Component], AfterValidator(_unit_quaternion)]
UnitVector: TypeAlias = Annotated[Three[_Component], AfterValidator(_unit_vector)]
File: TypeAlias = Annotated[Path, Strict(False), AfterValidator(_located)]
Distinct = AfterValidator(_distinct)
ManyOrOne = Discriminator(_many_or_one)
"""Tells a list from a single value, so that only the errors of the form that was meant are reported."""
One = Tag("one")
Many = Tag("many")
