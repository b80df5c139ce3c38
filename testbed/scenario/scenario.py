"""A scenario: everything that decides a run, as plain data."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import chain
from typing import Annotated, Literal

from pydantic import Field, ValidationInfo, field_validator

from testbed.scenario.cluster import Cluster, Limits
from testbed.scenario.control import Controller
from testbed.scenario.dispersion import Dispersion
from testbed.scenario.estimation import Estimation
from testbed.scenario.maneuver import BasicManeuver, BodyRateDesign, BodyRatePoints, CsvManeuver, Maneuver
from testbed.scenario.platform import Cabin, Initial, Platform, Truth
from testbed.scenario.section import Conflict, Section, refuse
from testbed.scenario.sensors import Encoder, Gyro, Tachometer, TorqueSensor
from testbed.scenario.simulation import Simulation
from testbed.scenario.start import (
    dispersion_conflicts,
    first_angle_conflicts,
    locked_conflicts,
    momentum_conflicts,
    room_conflicts,
)
from testbed.scenario.timing import clock_conflicts, sample_conflicts, stiffness_conflicts
from testbed.scenario.values import Seed


class Scenario(Section):
    """Everything that decides a run, in the units of its keys."""

    # In this order each check finds the sections that it compares with already read.
    schema_version: Annotated[Literal[1], Field(alias="schema")]
    """Version of this file format."""
    name: Annotated[str, Field(min_length=1, pattern=r"^[A-Za-z0-9_-]+$")]
    """Short name, used for files: letters, digits, _ and -."""
    description: str
    """What the scenario is for, in a sentence."""
    seed: Seed
    """Seed of all noise; the same seed gives the same run."""
    platform: Platform = Platform()
    """The nominal platform."""
    cluster: Cluster
    """The control moment gyros."""
    limits: Limits
    """What the cluster may be asked for."""
    truth: Truth = Truth()
    """What the flown platform has and the nominal one does not."""
    initial: Initial = Initial()
    """How the flight starts."""
    cabin: Cabin | None = None
    """A room around the platform; omitted: none, and no contacts."""
    gyro: Gyro
    """The rate gyro."""
    encoder: Encoder = Encoder()
    """The gimbal encoders."""
    tachometer: Tachometer = Tachometer()
    """The rotor tachometers."""
    torque_sensor: TorqueSensor = TorqueSensor()
    """The gimbal motors' torque measurement."""
    dispersion: Dispersion | None = None
    """What each flight of a campaign draws anew."""
    maneuver: Maneuver
    """What is flown."""
    simulation: Simulation
    """The clock of the run."""
    controller: Controller
    """The rate tracker."""
    estimation: Estimation
    """How the inertia is estimated."""

    @field_validator("initial")
    @classmethod
    def _locked(cls, initial: Initial, info: ValidationInfo) -> Initial:
        refuse(locked_conflicts(initial, info.data.get("cluster")), from_root=True)
        return initial

    @field_validator("cabin")
    @classmethod
    def _room(cls, cabin: Cabin | None, info: ValidationInfo) -> Cabin | None:
        if cabin is not None:
            refuse(room_conflicts(cabin, info.data.get("platform"), info.data.get("initial")), from_root=True)
        return cabin

    @field_validator("maneuver")
    @classmethod
    def _first_angle(cls, maneuver: Maneuver, info: ValidationInfo) -> Maneuver:
        refuse(first_angle_conflicts(maneuver, info.data.get("initial")), from_root=True)
        return maneuver

    @field_validator("simulation")
    @classmethod
    def _clocks(cls, simulation: Simulation, info: ValidationInfo) -> Simulation:
        gyro = info.data.get("gyro")
        conflicts = (
            clock_conflicts(simulation, gyro),
            stiffness_conflicts(simulation, info.data.get("cluster")),
            sample_conflicts(simulation, gyro, info.data.get("maneuver")),
        )
        refuse(chain.from_iterable(conflicts), from_root=True)
        return simulation

    @field_validator("controller")
    @classmethod
    def _preference(cls, controller: Controller, info: ValidationInfo) -> Controller:
        refuse(_preference_conflicts(controller, info.data.get("maneuver")), from_root=True)
        return controller

    @field_validator("estimation")
    @classmethod
    def _momentum(cls, estimation: Estimation, info: ValidationInfo) -> Estimation:
        start = (info.data.get(section) for section in ("initial", "cluster", "platform", "truth"))
        drawn = dispersion_conflicts(estimation, info.data.get("dispersion"))
        refuse(chain(momentum_conflicts(estimation, *start), drawn), from_root=True)
        return estimation


def _preference_conflicts(controller: Controller, maneuver: Maneuver | None) -> Iterator[Conflict]:
    steering = controller.steering
    open_gimbals = isinstance(maneuver, BodyRateDesign | BodyRatePoints | BasicManeuver | CsvManeuver)
    if steering.preferred_gimbal_angle_rad == "maneuver" and open_gimbals:
        text = 'is "maneuver", but this maneuver leaves the gimbal angles open; use "zero" or a list of 6'
        yield Conflict(key="controller.steering.preferred_gimbal_angle_rad", text=text)
