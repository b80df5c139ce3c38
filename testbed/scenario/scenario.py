"""A scenario: everything that decides a run, as plain data."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Literal

from pydantic import Field, ValidationInfo, field_validator

from testbed.scenario.clocks import duration_conflicts, order_conflicts, rate_conflicts, step_conflicts
from testbed.scenario.cluster import Cluster, Limits
from testbed.scenario.control import Controller
from testbed.scenario.estimation import Estimation
from testbed.scenario.maneuver import BasicManeuver, BodyRateDesign, BodyRatePoints, CsvManeuver, Maneuver
from testbed.scenario.platform import Cabin, Initial, Platform, Truth
from testbed.scenario.section import Conflict, Section, refuse
from testbed.scenario.sensors import Encoder, Gyro, Tachometer, TorqueSensor
from testbed.scenario.simulation import Simulation
from testbed.scenario.values import Seed

_STIFFEST_SERVO = 2.8
"""Largest servo bandwidth times step that a fourth-order Runge-Kutta step bears (its stability limit is 2.785)."""


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
        refuse(_locked_conflicts(initial, info.data.get("cluster")), from_root=True)
        return initial

    @field_validator("cabin")
    @classmethod
    def _room(cls, cabin: Cabin | None, info: ValidationInfo) -> Cabin | None:
        if cabin is not None:
            refuse(_room_conflicts(cabin, info.data.get("platform"), info.data.get("initial")), from_root=True)
        return cabin

    @field_validator("simulation")
    @classmethod
    def _clocks(cls, simulation: Simulation, info: ValidationInfo) -> Simulation:
        refuse(_clock_conflicts(simulation, info.data.get("gyro")), from_root=True)
        refuse(_stiffness_conflicts(simulation, info.data.get("cluster")), from_root=True)
        return simulation

    @field_validator("controller")
    @classmethod
    def _preference(cls, controller: Controller, info: ValidationInfo) -> Controller:
        refuse(_preference_conflicts(controller, info.data.get("maneuver")), from_root=True)
        return controller


def _locked_conflicts(initial: Initial, cluster: Cluster | None) -> Iterator[Conflict]:
    for unit in cluster.failed if cluster else ():
        angle = initial.gimbal_angle_rad[unit - 1]
        if angle != 0.0:
            text = f"has {angle} for unit {unit}, which has failed and is locked at zero; write 0 there"
            yield Conflict(key="initial.gimbal_angle_rad", text=text)


def _room_conflicts(cabin: Cabin, platform: Platform | None, initial: Initial | None) -> Iterator[Conflict]:
    edge = (platform and platform.edge_m) or 0.0
    position = initial.position_m if initial else (0.0, 0.0, 0.0)
    for axis, size, place in zip("xyz", cabin.size_m, position, strict=True):
        if abs(place) + edge / 2.0 >= size / 2.0:
            text = f"{size} m along {axis} leaves no room for a platform of {edge} m at {place} m; enlarge it"
            yield Conflict(key="cabin.size_m", text=text)


def _clock_conflicts(simulation: Simulation, gyro: Gyro | None) -> Iterator[Conflict]:
    rates = {
        "simulation.control_rate_hz": simulation.control_rate_hz,
        "simulation.telemetry_rate_hz": simulation.telemetry_rate_hz,
    }
    if gyro is not None:
        rates["gyro.sample_rate_hz"] = gyro.sample_rate_hz
    yield from step_conflicts(simulation.step_s, rates)
    yield from order_conflicts(rates, "simulation.control_rate_hz")
    yield from rate_conflicts(rates)
    if simulation.duration_s is not None:
        yield from duration_conflicts(simulation.duration_s, simulation.control_rate_hz)


def _stiffness_conflicts(simulation: Simulation, cluster: Cluster | None) -> Iterator[Conflict]:
    if cluster is None:
        return
    longest = _STIFFEST_SERVO / cluster.gimbal_servo_bandwidth_rad_s
    if simulation.step_s >= longest:
        text = (
            f"{simulation.step_s} s is too long for the gimbal servo of {cluster.gimbal_servo_bandwidth_rad_s} rad/s; "
            f"stay below {longest:.3g} s"
        )
        yield Conflict(key="simulation.step_s", text=text)


def _preference_conflicts(controller: Controller, maneuver: Maneuver | None) -> Iterator[Conflict]:
    steering = controller.steering
    open_gimbals = isinstance(maneuver, BodyRateDesign | BodyRatePoints | BasicManeuver | CsvManeuver)
    if steering.preferred_gimbal_angle_rad == "maneuver" and open_gimbals:
        text = 'is "maneuver", but this maneuver leaves the gimbal angles open; use "zero" or a list of 6'
        yield Conflict(key="controller.steering.preferred_gimbal_angle_rad", text=text)
