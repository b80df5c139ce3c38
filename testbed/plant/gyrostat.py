"""A compiled model as a gyrostat: its numbers for `dynamics.gyrostat_kernel`, or why it is none."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import mujoco
import numpy as np

from testbed.arrays import Array, Matrix3
from testbed.dynamics.environment import OrbitTorque, parallel_axes
from testbed.dynamics.gyrostat_kernel import Gyrostats, Places
from testbed.dynamics.inertia import theta_of
from testbed.plant.geometry import composite_inertia, composite_mass, first_moment, unit_names, wheel_names
from testbed.plant.layout import Layout, layout_of

_CENTERED = 1e-9
"""m, and share of a moment of inertia: what a model's own numbers, written with nine digits or more, may be off."""
_CUT = mujoco.mjtDisableBit.mjDSBL_ACTUATION | mujoco.mjtDisableBit.mjDSBL_CLAMPCTRL


def uncovered(model: mujoco.MjModel) -> Iterator[str]:
    """Yield what a platform has that the equations of a gyrostat do not; nothing for one that they cover.

    Args:
        model: compiled, with the parts that `testbed.plant.parts` asks for.
    """
    layout = layout_of(model)
    units, wheels = len(layout.gimbal_angle), len(layout.wheel_angle)
    if model.nbody != 2 + 2 * units + wheels or model.njnt != 1 + 2 * units + wheels:
        yield "bodies or joints beside its bus, gyros and wheels"
        return
    if model.nu != 2 * units + wheels:
        yield "actuators beside those of its gyros and wheels"
        return
    if model.neq or model.ntendon or model.nflex or model.nmocap or model.nplugin:
        yield "constraints, tendons, soft parts or plugins"
    if not model.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_CONTACT and model.geom_contype.any():
        yield "contacts: it may touch the walls of a cabin"
    yield from _uncovered_surroundings(model)
    yield from _uncovered_joints(model, layout)
    yield from _uncovered_bodies(model)
    yield from _uncovered_motors(model, layout)


def _uncovered_surroundings(model: mujoco.MjModel) -> Iterator[str]:
    falls = not model.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_GRAVITY and model.opt.gravity.any()
    if falls and (_floats(model) or model.opt.gravity[:2].any()):
        yield "a weight that no bearing carries, or gravity that is not along z"
    if model.opt.density or model.opt.viscosity or model.body_gravcomp.any():
        yield "a medium around it, or bodies without weight"
    if model.opt.disableflags & _CUT:
        yield "motors that are switched off"
    if _floats(model) and np.abs(first_moment(model) + _bus_moment(model)).max() > _CENTERED * composite_mass(model):
        yield "a centre of mass that is not at the origin of its bus"


def _uncovered_joints(model: mujoco.MjModel, layout: Layout) -> Iterator[str]:
    if model.dof_frictionloss.any():
        yield "dry friction in a joint"
    damped = np.ones(model.nv, dtype=np.bool_)
    damped[layout.wheel_speed] = False
    if not _floats(model):
        damped[layout.body_rate] = False
    if model.dof_armature.any() or model.jnt_stiffness.any() or model.dof_damping[damped].any():
        yield "springs, armatures, or viscous friction of gimbals or rotors"
    if model.jnt_limited.any():
        yield "joints with ends"
    if not _floats(model) and np.ptp(model.dof_damping[layout.body_rate]):
        yield "drag that differs from axis to axis"


def _uncovered_bodies(model: mujoco.MjModel) -> Iterator[str]:
    data = _drawn(model)
    for name in (*_names(model, "gimbal"), *_names(model, "rotor"), *_wheels(model)):
        joint, body = model.joint(name).id, model.body(name).id
        arm = data.xipos[body] - data.xanchor[joint]
        if np.abs(np.cross(arm, data.xaxis[joint])).max() > _CENTERED:
            yield f"{name}, whose centre of mass is not on its axis"
    for gimbal, rotor in zip(_names(model, "gimbal"), _names(model, "rotor"), strict=True):
        axes = _axes(model, data, gimbal, rotor)
        if np.abs(axes @ axes.T - np.eye(3)).max() > _CENTERED:
            yield f"{rotor}, whose axis is not normal to its gimbal's"
        arm = data.xipos[model.body(rotor).id] - data.xanchor[model.joint(gimbal).id]
        if np.abs(np.cross(arm, data.xaxis[model.joint(gimbal).id])).max() > _CENTERED:
            yield f"{rotor}, which does not stand on the axis of its gimbal"
        yield from _uncovered_moments(gimbal, axes @ _inertia(model, data, gimbal) @ axes.T, symmetric=False)
        yield from _uncovered_moments(rotor, axes @ _inertia(model, data, rotor) @ axes.T, symmetric=True)
    for wheel in _wheels(model):
        moments, axis = _inertia(model, data, wheel), data.xaxis[model.joint(wheel).id]
        across = np.linalg.svd(axis[None])[2][1:]
        rest = across @ moments @ across.T
        off = np.abs(np.cross(moments @ axis, axis)).max()
        if max(off, abs(rest[0, 1]), abs(rest[0, 0] - rest[1, 1])) > _CENTERED * np.trace(moments):
            yield f"{wheel}, which is not round about its axis"


