"""What every effect here is: how it changes the craft, of which size it typically is, and how it is made larger."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from concealing.craft import Array, Craft

PLATFORM, CLUSTER, GYRO, ACTUATORS = "platform", "cluster", "gyro", "actuators"
CMGS = tuple(f"cmg{number}" for number in range(1, 7))
AXES = ("x", "y", "z")
Parameters = Mapping[str, float]


@dataclass(frozen=True, kw_only=True)
class HiddenEffect:
    """One effect in a data set.

    Attributes:
        effect: its id.
        component: where it is.
        parameters: by name, in the units of its kind.
    """

    effect: str
    component: str
    parameters: Parameters

    def in_one_of(self, runs: int) -> HiddenEffect:
        """Return it in a run that there is, the last of so many where a later one was drawn."""
        if "run" not in self.parameters:
            return self
        return replace(self, parameters={**self.parameters, "run": min(self.parameters["run"], float(runs - 1))})


@dataclass(frozen=True, kw_only=True)
class EffectKind:
    """One kind of effect.

    Attributes:
        components: where it can be.
        units: of each parameter.
        apply: returns the craft with the effect.
        draw: parameters of a typical size, in a random direction.
        growing: parameters in proportion to the size; the others stay as they are.
        shrinking: parameters in inverse proportion to it.
        actuation: of the platforms that it can be in.
        by_run: how many numbers every run shows of its own; 0 where all runs show the same parameters.
    """

    components: tuple[str, ...]
    units: Mapping[str, str]
    apply: Callable[[Craft, str, Parameters], Craft]
    draw: Callable[[np.random.Generator], Parameters]
    growing: tuple[str, ...]
    shrinking: tuple[str, ...] = ()
    actuation: tuple[Literal["cmg", "applied_torque"], ...] = ("cmg",)
    by_run: int = 0


def scaled(kind: EffectKind, parameters: Parameters, factor: float) -> Parameters:
    """Return the parameters of an effect of another size."""
    return {name: value * _share(kind, name, factor) for name, value in parameters.items()}


def _share(kind: EffectKind, name: str, factor: float) -> float:
    if name in kind.shrinking:
        return 1.0 / factor if factor > 0.0 else np.inf
    return factor if name in kind.growing else 1.0


def unit_index(component: str) -> slice | int:
    """Return which entries of a per-unit array a component means."""
    return slice(None) if component == CLUSTER else int(component.removeprefix("cmg")) - 1


def vector(parameters: Parameters, stem: str) -> Array:
    """Return the three parameters `stem_x`, `stem_y`, `stem_z`."""
    return np.array([parameters[f"{stem}_{axis}"] for axis in AXES])


def named_vector(stem: str, values: Array) -> dict[str, float]:
    """Return a vector as three parameters."""
    return {f"{stem}_{axis}": float(value) for axis, value in zip(AXES, values, strict=True)}


def vector_units(stem: str, unit: str) -> dict[str, str]:
    """Return the unit of three parameters."""
    return dict.fromkeys((f"{stem}_{axis}" for axis in AXES), unit)


def names(stem: str) -> tuple[str, ...]:
    """Return the names of three parameters."""
    return tuple(f"{stem}_{axis}" for axis in AXES)


def direction(rng: np.random.Generator) -> Array:
    """Return a unit vector, all directions alike."""
    drawn = rng.standard_normal(3)
    return drawn / np.linalg.norm(drawn)


def sign(rng: np.random.Generator) -> float:
    """Return 1 or -1."""
    return float(rng.choice((-1.0, 1.0)))
