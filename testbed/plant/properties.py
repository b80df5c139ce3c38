"""The physical numbers that a scenario may write over an MJCF's own."""

from __future__ import annotations

import math
from dataclasses import dataclass

from testbed.arrays import Array, Matrix3, Quaternion, Units, Vector3
from testbed.cmg.arrays import ArrayKind


@dataclass(frozen=True, kw_only=True)
class WheelProperties:
    """A reaction wheel on the bus.

    Attributes:
        axis_B: a, shape (3,), unit vector, body axes.
        position_B: of its centre of mass from the bus's origin, shape (3,), m, body axes.
        mass: of the rotor, kg; the housing belongs to the bus.
        spin_inertia: Jw about the axis, kg·m².
        transverse_inertia: about any axis normal to it, kg·m².
        torque_limit: of the motor, N·m.
        momentum_limit: largest |Jw Ω| to which the drive pushes it, N·m·s.
        viscous_friction: of its bearing, N·m·s/rad.
        coulomb_friction: of its bearing, N·m.
        speed_loop_bandwidth: of the loop on its speed inside the drive, rad/s; 0 for none.
        torque_factor: torque of the motor over what its drive takes it to give.
        motor_lag: time constant by which the motor's torque follows its drive, s.
        imbalance: mass of the rotor times the distance of its centre of mass from the axis, kg·m.
    """

    axis_B: Vector3
    position_B: Vector3
    mass: float
    spin_inertia: float
    transverse_inertia: float
    torque_limit: float
    momentum_limit: float = math.inf
    viscous_friction: float = 0.0
    coulomb_friction: float = 0.0
    speed_loop_bandwidth: float = 0.0
    torque_factor: float = 1.0
    motor_lag: float = 0.0
    imbalance: float = 0.0


@dataclass(frozen=True, kw_only=True)
class GyroProperties:
    """A control moment gyro on the bus, with axes of its own.

    Attributes:
        gimbal_axis_B: g, shape (3,), unit vector, body axes.
        spin_axis_B: s at gimbal angle zero, shape (3,), unit vector, body axes.
        position_B: of the centre of mass of gimbal and rotor from the bus's origin, shape (3,), m, body axes.
        rotor_momentum_limit: what the rotor's servo may carry, N·m·s.
        rotor_spin_inertia: Js, kg·m².
        rotor_transverse_inertia: Jt, kg·m².
        rotor_mass: kg.
        gimbal_inertia: Jg about each axis of the gimbal body, rotor not included, kg·m².
        gimbal_mass: kg.
        gimbal_torque_limit: of the gimbal motor, N·m.
    """

    gimbal_axis_B: Vector3
    spin_axis_B: Vector3
    position_B: Vector3
    rotor_momentum_limit: float
    rotor_spin_inertia: float
    rotor_transverse_inertia: float
    rotor_mass: float
    gimbal_inertia: float
    gimbal_mass: float
    gimbal_torque_limit: float


@dataclass(frozen=True, kw_only=True)
class AirBearing:
    """A pivot that the platform stands on, free to turn, and what acts on it there.

    Attributes:
        center_of_mass_B: c, of the whole platform from the pivot, shape (3,), m, body axes.
        gravity: m/s², along -z of N.
        drag: of the air and the bearing, c_d in the torque -c_d ω about every axis, N·m·s/rad.
    """

    center_of_mass_B: Vector3
    gravity: float
    drag: float = 0.0


@dataclass(frozen=True, kw_only=True)
class PlatformProperties:
    """A platform's numbers; a field that is None keeps the MJCF's own.

    Attributes:
        inertia: J of the whole platform about its centre of mass, rotors locked, gimbals at zero, kg·m², body axes.
        mass: of the whole platform, kg.
        edge: of the bus cube, m.
        units: how many CMG units.
        gyros: each of them, where they are not alike; what is said of all below up to gimbal_torque_limit is then
            without effect, but for misalignment and rotor_momentum.
        array: how they stand.
        skew: angle between body z and every gimbal axis, rad.
        mounting_radius: of a pyramid every unit's distance from body z, of rows that of the outermost ones, m.
        misalignment: turns of each unit out of its place, shape (M, 2), rad, as in `testbed.cmg.misalignment`.
        rotor_momentum: Js·Ω of each unit when the flight starts, shape (M,), N·m·s; 0 for a failed unit.
        rotor_momentum_limit: what a rotor's servo may carry, N·m·s.
        rotor_spin_inertia: Js, kg·m².
        rotor_transverse_inertia: Jt, kg·m².
        rotor_mass: kg.
        gimbal_inertia: Jg about each axis of the gimbal body, rotor not included, kg·m².
        gimbal_mass: kg.
        gimbal_torque_limit: of each gimbal motor, N·m.
        gimbal_servo_bandwidth: of the tachometer loop inside each gimbal motor, rad/s.
        step: of the integrator, s.
        cabin_size: inner edges of a room with walls, m; None for no room, and no contacts.
        wheels: reaction wheels beside the CMG units.
        air_bearing: what the platform stands on; None for a platform that floats. The inertia above is about the centre
            of mass all the same; about the pivot it is J + m (c·c 1 - c cᵀ).
    """

    inertia: Matrix3 | None = None
    mass: float | None = None
    edge: float | None = None
    units: int = 6
    gyros: tuple[GyroProperties, ...] = ()
    array: ArrayKind = "pyramid"
    skew: float | None = None
    mounting_radius: float | None = None
    misalignment: Array | None = None
    rotor_momentum: Units | None = None
    rotor_momentum_limit: float | None = None
    rotor_spin_inertia: float | None = None
    rotor_transverse_inertia: float | None = None
    rotor_mass: float | None = None
    gimbal_inertia: float | None = None
    gimbal_mass: float | None = None
    gimbal_torque_limit: float | None = None
    gimbal_servo_bandwidth: float | None = None
    step: float | None = None
    cabin_size: Vector3 | None = None
    wheels: tuple[WheelProperties, ...] = ()
    air_bearing: AirBearing | None = None


@dataclass(frozen=True, kw_only=True)
class InitialState:
    """Where a flight starts.

    Attributes:
        body_rate: ω, shape (3,), rad/s, body axes.
        attitude: quat_NB, shape (4,).
        position: of the centre of mass in N, shape (3,), m; without effect on an air bearing.
        velocity: of the centre of mass in N, shape (3,), m/s; without effect on an air bearing.
        gimbal_angle: shape (M,), rad.
    """

    body_rate: Vector3
    attitude: Quaternion
    position: Vector3
    velocity: Vector3
    gimbal_angle: Units