def _uncovered_moments(name: str, inertia: Matrix3, *, symmetric: bool) -> Iterator[str]:
    """Inertia along spin, transverse and gimbal axis."""
    off = np.abs(inertia - np.diag(np.diag(inertia))).max()
    if max(off, abs(inertia[1, 1] - inertia[2, 2]) if symmetric else 0.0) > _CENTERED * np.trace(inertia):
        yield f"{name}, whose principal axes are not its unit's"


def _uncovered_motors(model: mujoco.MjModel, layout: Layout) -> Iterator[str]:
    gimbals, rotors, wheels = layout.gimbal_motor, layout.rotor_motor, layout.wheel_motor
    kinds = np.array(model.actuator_dyntype)
    kinds[wheels[kinds[wheels] == mujoco.mjtDyn.mjDYN_FILTER]] = mujoco.mjtDyn.mjDYN_NONE
    if (kinds != mujoco.mjtDyn.mjDYN_NONE).any():
        yield "motors with dynamics of their own"
    if model.actuator_delay.any():
        yield "motors that answer late"
    bias, gain = model.actuator_biasprm, model.actuator_gainprm
    plain = (
        not bias[:, :2].any()
        and not bias[rotors].any()
        and (gain[gimbals, 0] == 1.0).all()
        and not gain[rotors, 1].any()
        and not (gain[np.r_[gimbals, wheels], 1:3]).any()
        and (model.actuator_gear[:, 0] == 1.0).all()
        and not model.actuator_gear[:, 1:].any()
    )
    limited = model.actuator_forcelimited[np.r_[gimbals, rotors]].any() or model.actuator_ctrllimited[gimbals].any()
    of_joints = model.jnt_actfrclimited[model.dof_jntid[np.r_[layout.rotor_speed, layout.wheel_speed]]].any()
    if not plain or limited or of_joints or model.actuator_ctrllimited[wheels].any():
        yield "motors that are none of the usual ones"


def gyrostats_of(models: Sequence[mujoco.MjModel], orbit_torque: OrbitTorque | None = None) -> Gyrostats:
    """Return the numbers of compiled platforms of one layout, none of which has anything `uncovered`, on an orbit."""
    numbers: dict[int, tuple[Array, Array, Array]] = {}
    for model in models:
        if id(model) not in numbers:
            numbers[id(model)] = _numbers(model)
    body, units, wheels = zip(*(numbers[id(model)] for model in models), strict=True)
    orbit = np.zeros((len(models), 17)) if orbit_torque is None else _orbit_numbers(orbit_torque)
    return Gyrostats(
        body=np.concatenate([np.stack(body), orbit], axis=1),
        units=np.stack(units),
        wheels=np.stack(wheels),
        places=_places(models[0]),
    )


def _orbit_numbers(torque: OrbitTorque) -> Array:
    orbit = torque.orbit
    alike = np.concatenate([orbit.dipole_B, orbit.field_L, orbit.torque_L])
    rows = [
        np.concatenate([[orbit.rate, 3.0 * orbit.rate**2 * orbit.gradient], theta_of(inertia), alike])
        for inertia in torque.inertia
    ]
    return np.array(rows)


def _numbers(model: mujoco.MjModel) -> tuple[Array, Array, Array]:
    data, layout = _drawn(model), layout_of(model)
    bus = data.xmat[model.body("bus").id].reshape(3, 3)
    units, carried = _unit_numbers(model, data, layout, bus)
    wheels = _wheel_numbers(model, data, layout, bus)
    inertia = composite_inertia(model) - carried - np.einsum("w,wi,wj->ij", wheels[:, 3], wheels[:, :3], wheels[:, :3])
    moment, drag = np.zeros(3), 0.0
    if not _floats(model):
        mass, joint = composite_mass(model), model.joint("bus").id
        offset_B = (data.subtree_com[model.body("bus").id] - data.xanchor[joint]) @ bus
        inertia = inertia + parallel_axes(mass, offset_B)
        drag = model.dof_damping[layout.body_rate][0]
        if not model.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_GRAVITY:
            moment = -mass * model.opt.gravity[2] * offset_B
    return np.concatenate([theta_of(inertia), moment, [drag, model.opt.timestep]]), units, wheels


