"""A scenario: everything that decides a run, as plain data."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import chain

from pydantic import ValidationInfo, field_validator

from testbed.scenario.actuators import (
    Actuator,
    ReactionWheels,
    control_moment_gyros,
    reaction_wheels,
    torque_conflicts,
)
from testbed.scenario.body import BodyScenario
from testbed.scenario.cluster import Limits
from testbed.scenario.control import Controller
from testbed.scenario.dispersion import Dispersion
from testbed.scenario.environment import conservation_conflicts, start_conflicts, truth_conflicts
from testbed.scenario.formulas import formula_conflicts
from testbed.scenario.gyros import Gyros, gyros_of
from testbed.scenario.maneuver import (
    ActuatorDesign,
    ActuatorPoints,
    BasicManeuver,
    BodyRateDesign,
    BodyRatePoints,
    CsvManeuver,
    Maneuver,
)
from testbed.scenario.platform import Cabin, Initial, Truth
from testbed.scenario.section import Conflict, Section, refuse
from testbed.scenario.sensors import Encoder, Tachometer, TorqueSensor, WheelTachometer, WheelTorqueSensor
from testbed.scenario.simulation import Simulation
from testbed.scenario.start import (
    dispersion_conflicts,
    first_point_conflicts,
    locked_conflicts,
    momentum_conflicts,
    room_conflicts,
    wheel_start_conflicts,
)
from testbed.scenario.timing import (
    clock_conflicts,
    imbalance_conflicts,
    memory_conflicts,
    sample_conflicts,
    size_conflicts,
    stiffness_conflicts,
)
from testbed.scenario.unit_counts import count_conflicts


class Scenario(BodyScenario):
    """Everything that decides a run, in the units of its keys."""

    # In this order each check finds the sections that it compares with already read.
    limits: Limits
    """What the cluster may be asked for."""
    truth: Truth = Truth()
    """What the flown platform has and the nominal one does not."""
    initial: Initial = Initial()
    """How the flight starts."""
    cabin: Cabin | None = None
    """A room around the platform; omitted: none, and no contacts."""
    encoder: Encoder = Encoder()
    """The gimbal encoders."""
    tachometer: Tachometer = Tachometer()
    """The rotor tachometers."""
    torque_sensor: TorqueSensor = TorqueSensor()
    """The gimbal motors' torque measurement."""
    wheel_tachometer: WheelTachometer = WheelTachometer()
    """The reaction wheels' tachometers."""
    wheel_torque_sensor: WheelTorqueSensor = WheelTorqueSensor()
    """The wheel motors' torque measurement."""
    dispersion: Dispersion | None = None
    """What each flight of a campaign draws anew."""
    maneuver: Maneuver
    """What is flown."""
    simulation: Simulation
    """The clock of the run."""
    controller: Controller
    """The rate tracker."""

    @field_validator("actuators")
    @classmethod
    def _can_turn(cls, actuators: tuple[Actuator, ...], info: ValidationInfo) -> tuple[Actuator, ...]:
        refuse(torque_conflicts(actuators, info.data.get("cluster")), from_root=True)
        return actuators

    @field_validator("truth", "initial", "encoder", "tachometer", "wheel_tachometer", "maneuver", "controller")
    @classmethod
    def _one_for_each_unit(cls, section: Section, info: ValidationInfo) -> Section:
        refuse(count_conflicts(str(info.field_name), section, _gyros(info), _wheels(info)), from_root=True)
        return section

    @field_validator("truth")
    @classmethod
    def _of_environment(cls, truth: Truth, info: ValidationInfo) -> Truth:
        gyros = _gyros(info)
        refuse(truth_conflicts(info.data.get("environment"), truth), from_root=True)
        refuse(formula_conflicts(truth.torque, None if gyros is None else gyros.units), from_root=True)
        return truth

    @field_validator("initial")
    @classmethod
    def _locked(cls, initial: Initial, info: ValidationInfo) -> Initial:
        conflicts = (
            locked_conflicts(initial, _gyros(info)),
            wheel_start_conflicts(initial, _wheels(info)),
            start_conflicts(info.data.get("environment"), initial),
        )
        refuse(chain.from_iterable(conflicts), from_root=True)
        return initial

    @field_validator("cabin")
    @classmethod
    def _room(cls, cabin: Cabin | None, info: ValidationInfo) -> Cabin | None:
        if cabin is not None:
            refuse(room_conflicts(cabin, info.data.get("platform"), info.data.get("initial")), from_root=True)
        return cabin

    @field_validator("maneuver")
    @classmethod
    def _first_point(cls, maneuver: Maneuver, info: ValidationInfo) -> Maneuver:
        conflicts = first_point_conflicts(maneuver, info.data.get("initial"), _gyros(info), _wheels(info))
        refuse(conflicts, from_root=True)
        return maneuver

    @field_validator("simulation")
    @classmethod
    def _clocks(cls, simulation: Simulation, info: ValidationInfo) -> Simulation:
        gyro = info.data.get("gyro")
        conflicts = (
            clock_conflicts(simulation, gyro),
            stiffness_conflicts(simulation, _gyros(info), _wheels(info)),
            imbalance_conflicts(simulation, info.data.get("truth"), _wheels(info)),
            memory_conflicts(simulation, info.data.get("truth")),
            sample_conflicts(simulation, gyro, info.data.get("maneuver")),
            size_conflicts(simulation, info.data.get("maneuver")),
        )
        refuse(chain.from_iterable(conflicts), from_root=True)
        return simulation

    @field_validator("controller")
    @classmethod
    def _preference_and_momentum(cls, controller: Controller, info: ValidationInfo) -> Controller:
        """Check on the last section, with all others read, what the start has to agree with too."""
        estimation = info.data.get("estimation")
        initial, platform, truth = (info.data.get(section) for section in ("initial", "platform", "truth"))
        conflicts = (
            _preference_conflicts(controller, info.data.get("maneuver")),
            momentum_conflicts(estimation, initial, _gyros(info), _wheels(info), platform, truth),
            dispersion_conflicts(estimation, info.data.get("dispersion")),
            conservation_conflicts(info.data.get("environment"), info.data.get("maneuver"), estimation),
        )
        refuse(chain.from_iterable(conflicts), from_root=True)
        return controller


