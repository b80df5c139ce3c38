"""A platform that is measured but not flown: all that a diagnosis of records from elsewhere has to know of it."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field

from testbed.scenario.diagnosis import Diagnosis
from testbed.scenario.estimation import Estimation
from testbed.scenario.platform import Platform
from testbed.scenario.section import Section
from testbed.scenario.sensors import Gyro
from testbed.scenario.values import Seed


class BodyScenario(Section):
    """A platform as believed and its gyro. With a cluster of control moment gyros it can be flown: `Scenario`."""

    schema_version: Annotated[Literal[1], Field(alias="schema")]
    """Version of this file format."""
    name: Annotated[str, Field(min_length=1, max_length=100, pattern=r"^[A-Za-z0-9_-]+$")]
    """Short name, used for files: letters, digits, _ and -."""
    description: str
    """What the scenario is for, in a sentence."""
    seed: Seed
    """Seed of all noise; the same seed gives the same run."""
    platform: Platform = Platform()
    """The nominal platform."""
    gyro: Gyro
    """The rate gyro."""
    estimation: Estimation
    """How the inertia is estimated."""
    diagnosis: Diagnosis = Diagnosis()
    """How measured records are compared with the nominal platform."""


def scenario_keys(scenario: BodyScenario) -> dict[str, Any]:
    """Return what a scenario's file says."""
    return scenario.model_dump(mode="json", by_alias=True, exclude_unset=True, exclude_none=True)
