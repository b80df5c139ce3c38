"""From an MJCF file and a scenario's numbers to a compiled model."""

from __future__ import annotations

import math
from itertools import product
from pathlib import Path

import mujoco
import numpy as np

from testbed.arrays import Matrix3, Vector3
from testbed.cmg.arrays import BOX_SKEW, azimuths, unit_places
from testbed.errors import InputError, UnphysicalPlatformError
from testbed.plant.bounds import require_bounded
from testbed.plant.geometry import bus_inertia, composite_inertia, composite_mass, first_moment, unit_names
from testbed.plant.misalignment import turn_units
from testbed.plant.parts import require_parts
from testbed.plant.properties import AirBearing, GyroProperties, PlatformProperties, WheelProperties

_PACKAGE = Path(__file__).resolve().parents[1]
_WALL_THICKNESS = 0.05
_TRIANGLE_SLACK = 1e-12
_SHIPPED_UNITS = 6

ROTOR_SERVO_BANDWIDTH = 300.0
"""rad/s. Stiff enough that a maneuver moves a rotor by 1.1e-5 of its speed; RK4 bears it up to a step of 9 ms."""


def shipped_model() -> Path:
    """Return the path of the shipped platform.xml, in a checkout or in an installed package."""
    candidates = (_PACKAGE.parent / "models" / "platform.xml", _PACKAGE / "models" / "platform.xml")
    return next(path for path in candidates if path.is_file())


def build(properties: PlatformProperties, path: Path | None = None, *, visuals: bool = True) -> mujoco.MjModel:
    """Compile a platform with a scenario's numbers written over the MJCF's.

    Args:
        properties: the numbers; None fields keep the MJCF's.
        path: the MJCF; the shipped platform where absent.
        visuals: whether parts are kept that are there to be looked at only; without them a step costs 0.85 of the
            time, and every bit of the motion is the same.

    Raises:
        InputError: the MJCF cannot be read, lacks a named part, or the numbers leave the bus no positive inertia.
    """
    source = shipped_model() if path is None else path
    spec = specification(properties, source)
    spec.compiler.discardvisual = not visuals
    return _compile(spec, source)


def specification(properties: PlatformProperties, path: Path) -> mujoco.MjSpec:
    """Return the edited, not yet compiled MjSpec; as `build`, for those who go on editing it."""
    spec = _read(path)
    if path == shipped_model():
        _fit_units(spec, properties.units)
    require_parts(spec, path, properties.units)
    _apply_solver(spec, properties)
    _apply_units(spec, properties)
    if properties.misalignment is not None:
        turn_units(spec, properties.misalignment)
    for number, wheel in enumerate(properties.wheels, start=1):
        _add_wheel(spec, f"wheel{number}", wheel)
    _apply_bus(spec, properties, path)
    if properties.air_bearing is not None:
        _stand_on_bearing(spec, properties.air_bearing)
    if properties.cabin_size is not None:
        _add_cabin(spec, properties.cabin_size)
    return spec


def _read(path: Path) -> mujoco.MjSpec:
    if not path.is_file():
        raise InputError(f"{path}: no such MJCF file; check the scenario's platform.model")
    require_bounded(path)
    try:
        return mujoco.MjSpec.from_file(str(path))
    except ValueError as error:
        raise InputError(f"{path}: not a readable MJCF: {error}") from error


def _compile(spec: mujoco.MjSpec, path: Path) -> mujoco.MjModel:
    try:
        return spec.compile()
    except ValueError as error:
        raise InputError(f"{path}: MuJoCo cannot compile the platform: {error}") from error


def _apply_solver(spec: mujoco.MjSpec, properties: PlatformProperties) -> None:
    """Write what momentum and honesty need over any model's own options."""
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_RK4  # the others lose 12 to 34 % of the momentum in 5 s
    spec.option.disableflags |= mujoco.mjtDisableBit.mjDSBL_AUTORESET.value  # a diverged state must be seen
    if properties.step is not None:
        spec.option.timestep = properties.step


def _fit_units(spec: mujoco.MjSpec, units: int) -> None:
    """Take units off the shipped platform, or attach more, until it has as many as are wanted."""
    for number in range(units + 1, _SHIPPED_UNITS + 1):
        spec.delete(spec.body(f"cmg{number}_gimbal"))
    for number in range(_SHIPPED_UNITS + 1, units + 1):
        mount = spec.body("bus").add_frame(name=f"cmg{number}_mount")
        spec.attach(_read(shipped_model().with_name("cmg.xml")), prefix=f"cmg{number}_", frame=mount)


