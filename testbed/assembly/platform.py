"""The nominal platform, the flown one, and how a flight starts."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import TypeVar

import numpy as np

from testbed.arrays import Matrix3, Series, Units, Vector3, Vectors3
from testbed.cmg.actuators import Actuators, envelope_share, held_capacity
from testbed.cmg.cluster import Cluster, platform_momentum
from testbed.cmg.wheels import Wheels, no_wheels, turned_wheel_axes, wheel_momentum
from testbed.dynamics.environment import Environment, Orbiting, OrbitTorque, Pivoted
from testbed.errors import InputError, UnphysicalPlatformError
from testbed.plant.build import build
from testbed.plant.geometry import cluster_of, composite_inertia, composite_mass, wheels_of
from testbed.plant.plant import Engine, Model, Plant
from testbed.plant.properties import AirBearing, GyroProperties, InitialState, PlatformProperties, WheelProperties
from testbed.scenario import environment as surroundings
from testbed.scenario.actuators import ReactionWheels, control_moment_gyros, wheel_count
from testbed.scenario.body import BodyScenario
from testbed.scenario.gyros import ControlMomentGyros
from testbed.scenario.platform import Truth
from testbed.scenario.scenario import Scenario
from testbed.scenario.values import per_unit

_Form = TypeVar("_Form", bound=BodyScenario)


@dataclass(frozen=True, kw_only=True)
class Body:
    """The nominal model of a platform that is measured.

    Attributes:
        cluster: its units; None of a platform without control moment gyros.
        inertia: J at zero gimbal angles, wheels locked, kg·m², body axes.
        wheels: its reaction wheels.
        environment: what acts on it; None of a platform that flies freely.
    """

    cluster: Cluster | None
    inertia: Matrix3
    wheels: Wheels = field(default_factory=no_wheels)
    environment: Environment | None = None

    @property
    def turned_inertia(self) -> Matrix3:
        """J about the point that the platform turns about: its centre of mass, or the pivot that it stands on."""
        return (
            self.inertia if not isinstance(self.environment, Pivoted) else self.inertia + self.environment.added_inertia
        )


@dataclass(frozen=True, kw_only=True)
class PlatformModel(Body):
    """A compiled platform and what is read off it.

    Attributes:
        model: compiled, without what is there to be looked at only.
        cluster: its units.
    """

    model: Model
    cluster: Cluster

    @property
    def units(self) -> int:
        """M, number of control moment gyros."""
        return len(self.cluster.rotor_momentum)

    @property
    def held_capacity(self) -> float:
        """The sum of what all rotors hold and all wheels can hold, N·m·s."""
        return held_capacity(self.cluster, self.wheels)

    def envelope_share(self, momentum_B: Vectors3, directions_B: Vectors3) -> Series:
        """Return the share of the momentum envelope that h uses; see `cmg.actuators.envelope_share`."""
        return envelope_share(self.cluster, self.wheels, momentum_B, directions_B)


def nominal_body(scenario: BodyScenario) -> Body:
    """Return the nominal model of a diagnosis: the nominal platform, or the stated inertia of one that cannot be flown.

    Raises:
        InputError: as `nominal_platform`; or no inertia is stated where there is no model to take it from.
    """
    if not isinstance(scenario, Scenario) and scenario.platform.inertia_kg_m2 is None:
        raise InputError(
            f"{scenario.name}: platform.inertia_kg_m2 is missing; add it: of a platform that is only measured there is "
            "no model to take it from"
        )
    if scenario.stores_momentum:
        return nominal_platform(scenario)
    environment = nominal_environment(scenario, scenario.platform.mass_kg or 0.0)  # on a bearing it is there
    return Body(cluster=None, inertia=np.array(scenario.platform.inertia_kg_m2), environment=environment)


def nominal_platform(scenario: BodyScenario) -> PlatformModel:
    """Return the nominal platform, one with gyros or wheels: the model of controller, designer and estimators.

    Raises:
        InputError: the MJCF cannot be used, or the numbers belong to no body.
    """
    try:
        return _compiled(scenario, nominal_properties(scenario), nominal_environment)
    except UnphysicalPlatformError as error:
        raise UnphysicalPlatformError(f"platform.{error.key}", error.text) from None


def true_platform(scenario: Scenario) -> PlatformModel:
    """Return what flies: the nominal platform with [truth] written over it.

    Raises:
        InputError: as `nominal_platform`.
    """
    try:
        return _compiled(scenario, true_properties(scenario), true_environment)
    except UnphysicalPlatformError as error:
        section = "platform" if getattr(scenario.truth, error.key) is None else "truth"
        raise UnphysicalPlatformError(f"{section}.{error.key}", error.text) from None


def shown_model(scenario: BodyScenario) -> Model:
    """Return the flown platform compiled with its visual geometry; of one that is only measured the nominal one."""
    properties = true_properties(scenario) if isinstance(scenario, Scenario) else nominal_properties(scenario)
    return build(properties, scenario.platform.model)


def true_plant(flown: Sequence[tuple[Scenario, PlatformModel]], threads: int = 1, engine: Engine = "mujoco") -> Plant:
    """Return flown platforms side by side in their initial states.

    Args:
        flown: each platform with its scenario; what all share is taken from the first.
        threads: that step the platforms.
        engine: what steps them.
    """
    gyros = flown[0][0].gyros
    return Plant(
        [platform.model for _, platform in flown],
        initial=[initial_state(scenario) for scenario, _ in flown],
        rotor_momentum=np.stack([_starting_momentum(scenario) for scenario, _ in flown]),
        rotor_momentum_limit=gyros.rotor_momentum_limit,
        rotors=gyros.rotors,
        wheel_momentum=np.stack([first_wheel_momentum(scenario) for scenario, _ in flown]),
        wheel_momentum_limit=each_wheel(flown[0][0], "momentum_limit_N_m_s"),
        orbit_torque=_orbit_torque([platform for _, platform in flown]),
        torques=[each.torque for each in flown[0][0].truth.torque],
        threads=threads,
        engine=engine,
    )


def nominal_properties(scenario: BodyScenario) -> PlatformProperties:
    """Return the scenario's nominal numbers; those it leaves out stay None and keep the MJCF's."""
    platform, cluster, gyros = scenario.platform, scenario.cluster, scenario.gyros
    flown = scenario if isinstance(scenario, Scenario) else None
    cabin = None if flown is None else flown.cabin
    return PlatformProperties(
        inertia=None if platform.inertia_kg_m2 is None else np.array(platform.inertia_kg_m2),
        mass=platform.mass_kg,
        edge=platform.edge_m,
        units=gyros.units,
        gyros=tuple(gyro for entry in control_moment_gyros(scenario.actuators) for gyro in _gyros(entry)),
        array=cluster.array,
        skew=None if cluster.skew_deg is None else math.radians(cluster.skew_deg),
        mounting_radius=cluster.mounting_radius_m,
        rotor_momentum=_spinning(gyros.rotor_momentum.copy(), scenario),
        rotor_momentum_limit=cluster.rotor_momentum_limit_N_m_s,
        rotor_spin_inertia=cluster.rotor_spin_inertia_kg_m2,
        rotor_transverse_inertia=cluster.rotor_transverse_inertia_kg_m2,
        rotor_mass=cluster.rotor_mass_kg,
        gimbal_inertia=cluster.gimbal_inertia_kg_m2,
        gimbal_mass=cluster.gimbal_mass_kg,
        gimbal_torque_limit=cluster.gimbal_torque_limit_N_m,
        gimbal_servo_bandwidth=gyros.servo_bandwidth,
        step=_ANY_STEP if flown is None else flown.simulation.step_s,
        cabin_size=None if cabin is None else np.array(cabin.size_m),
        wheels=tuple(wheel for array in scenario.wheels for wheel in _wheels(array)),
        air_bearing=_bearing(nominal_environment(scenario, _ANY_MASS)),
    )


def nominal_environment(scenario: BodyScenario, mass: float) -> Environment | None:
    """Return what acts on the nominal platform, of a mass in kg; None where nothing does."""
    match scenario.environment:
        case surroundings.AirBearing() as section:
            return Pivoted(
                mass=mass,
                gravity=section.gravity_m_s2,
                offset_B=np.array(section.center_of_mass_offset_m),
                drag=section.drag_N_m_s_rad,
            )
        case surroundings.Orbit() as section:
            return Orbiting(
                rate=section.rate,
                field_L=np.array(section.magnetic_field_T),
                torque_L=np.array(section.torque_N_m),
                dipole_B=np.array(section.magnetic_dipole_A_m2),
            )
        case _:
            return None


def true_environment(scenario: Scenario, mass: float) -> Environment | None:
    """Return what acts on the flown platform: what acts on the nominal one, with [truth] written over it."""
    nominal, truth = nominal_environment(scenario, mass), scenario.truth
    if isinstance(nominal, Pivoted):
        offset, drag = truth.center_of_mass_offset_m, truth.drag_N_m_s_rad
        return replace(
            nominal,
            offset_B=nominal.offset_B if offset is None else np.array(offset),
            drag=nominal.drag if drag is None else drag,
        )
    if isinstance(nominal, Orbiting):
        dipole, factor = truth.magnetic_dipole_A_m2, truth.gravity_gradient_factor
        return replace(
            nominal,
            dipole_B=nominal.dipole_B if dipole is None else np.array(dipole),
            gradient=nominal.gradient if factor is None else factor,
        )
    return None


def _bearing(environment: Environment | None) -> AirBearing | None:
    """Return what the platform stands on; None where it floats."""
    if not isinstance(environment, Pivoted):
        return None
    return AirBearing(center_of_mass_B=environment.offset_B, gravity=environment.gravity, drag=environment.drag)


_ANY_MASS = 1.0
"""kg, for what of an environment does not depend on it."""


_ANY_STEP = 0.001
"""s, of a model that nothing steps."""


def each_wheel(scenario: BodyScenario, key: str) -> Units:
    """Return what the entries of [[actuators]] state at a key for each wheel, shape (W,); 0 where it is omitted."""
    stated = [getattr(array, key) or 0.0 for array in scenario.wheels for _ in range(array.wheels)]
    return np.array(stated, dtype=np.float64)


def _gyros(entry: ControlMomentGyros) -> Iterator[GyroProperties]:
    """Yield the control moment gyros of an entry."""
    places = entry.places
    for gimbal_B, spin_B, position_B in zip(places.gimbal_axis_B, places.spin_axis_B, entry.positions_B, strict=True):
        yield GyroProperties(
            gimbal_axis_B=gimbal_B,
            spin_axis_B=spin_B,
            position_B=position_B,
            rotor_momentum_limit=entry.rotor_momentum_limit_N_m_s,
            rotor_spin_inertia=entry.rotor_spin_inertia_kg_m2,
            rotor_transverse_inertia=entry.transverse_inertia_kg_m2,
            rotor_mass=entry.rotor_mass_kg,
            gimbal_inertia=entry.gimbal_inertia_kg_m2,
            gimbal_mass=entry.gimbal_mass_kg,
            gimbal_torque_limit=entry.gimbal_torque_limit_N_m,
        )


def _wheels(array: ReactionWheels) -> Iterator[WheelProperties]:
    """Yield the wheels of an entry; a housing is part of the bus."""
    spin, transverse = array.spin_inertia_kg_m2, array.transverse_inertia_kg_m2
    for axis_B, position_B in zip(array.axes_B, array.positions_B, strict=True):
        yield WheelProperties(
            axis_B=axis_B,
            position_B=position_B,
            mass=array.mass_kg,
            spin_inertia=spin,
            transverse_inertia=0.5 * spin if transverse is None else transverse,
            torque_limit=array.torque_limit_N_m,
            momentum_limit=array.momentum_limit_N_m_s,
            viscous_friction=array.viscous_friction_N_m_s_rad,
            coulomb_friction=array.coulomb_friction_N_m,
            speed_loop_bandwidth=array.speed_loop_bandwidth_rad_s or 0.0,
        )


def true_properties(scenario: Scenario) -> PlatformProperties:
    """Return the numbers of the flown platform."""
    nominal, truth = nominal_properties(scenario), scenario.truth
    if truth.inertia_kg_m2 is not None:
        nominal = replace(nominal, inertia=np.array(truth.inertia_kg_m2))
    if truth.mass_kg is not None:
        nominal = replace(nominal, mass=truth.mass_kg)
    if truth.rotor_momentum_N_m_s is not None:
        momentum = np.broadcast_to(np.array(truth.rotor_momentum_N_m_s, dtype=np.float64), scenario.gyros.units)
        nominal = replace(nominal, rotor_momentum=_spinning(momentum.copy(), scenario))
    if truth.gimbal_axis_misalignment_rad:
        nominal = replace(nominal, misalignment=np.array(truth.gimbal_axis_misalignment_rad))
    bearing = _bearing(true_environment(scenario, _ANY_MASS))
    return replace(nominal, wheels=_true_wheels(nominal.wheels, truth), air_bearing=bearing)


def _true_wheels(wheels: tuple[WheelProperties, ...], truth: Truth) -> tuple[WheelProperties, ...]:
    if not wheels:
        return wheels
    for key, field_name in _TRUE_OF_WHEELS.items():
        values = per_unit(getattr(truth, key), len(wheels), None)
        wheels = tuple(
            wheel if value is None else replace(wheel, **{field_name: value})
            for wheel, value in zip(wheels, values, strict=True)
        )
    factors = per_unit(truth.wheel_spin_inertia_factor, len(wheels), 1.0)
    turns = np.array(per_unit(truth.wheel_axis_misalignment_rad, len(wheels), (0.0, 0.0)))
    if not (turns.any() or any(factor != 1.0 for factor in factors)):
        return wheels
    axes_B = turned_wheel_axes(np.stack([wheel.axis_B for wheel in wheels]), turns)
    return tuple(
        replace(
            wheel,
            axis_B=axis_B,
            spin_inertia=factor * wheel.spin_inertia,
            transverse_inertia=factor * wheel.transverse_inertia,
        )
        for wheel, axis_B, factor in zip(wheels, axes_B, factors, strict=True)
    )


_TRUE_OF_WHEELS = {
    "wheel_viscous_friction_N_m_s_rad": "viscous_friction",
    "wheel_coulomb_friction_N_m": "coulomb_friction",
    "wheel_torque_factor": "torque_factor",
    "wheel_motor_lag_s": "motor_lag",
    "wheel_imbalance_kg_m": "imbalance",
}
"""Keys of [truth] that say what a wheel has, and the properties that they stand for."""


def initial_state(scenario: Scenario) -> InitialState:
    """Return where the flight starts."""
    start = scenario.initial
    return InitialState(
        body_rate=np.array(start.body_rate_rad_s),
        attitude=np.array(start.attitude_quat_NB),
        position=np.array(start.position_m),
        velocity=np.array(start.velocity_m_s),
        gimbal_angle=first_gimbal_angle(scenario),
    )


def first_gimbal_angle(scenario: Scenario) -> Units:
    """Return the gimbal angles at the start of the flight, shape (M,), rad."""
    return np.array(per_unit(scenario.initial.gimbal_angle_rad, scenario.gyros.units, 0.0))


def initial_momentum(scenario: Scenario, platform: PlatformModel) -> Vector3:
    """Return the total angular momentum that a platform has in the scenario's initial state, N·m·s, body axes."""
    start = initial_state(scenario)
    at_rest = np.zeros_like(start.gimbal_angle)
    carried = platform_momentum(platform.cluster, platform.turned_inertia, start.body_rate, start.gimbal_angle, at_rest)
    return carried + wheel_momentum(platform.wheels, first_wheel_momentum(scenario))


