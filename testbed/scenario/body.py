"""The scenario of a platform that is measured but not flown: what its records are estimated from and compared with."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal, Self

import tomli_w
from pydantic import Field, PrivateAttr, Strict, ValidationInfo, field_validator

from testbed.files import TextFile
from testbed.scenario.actuators import (
    Actuator,
    ReactionWheels,
    control_moment_gyros,
    reaction_wheels,
    surplus_conflicts,
)
from testbed.scenario.cluster import NO_CLUSTER, Cluster, stated_conflicts
from testbed.scenario.diagnosis import Diagnosis
from testbed.scenario.environment import FREE, Environment, mass_conflicts
from testbed.scenario.estimation import Estimation
from testbed.scenario.gyros import Gyros, gyros_of
from testbed.scenario.platform import Platform, Thruster
from testbed.scenario.section import Section, refuse
from testbed.scenario.sensors import Gyro
from testbed.scenario.values import Seed
from testbed.signals import MOST_UNITS


class BodyScenario(Section):
    """A nominal platform and its gyro. With what a flight needs besides it can be flown: `Scenario`."""

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
    environment: Annotated[Environment, Field(validate_default=True)] = FREE
    """What the platform flies in; omitted: free."""
    thrusters: Annotated[tuple[Thruster, ...], Strict(False), Field(max_length=MOST_UNITS)] = ()
    """Motors with propellers or jets, in the order of the records' columns motor_thrust_1_N, _2_N, ...; with them a
    diagnosis names the one that is weak, late or tilted by its number."""
    gyro: Gyro
    """The rate gyro."""
    estimation: Estimation = Estimation()
    """How the inertia is estimated."""
    diagnosis: Diagnosis = Diagnosis()
    """How measured records are compared with the nominal platform."""
    cluster: Cluster = NO_CLUSTER
    """The control moment gyros; omitted: none, but [[actuators]]."""
    actuators: Annotated[tuple[Actuator, ...], Strict(False), Field(max_length=MOST_UNITS, validate_default=True)] = ()
    """Reaction wheels beside the cluster, or all actuators without it: each entry is one, or an array of them."""

    @property
    def gyros(self) -> Gyros:
        """All control moment gyros, of whichever form."""
        return gyros_of(self.cluster, control_moment_gyros(self.actuators))

    @property
    def wheels(self) -> tuple[ReactionWheels, ...]:
        """Entries of reaction wheels."""
        return reaction_wheels(self.actuators)

    @property
    def stores_momentum(self) -> bool:
        """Whether it has gyros or wheels; motors and jets turn one that has none."""
        return bool(self.gyros.units or self.wheels)

    @field_validator("cluster")
    @classmethod
    def _stated(cls, cluster: Cluster, info: ValidationInfo) -> Cluster:
        platform = info.data.get("platform")
        refuse(stated_conflicts(cluster, platform and platform.model), from_root=True)
        return cluster

    @field_validator("actuators")
    @classmethod
    def _not_too_many(cls, actuators: tuple[Actuator, ...], info: ValidationInfo) -> tuple[Actuator, ...]:
        refuse(surplus_conflicts(actuators, info.data.get("cluster")), from_root=True)
        return actuators

    @field_validator("environment")
    @classmethod
    def _has_mass(cls, environment: Environment, info: ValidationInfo) -> Environment:
        refuse(mass_conflicts(environment, info.data.get("platform")), from_root=True)
        return environment

    _source: tuple[TextFile, dict[str, Any]] | None = PrivateAttr(default=None)

    def __repr__(self) -> str:
        return str(self)

    def __str__(self) -> str:
        return f"Scenario {self.name}: {self.description}"

    def __eq__(self, other: object) -> bool:
        """Return whether both say the same, whichever files they were read from."""
        return type(self) is type(other) and self.__dict__ == other.__dict__

    def __hash__(self) -> int:
        """Return a hash of what the scenario says."""
        return hash((type(self), self.model_dump_json()))

    @property
    def file(self) -> TextFile:
        """The file that the scenario was read from; of one that was changed in Python, what its file would say."""
        if self._source is not None:
            file, read = self._source
            if all(self.__dict__[name] is value for name, value in read.items()):
                return file
        text = tomli_w.dumps(scenario_keys(self))
        return TextFile(path=Path(f"{self.name}.toml"), content=text.encode("utf-8"), text=text)

    def read_from(self, file: TextFile) -> Self:
        """Remember the file that the scenario was read from, and return the scenario."""
        self._source = file, dict(self.__dict__)
        return self


def scenario_keys(scenario: BodyScenario) -> dict[str, Any]:
    """Return what a scenario's file says."""
    return scenario.model_dump(mode="json", by_alias=True, exclude_unset=True, exclude_none=True)
