"""diagnosis.json and answer.json as far as a score card needs them; what else they hold is not looked at."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal

from pydantic import BaseModel, ConfigDict, Field, model_validator


class _Part(BaseModel):
    model_config = ConfigDict(frozen=True, extra="ignore")


class Number(_Part):
    """A parameter; what has no value, or no standard error, is None."""

    value: float | None
    std: float | None = None


_PLACES = {"gyro_cross_axis": "gyro"}
"""Kinds of an effect that sit at the same component: axes turned together, or oblique, are both the gyro's."""


def place_key(key: str) -> str:
    """Return the name of an effect at a component, without its variant, e.g. `gyro_misalignment:gyro`."""
    effect, colon, component = key.partition(":")
    return f"{effect}{colon}{_PLACES.get(component, component)}"


class Named(_Part):
    """An effect at a component."""

    effect: str
    component: str

    @property
    def kind(self) -> str:
        """Its name as it is written, e.g. `gyro_misalignment:gyro_cross_axis`."""
        return f"{self.effect}:{self.component}"

    @property
    def key(self) -> str:
        """Its name by effect and component, e.g. `rotor_speed:cmg3`."""
        return place_key(self.kind)


class Hidden(Named):
    """An effect that is in the data."""

    parameters: Mapping[str, Number] = Field(default_factory=dict)


class Step(Hidden):
    """An effect that a diagnosis added to the model."""

    probability: float | None = None
    j_theta_kg_m2: tuple[float | None, ...] = ()
    j_std_kg_m2: tuple[float | None, ...] = ()
    indistinguishable_from: tuple[Named, ...] = ()

    @property
    def alike(self) -> tuple[Named, ...]:
        """Itself and its equivalence class."""
        return (self, *self.indistinguishable_from)


class Theta(_Part):
    """Inertia parameters with their standard errors, each of shape (6,), kg·m²."""

    theta_kg_m2: tuple[float | None, ...]
    std_kg_m2: tuple[float | None, ...]


class Inertia(_Part):
    """Inertia without and with the effects."""

    before: Theta | None = None
    after: Theta | None = None


class Gap(_Part):
    """Of the held-out runs."""

    heldout_after: float | None = None


class DiagnosisFile(_Part):
    """diagnosis.json; one that is not complete has no verdict."""

    complete: bool
    verdict: Literal["none", "named", "ambiguous", "unexplained"] | None
    steps: tuple[Step, ...]
    gap: Gap = Gap()
    probabilities: Mapping[str, float | None] = Field(default_factory=dict)
    inertia: Inertia = Inertia()

    @model_validator(mode="after")
    def _has_its_verdict(self) -> DiagnosisFile:
        if self.complete and self.verdict is None:
            raise ValueError("the diagnosis is complete and has no verdict")
        return self


class AnswerFile(_Part):
    """answer.json."""

    stratum: str
    effects: tuple[Hidden, ...]
    notes: Mapping[str, float | str] = Field(default_factory=dict)
    true_theta_kg_m2: tuple[float, ...]
    initial_rates_rad_s: tuple[tuple[float, float, float], ...] = ()
