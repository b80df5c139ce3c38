"""The platform: what is believed of it, what differs in the flown one, how a flight starts, and the room around it."""

from __future__ import annotations

from math import hypot
from typing import Annotated, Literal, TypeAlias

from pydantic import AfterValidator, Field, Strict, field_validator

from testbed.quantities import (
    Dipole,
    Drag,
    Edge,
    Factor,
    Friction,
    FrictionTorque,
    Imbalance,
    Latency,
    Mass,
    Momentum,
    Offset,
    Room,
    SignedMomentum,
    SmallAngle,
)
from testbed.scenario.formulas import FormulaTorque
from testbed.scenario.section import Section
from testbed.scenario.values import (
    Angles,
    Axes,
    BodyRates,
    File,
    Inertia,
    Many,
    ManyOrOne,
    One,
    Pair,
    PerUnit,
    Places,
    Three,
    UnitQuaternion,
    Velocities,
)

_DirectionPart: TypeAlias = Annotated[float, Field(ge=-1, le=1)]
_UNIT = 1e-3
"""By which the length of a direction may differ from one: three decimals in a file pass."""


MOST_TORQUES = 20
"""Formulas of one platform: those of a diagnosis, of two parts along three axes each, and as many again."""


def _unit_vector(vector: tuple[float, float, float]) -> tuple[float, float, float]:
    length = hypot(*vector)
    if abs(length - 1.0) > _UNIT:
        raise ValueError(f"has the length {length:.4g} instead of 1")
    return vector


class Platform(Section):
    """The nominal platform: what the controller, the designer and the estimators believe.

    A number that is omitted keeps the value of the MJCF model.
    """

    model: File | None = None
    """MJCF file, relative to the scenario's folder; omitted: the shipped models/platform.xml."""
    inertia_kg_m2: Inertia | None = None
    """Inertia about the centre of mass, body axes: bus, gimbals and rotors, rotors locked, gimbal angles zero."""
    inertia: Literal["known"] | None = None
    """"known": a diagnosis takes the nominal inertia for true; omitted: it is estimated."""
    inertia_uncertainty: Annotated[float, Field(gt=0, le=10)] | None = None
    """Relative standard deviation of the nominal inertia in a diagnosis, about any axis; omitted: 0.3 under applied
    torque, which is rarely known better, 0.05 over windows of it, which show its products alone, and none at all where
    momentum is measured, which shows the inertia."""
    mass_kg: Mass | None = None
    """Mass of the whole platform."""
    edge_m: Edge | None = None
    """Edge of the cube-shaped bus."""
    axes: Annotated[Axes, Field(min_length=1, max_length=3)] | None = None
    """Body axes about which a rig can turn, such as `["z"]` on a bearing; omitted: all three, as in free flight. Of
    measured records, what the gyro shows about the others is not compared, and about an axis of a run whose channel
    is empty or constant neither; runs about different axes are estimated from together. What no run determines of the
    inertia is left out."""


class Thruster(Section):
    """A motor with a propeller, or a jet: what the platform is turned by where its single commands are recorded."""

    position_m: Places
    """Where it pushes, from the centre of mass, body axes."""
    direction: Annotated[Three[_DirectionPart], AfterValidator(_unit_vector)]
    """Unit vector of its thrust, body axes."""
    reaction_m: Annotated[float, Field(ge=-10, le=10)] = 0.0
    """Torque about that direction for each newton of thrust, as a propeller's drag makes; 0 of a jet."""