def platform_actuators(scenario: Scenario, platform: PlatformModel) -> Actuators:
    """Return all gyros and wheels of a platform, with the rate limit that the scenario gives gimbals."""
    return Actuators(
        cluster=platform.cluster, wheels=platform.wheels, gimbal_rate_limit=scenario.gyros.gimbal_rate_limit
    )


def first_wheel_momentum(scenario: Scenario) -> Units:
    """Jw·Ω of the wheels when the flight starts, by the believed spin inertia, shape (W,), N·m·s."""
    return np.array(per_unit(scenario.initial.wheel_momentum_N_m_s, wheel_count(scenario.actuators), 0.0))


def _starting_momentum(scenario: Scenario) -> Units:
    """Js·Ω of the flown rotors when the flight starts; unlike their servos' targets it may exceed the limit."""
    momentum = true_properties(scenario).rotor_momentum
    assert momentum is not None
    return momentum


def _spinning(momentum: Units, scenario: BodyScenario) -> Units:
    """Stop the rotors of failed units: without momentum the steering law asks nothing of them."""
    momentum[[unit - 1 for unit in scenario.gyros.failed]] = 0.0
    return momentum


def _compiled(
    scenario: _Form,
    properties: PlatformProperties,
    environment_of: Callable[[_Form, float], Environment | None],
) -> PlatformModel:
    model = build(properties, scenario.platform.model, visuals=False)
    return PlatformModel(
        model=model,
        cluster=cluster_of(model),
        inertia=composite_inertia(model),
        wheels=wheels_of(model, each_wheel(scenario, "momentum_limit_N_m_s")),
        environment=environment_of(scenario, composite_mass(model)),
    )


def _orbit_torque(platforms: Sequence[PlatformModel]) -> OrbitTorque | None:
    """Return what an orbit does to flown platforms, which all are on the same; None where they are on none."""
    orbit = platforms[0].environment
    if not isinstance(orbit, Orbiting):
        return None
    return OrbitTorque(orbit=orbit, inertia=np.stack([platform.inertia for platform in platforms]))