def _unit_numbers(model: mujoco.MjModel, data: mujoco.MjData, layout: Layout, bus: Matrix3) -> tuple[Array, Matrix3]:
    """Return the numbers of all units, and what of the platform's inertia at gimbal angles zero stands in them."""
    rows, carried = [], np.zeros((3, 3))
    for unit, (gimbal, rotor) in enumerate(zip(_names(model, "gimbal"), _names(model, "rotor"), strict=True)):
        axes = _axes(model, data, gimbal, rotor)
        spin_B, across_B, gimbal_B = axes @ bus
        of_gimbal = np.diag(axes @ _inertia(model, data, gimbal) @ axes.T)
        of_rotor = np.diag(axes @ _inertia(model, data, rotor) @ axes.T)
        moments = np.array([of_gimbal[0], of_gimbal[1] + of_rotor[2], of_gimbal[2] + of_rotor[2], of_rotor[0]])
        joint = model.joint(gimbal).id
        limit = model.jnt_actfrcrange[joint, 1] if model.jnt_actfrclimited[joint] else np.inf
        servo = model.actuator_gainprm[layout.rotor_motor[unit]]
        kv = -model.actuator_biasprm[layout.gimbal_motor[unit], 2]
        rows.append(np.concatenate([gimbal_B, spin_B, across_B, moments, [kv, limit, servo[0], servo[2]]]))
        along = (moments[0] + moments[3], moments[1], moments[2])
        carried += sum(each * np.outer(axis, axis) for each, axis in zip(along, axes @ bus, strict=True))
    return np.array(rows).reshape(-1, 17), carried


def _wheel_numbers(model: mujoco.MjModel, data: mujoco.MjData, layout: Layout, bus: Matrix3) -> Array:
    rows = []
    for wheel, name in enumerate(_wheels(model)):
        motor, axis = layout.wheel_motor[wheel], data.xaxis[model.joint(name).id]
        limit = model.actuator_forcerange[motor, 1] if model.actuator_forcelimited[motor] else np.inf
        spin = axis @ _inertia(model, data, name) @ axis
        drive = (model.actuator_gainprm[motor, 0], model.actuator_biasprm[motor, 2], limit)
        friction = model.dof_damping[layout.wheel_speed[wheel]]
        rows.append(np.concatenate([axis @ bus, [spin, *drive, friction, model.actuator_dynprm[motor, 0]]]))
    return np.array(rows).reshape(-1, 9)


def _places(model: mujoco.MjModel) -> Places:
    """A row holds qpos, qvel, the motors' states, torques and the time, as MuJoCo orders them."""
    layout = layout_of(model)
    rates = model.nq
    lags = model.actuator_actadr[layout.wheel_motor]
    position = layout.position.start if _floats(model) else -1
    body = (layout.attitude.start, position, rates + layout.velocity.start, rates + layout.body_rate.start)
    units = (layout.gimbal_angle, layout.rotor_angle, rates + layout.gimbal_rate, rates + layout.rotor_speed)
    wheels = (layout.wheel_angle, rates + layout.wheel_speed, np.where(lags < 0, -1, rates + model.nv + lags))
    return Places(
        body=np.array([*body, model.nv + model.na]),
        units=np.stack([*units, layout.gimbal_motor, layout.rotor_motor], axis=1),
        wheels=np.stack([*wheels, layout.wheel_motor], axis=1),
    )


def _floats(model: mujoco.MjModel) -> bool:
    return bool(model.jnt_type[model.joint("bus").id] == mujoco.mjtJoint.mjJNT_FREE)


def _bus_moment(model: mujoco.MjModel) -> Array:
    bus = model.body("bus").id
    return np.asarray(model.body_mass[bus] * model.body_ipos[bus])


def _names(model: mujoco.MjModel, kind: str) -> tuple[str, ...]:
    return unit_names(kind, len(layout_of(model).gimbal_angle))


def _wheels(model: mujoco.MjModel) -> tuple[str, ...]:
    return wheel_names("rotor", len(layout_of(model).wheel_angle))


def _axes(model: mujoco.MjModel, data: mujoco.MjData, gimbal: str, rotor: str) -> Matrix3:
    """Return spin, transverse and gimbal axis of a unit as drawn, rows, inertial axes."""
    about, along = data.xaxis[model.joint(gimbal).id], data.xaxis[model.joint(rotor).id]
    return np.stack([along, np.cross(about, along), about])


def _inertia(model: mujoco.MjModel, data: mujoco.MjData, name: str) -> Matrix3:
    body = model.body(name).id
    rotation = data.ximat[body].reshape(3, 3)
    return np.asarray(rotation @ np.diag(model.body_inertia[body]) @ rotation.T)


def _drawn(model: mujoco.MjModel) -> mujoco.MjData:
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    return data