def _apply_units(spec: mujoco.MjSpec, properties: PlatformProperties) -> None:
    frames = {frame.name: frame for frame in spec.frames}
    for index, mount in enumerate(unit_names("mount", properties.units)):
        unit = mount.removesuffix("_mount")
        if properties.gyros:
            _place_gyro(frames[mount], properties.gyros[index])
        else:
            _apply_mount(frames[mount], index, properties)
        numbers = properties.gyros[index] if properties.gyros else properties
        _apply_masses(spec.body(f"{unit}_gimbal"), spec.body(f"{unit}_rotor"), numbers)
        if numbers.gimbal_torque_limit is not None:
            spec.joint(f"{unit}_gimbal").actfrcrange = [-numbers.gimbal_torque_limit, numbers.gimbal_torque_limit]
        if properties.gimbal_servo_bandwidth is not None:
            _apply_gimbal_servo(spec, unit, properties.gimbal_servo_bandwidth)
        if properties.rotor_momentum is not None:
            _apply_rotor_motor(spec, unit, properties.rotor_momentum[index], numbers.rotor_momentum_limit)


def _place_gyro(frame: mujoco.MjsFrame, gyro: GyroProperties) -> None:
    frame.pos = gyro.position_B
    _turn(frame, gyro.gimbal_axis_B, gyro.spin_axis_B)


def _turn(frame: mujoco.MjsFrame, gimbal_axis_B: Vector3, spin_axis_B: Vector3) -> None:
    """Put a unit's frame along its axes: x is the spin axis, z the gimbal axis."""
    frame.alt.type = mujoco.mjtOrientation.mjORIENTATION_XYAXES
    frame.alt.xyaxes = [*spin_axis_B, *np.cross(gimbal_axis_B, spin_axis_B)]


def _apply_mount(frame: mujoco.MjsFrame, index: int, properties: PlatformProperties) -> None:
    skew = BOX_SKEW if properties.array == "box" else properties.skew
    places = unit_places(properties.array, properties.units, 0.0 if skew is None else skew)
    if properties.mounting_radius is not None:
        frame.pos = properties.mounting_radius * places.direction_B[index]
    if skew is None:
        return
    if properties.array == "pyramid":
        # Turn about z until x is the spin axis, then about x until z is the gimbal axis.
        frame.alt.type = mujoco.mjtOrientation.mjORIENTATION_EULER
        frame.alt.euler = [azimuths(properties.units)[index] + 90.0, math.degrees(skew), 0.0]
    else:
        _turn(frame, places.gimbal_axis_B[index], places.spin_axis_B[index])


def _add_wheel(spec: mujoco.MjSpec, name: str, wheel: WheelProperties) -> None:
    """Mount a reaction wheel on the bus; a model that has it already gets its numbers."""
    mount = next((frame for frame in spec.frames if frame.name == f"{name}_mount"), None)
    if mount is None:
        mount = spec.body("bus").add_frame(name=f"{name}_mount")
        spec.attach(_read(shipped_model().with_name("wheel.xml")), prefix=f"{name}_", frame=mount)
    mount.pos = wheel.position_B
    mount.alt.type = mujoco.mjtOrientation.mjORIENTATION_ZAXIS
    mount.alt.zaxis = wheel.axis_B
    rotor, joint, motor = spec.body(f"{name}_rotor"), spec.joint(f"{name}_rotor"), spec.actuator(f"{name}_motor")
    rotor.mass, rotor.inertia = wheel.mass, [wheel.transverse_inertia, wheel.transverse_inertia, wheel.spin_inertia]
    joint.damping[0] = wheel.viscous_friction
    limit = wheel.torque_factor * wheel.torque_limit  # of the current, by which the drive knows its torque
    motor.forcelimited, motor.forcerange = True, [-limit, limit]
    motor.gainprm[0] = wheel.torque_factor
    if wheel.speed_loop_bandwidth:
        motor.biastype = mujoco.mjtBias.mjBIAS_AFFINE
        motor.biasprm[2] = -wheel.torque_factor * wheel.spin_inertia * wheel.speed_loop_bandwidth
    if wheel.motor_lag:
        motor.dyntype = mujoco.mjtDyn.mjDYN_FILTER  # as `unit_additions` has it for the gimbals' motors
        motor.dynprm[0] = wheel.motor_lag
    if wheel.imbalance:
        rotor.ipos[0] = wheel.imbalance / wheel.mass
    if wheel.coulomb_friction:
        joint.frictionloss = wheel.coulomb_friction
        joint.solref_friction = [2.0 * spec.option.timestep, 1.0]  # the quickest that MuJoCo integrates


def _apply_masses(gimbal: mujoco.MjsBody, rotor: mujoco.MjsBody, numbers: GyroProperties | PlatformProperties) -> None:
    if numbers.gimbal_mass is not None:
        gimbal.mass = numbers.gimbal_mass
    if numbers.rotor_mass is not None:
        rotor.mass = numbers.rotor_mass
    if numbers.gimbal_inertia is not None:
        gimbal.inertia = [numbers.gimbal_inertia] * 3
    spin, transverse = numbers.rotor_spin_inertia, numbers.rotor_transverse_inertia
    rotor.inertia = [
        rotor.inertia[0] if spin is None else spin,
        *([rotor.inertia[1]] * 2 if transverse is None else [transverse] * 2),
    ]