class Truth(Section):
    """What the flown platform has and the nominal one does not; a number that is omitted is as believed."""

    inertia_kg_m2: Inertia | None = None
    """True inertia of the whole platform, as platform.inertia_kg_m2."""
    mass_kg: Mass | None = None
    """True mass of the whole platform."""
    rotor_momentum_N_m_s: Annotated[Annotated[Momentum, One] | Annotated[PerUnit[Momentum], Many], ManyOrOne] | None = (
        None
    )
    """True rotor momentum of all units, or of each; servos clamp it at the limit; at rest: use cluster.failed; an empty
    list: as believed."""
    gimbal_axis_misalignment_rad: PerUnit[Pair[SmallAngle]] = ()
    """Turns of each unit out of its place: a pair for each, about its spin axis at gimbal angle zero, then about its
    transverse axis; a turn about the gimbal axis is an encoder.zero_rad."""
    wheel_spin_inertia_factor: PerUnit[Factor] = ()
    """True spin inertia of each reaction wheel over the believed one; an empty list: 1; a pure number."""
    wheel_axis_misalignment_rad: PerUnit[Pair[SmallAngle]] = ()
    """Turns of each wheel's axis, a pair for each: about two axes normal to it, the first of them also normal to body
    z; body x for a wheel along z."""
    wheel_viscous_friction_N_m_s_rad: PerUnit[Friction] = ()
    """True torque of each wheel's bearing over its speed; an empty list: as [[actuators]] has it."""
    wheel_coulomb_friction_N_m: PerUnit[FrictionTorque] = ()
    """True torque of each wheel's bearing against any motion; an empty list: as [[actuators]] has it."""
    wheel_torque_factor: PerUnit[Factor] = ()
    """True torque of each wheel's motor over what it is commanded, and over what its current shows; an empty list: 1; a
    pure number."""
    wheel_motor_lag_s: PerUnit[Latency] = ()
    """Time constant of a first-order lag by which each wheel's motor follows its command; an empty list: none."""
    wheel_imbalance_kg_m: PerUnit[Imbalance] = ()
    """Static imbalance of each wheel: its mass times the distance of its centre of mass from its axis; an empty list:
    none. A step of the integration may turn the fastest wheel by one radian at most."""
    center_of_mass_offset_m: Three[Offset] | None = None
    """True place of the centre of mass from the pivot of an air bearing, body axes."""
    drag_N_m_s_rad: Drag | None = None
    """True torque of air and bearing film over the body rate, on an air bearing."""
    magnetic_dipole_A_m2: Three[Dipole] | None = None
    """True magnetic dipole of a platform in orbit, body axes."""
    gravity_gradient_factor: Annotated[float, Field(ge=0, le=1e3)] | None = None
    """True torque of an orbit's gravity gradient over that of the true inertia at the believed mean motion; a pure
    number."""
    torque: Annotated[tuple[FormulaTorque, ...], Strict(False), Field(max_length=MOST_TORQUES)] = ()
    """Torques by formulas, which add up."""

    @field_validator("rotor_momentum_N_m_s")
    @classmethod
    def _stated(cls, momentum: float | tuple[float, ...] | None) -> float | tuple[float, ...] | None:
        return None if momentum == () else momentum


class Initial(Section):
    """How the flight starts; by default at rest, body axes along the inertial ones."""

    body_rate_rad_s: BodyRates = (0.0, 0.0, 0.0)
    """Body rate, body axes."""
    gimbal_angle_rad: Angles = ()
    """Gimbal angles, one for each unit; an empty list: all at zero."""
    wheel_momentum_N_m_s: PerUnit[SignedMomentum] = ()
    """Momentum of each reaction wheel from its speed relative to the body; an empty list: at rest."""
    attitude_quat_NB: UnitQuaternion = (1.0, 0.0, 0.0, 0.0)
    """Attitude, scalar first, from body to inertial components."""
    position_m: Places = (0.0, 0.0, 0.0)
    """Position of the centre of mass, inertial axes; the cabin's centre is the origin."""
    velocity_m_s: Velocities = (0.0, 0.0, 0.0)
    """Velocity of the centre of mass, inertial axes."""


class Cabin(Section):
    """A room around the platform; with this section contacts with its walls are on."""

    size_m: Three[Room]
    """Inner edges of the room along the inertial axes; the platform may touch the walls."""