def _gyros(info: ValidationInfo) -> Gyros | None:
    """Return the gyros of what is read so far; None where they are wrong themselves."""
    cluster, actuators = info.data.get("cluster"), info.data.get("actuators")
    if cluster is None or (actuators is None and not cluster.units):
        return None
    return gyros_of(cluster, control_moment_gyros(actuators or ()))


def _wheels(info: ValidationInfo) -> tuple[ReactionWheels, ...] | None:
    actuators = info.data.get("actuators")
    return None if actuators is None else reaction_wheels(actuators)


NEEDED_TO_FLY = {
    key for key, field in Scenario.model_fields.items() if field.is_required()
} - BodyScenario.model_fields.keys()
"""Sections of a flight, which a platform that is only measured has none of, and one that is flown all."""
ACTUATORS = ("cluster", "actuators")
"""Sections of its actuators; one of them is needed to fly."""


def _preference_conflicts(controller: Controller, maneuver: Maneuver | None) -> Iterator[Conflict]:
    steering = controller.steering
    open_gimbals = isinstance(maneuver, BodyRateDesign | BodyRatePoints | BasicManeuver | CsvManeuver)
    if steering.preferred_gimbal_angle_rad == "maneuver" and open_gimbals:
        text = 'is "maneuver", but this maneuver leaves the gimbal angles open; use "zero" or a list'
        yield Conflict(key="controller.steering.preferred_gimbal_angle_rad", text=text)
    open_wheels = maneuver is not None and not isinstance(maneuver, ActuatorDesign | ActuatorPoints | CsvManeuver)
    if controller.wheels.null_motion == "maneuver" and open_wheels:
        text = 'is "maneuver", but this maneuver leaves the wheels open; use "none", "minimax" or "preferred"'
        yield Conflict(key="controller.wheels.null_motion", text=text)