def _apply_gimbal_servo(spec: mujoco.MjSpec, unit: str, bandwidth: float) -> None:
    inertia = spec.body(f"{unit}_gimbal").inertia[2] + spec.body(f"{unit}_rotor").inertia[2]
    spec.actuator(f"{unit}_gimbal_motor").biasprm[2] = -inertia * bandwidth


def _apply_rotor_motor(spec: mujoco.MjSpec, unit: str, momentum: float, stated_limit: float | None) -> None:
    """Set torque = ctrl · kv · (target - speed), the target clamped to the rotor's momentum limit."""
    spin_inertia = spec.body(f"{unit}_rotor").inertia[0]
    limit = math.inf if stated_limit is None else stated_limit
    target = float(np.clip(momentum, -limit, limit)) / spin_inertia
    gain = spin_inertia * ROTOR_SERVO_BANDWIDTH
    spec.actuator(f"{unit}_rotor_motor").gainprm[:3] = [gain * target, 0.0, -gain]


def _apply_bus(spec: mujoco.MjSpec, properties: PlatformProperties, path: Path) -> None:
    """Give the bus what remains when the units' own inertia and parallel-axis terms are taken off."""
    bus = spec.body("bus")
    compiled = _weighed(spec, path)
    total = composite_inertia(compiled) if properties.inertia is None else properties.inertia
    if properties.mass is not None:
        bus.mass = bus.mass + properties.mass - composite_mass(compiled)
    if bus.mass <= 0.0:
        raise UnphysicalPlatformError("mass_kg", f" = {properties.mass}: the units alone weigh as much; raise it")
    if properties.wheels or properties.gyros:
        bus.ipos = -first_moment(compiled) / bus.mass  # the whole platform's centre of mass stays at the bus's origin
        compiled = _weighed(spec, path)
    if properties.inertia is not None:
        units = [word for word, own in (("gyros", properties.gyros), ("wheels", properties.wheels)) if own]
        _set_inertia(bus, bus_inertia(compiled, total), " and ".join(units) or "gyros")
    if properties.edge is not None:
        spec.geom("hull").size = [properties.edge / 2] * 3


def _weighed(spec: mujoco.MjSpec, path: Path) -> mujoco.MjModel:
    """Compile without what is only looked at, a tenth of the work; a copy, since a specification loses it by this."""
    bare = spec.copy()
    bare.compiler.discardvisual = True
    return _compile(bare, path)


def _set_inertia(bus: mujoco.MjsBody, inertia: Matrix3, units: str) -> None:
    """Give the bus an inertia, if it is a body's; units are those that were taken off, in words."""
    moments = np.linalg.eigvalsh(inertia)
    if moments[0] <= 0.0 or moments[0] + moments[1] < moments[2] - _TRIANGLE_SLACK:
        shown = ", ".join(f"{moment:.3g}" for moment in moments)
        raise UnphysicalPlatformError(
            "inertia_kg_m2",
            f": what remains for the bus when the {units} are taken off has the principal moments {shown} kg m2, "
            "which no body has; raise the inertia, lower the units' masses or radius, or narrow its dispersion",
        )
    bus.inertia, bus.iquat = np.zeros(3), np.array([1.0, 0.0, 0.0, 0.0])  # MuJoCo takes one form of inertia only
    bus.fullinertia = [*np.diag(inertia), inertia[0, 1], inertia[0, 2], inertia[1, 2]]


def _stand_on_bearing(spec: mujoco.MjSpec, bearing: AirBearing) -> None:
    """Put a ball joint, at the origin of N, in the place of the free joint, and let gravity pull.

    The bus frame's origin stays at the centre of mass.
    """
    spec.option.disableflags &= ~mujoco.mjtDisableBit.mjDSBL_GRAVITY.value
    spec.option.gravity = [0.0, 0.0, -bearing.gravity]
    spec.body("bus").pos = bearing.center_of_mass_B
    joint = spec.joint("bus")
    joint.type, joint.pos = mujoco.mjtJoint.mjJNT_BALL, -np.asarray(bearing.center_of_mass_B)
    joint.damping[0] = bearing.drag


def _add_cabin(spec: mujoco.MjSpec, size: Matrix3) -> None:
    """Put six walls around the origin and let the hull touch them."""
    spec.option.disableflags &= ~mujoco.mjtDisableBit.mjDSBL_CONTACT.value
    hull = spec.geom("hull")
    hull.contype, hull.conaffinity = 1, 1
    for axis, side in product(range(3), (-1.0, 1.0)):
        half = np.asarray(size, dtype=np.float64) / 2 + _WALL_THICKNESS
        center = np.zeros(3)
        center[axis] = side * half[axis]
        half[axis] = _WALL_THICKNESS
        spec.worldbody.add_geom(
            name=f"cabin_{'xyz'[axis]}{'-+'[side > 0]}",
            type=mujoco.mjtGeom.mjGEOM_BOX,
            pos=center,
            size=half,
            contype=1,
            conaffinity=1,
            rgba=[0.75, 0.78, 0.82, 0.08],
        )
