"""What a compiled model says of the platform: composite inertia, the CMG cluster, the momentum of a state."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import count

import mujoco
import numpy as np

from testbed.arrays import Array, Matrix3, Units, Vector3, Vectors3
from testbed.cmg.cluster import Cluster
from testbed.cmg.wheels import Wheels


def unit_names(kind: str, units: int) -> tuple[str, ...]:
    """Return `cmg1_gimbal` ... for the kind `gimbal`: units are numbered from 1, as in file columns."""
    return tuple(f"cmg{number}_{kind}" for number in range(1, units + 1))


def wheel_names(kind: str, wheels: int) -> tuple[str, ...]:
    """Return `wheel1_rotor` ... for the kind `rotor`."""
    return tuple(f"wheel{number}_{kind}" for number in range(1, wheels + 1))


def wheel_count(model: mujoco.MjModel) -> int:
    """Return how many reaction wheels a compiled platform has."""
    return _numbered(model, "wheel{}_rotor")


def unit_count(model: mujoco.MjModel) -> int:
    """Return how many CMG units a compiled platform has."""
    return _numbered(model, "cmg{}_gimbal")


def _numbered(model: mujoco.MjModel, name: str) -> int:
    """Return how many joints of a name there are, numbered from 1."""
    names = {model.joint(joint).name for joint in range(model.njnt)}
    return next(number for number in count() if name.format(number + 1) not in names)


def composite_mass(model: mujoco.MjModel) -> float:
    """Return the mass of the platform, units included, kg."""
    return float(model.body_subtreemass[model.body("bus").id])


def composite_inertia(model: mujoco.MjModel) -> Matrix3:
    """Return J of the whole platform, rotors locked, gimbals at zero, about its centre of mass, kg·m², body axes."""
    return _inertia_of_bodies(model, _platform_bodies(model))


def bus_inertia(model: mujoco.MjModel, total: Matrix3) -> Matrix3:
    """Return the inertia that the bus body needs so that the composite is `total`, kg·m², about its own centre of mass.

    Its mass is in place already.
    """
    offset, mass = model.body_ipos[model.body("bus").id], model.body_mass[model.body("bus").id]
    remaining = np.asarray(total - _inertia_of_bodies(model, _on_the_bus(model)))
    return remaining - mass * (offset @ offset * np.eye(3) - np.outer(offset, offset)) if offset.any() else remaining


def first_moment(model: mujoco.MjModel) -> Vector3:
    """Return Σ m r of all that is mounted on the bus, r from the bus's origin, shape (3,), kg·m, body axes."""
    data, bodies = _at_rest(model), _on_the_bus(model)
    bus = model.body("bus").id
    return np.asarray(model.body_mass[bodies] @ (data.xipos[bodies] - data.xpos[bus]) @ data.xmat[bus].reshape(3, 3))


def cluster_of(model: mujoco.MjModel) -> Cluster:
    """Read the cluster off a compiled model: axes from its kinematics, rotor speeds from the rotor servos' targets."""
    data = _at_rest(model)
    bus_rotation = data.xmat[model.body("bus").id].reshape(3, 3)
    units = unit_count(model)
    gimbals = [model.body(name).id for name in unit_names("gimbal", units)]
    rotors = [model.body(name).id for name in unit_names("rotor", units)]
    gimbal_axis_N = _axes(model, data, "gimbal")
    spin_axis_N = _axes(model, data, "rotor")
    spin_inertia = _inertia_along(model, data, rotors, spin_axis_N)
    return Cluster(
        gimbal_axis_B=gimbal_axis_N @ bus_rotation,
        spin_axis_B=spin_axis_N @ bus_rotation,
        rotor_momentum=spin_inertia * rotor_speed_target(model),
        rotor_spin_inertia=spin_inertia,
        rotor_transverse_inertia=_inertia_along(model, data, rotors, gimbal_axis_N),
        gimbal_inertia=_inertia_along(model, data, gimbals, gimbal_axis_N),
        position_B=(data.xipos[rotors] - data.subtree_com[model.body("bus").id]) @ bus_rotation,
    )


def wheels_of(model: mujoco.MjModel, momentum_limit: Units) -> Wheels:
    """Read the reaction wheels off a compiled model.

    Args:
        model: the platform.
        momentum_limit: largest |Jw Ω| of each, shape (W,), N·m·s, which their drives know.
    """
    data, names = _at_rest(model), wheel_names("rotor", wheel_count(model))
    bus_rotation = data.xmat[model.body("bus").id].reshape(3, 3)
    axis_N = np.array([data.xaxis[model.joint(name).id] for name in names]).reshape(-1, 3)
    motors = [model.actuator(name).id for name in wheel_names("motor", len(names))]
    rotors = [model.body(name).id for name in names]
    return Wheels(
        axis_B=axis_N @ bus_rotation,
        spin_inertia=_inertia_along(model, data, rotors, axis_N),
        momentum_limit=momentum_limit,
        torque_limit=np.array(model.actuator_forcerange[motors, 1]),
        position_B=(data.xpos[rotors] - data.subtree_com[model.body("bus").id]) @ bus_rotation,
    )


def rotor_speed_target(model: mujoco.MjModel) -> Array:
    """Return the speed that each rotor servo holds, shape (M,), rad/s."""
    motors = unit_names("rotor_motor", unit_count(model))
    gain = np.array([model.actuator(name).gainprm[:3] for name in motors]).reshape(-1, 3)
    return np.asarray(gain[:, 0] / -gain[:, 2])


def total_momentum(model: mujoco.MjModel, qpos: Array, qvel: Array) -> Vectors3:
    """Return MuJoCo's own angular momentum of the platform, shape (N, 3), N·m·s, in N.

    About its centre of mass; of a platform on a bearing about the pivot, the origin of N.

    Args:
        model: the platform.
        qpos: shape (N, nq).
        qvel: shape (N, nv).
    """
    data, bus = mujoco.MjData(model), model.body("bus").id
    momentum_N = np.empty((len(qpos), 3))
    pivoted, mass = model.jnt_type[model.joint("bus").id] == mujoco.mjtJoint.mjJNT_BALL, composite_mass(model)
    for row, (position, velocity) in enumerate(zip(qpos, qvel, strict=True)):
        data.qpos[:], data.qvel[:] = position, velocity
        mujoco.mj_fwdPosition(model, data)
        mujoco.mj_fwdVelocity(model, data)
        mujoco.mj_subtreeVel(model, data)
        momentum_N[row] = data.subtree_angmom[bus]
        if pivoted:
            momentum_N[row] += mass * np.cross(data.subtree_com[bus], data.subtree_linvel[bus])
    return momentum_N


def _platform_bodies(model: mujoco.MjModel) -> list[int]:
    root = model.body("bus").id
    return [body for body in range(model.nbody) if model.body_rootid[body] == root]


def _on_the_bus(model: mujoco.MjModel) -> list[int]:
    bus = model.body("bus").id
    return [body for body in _platform_bodies(model) if body != bus]


def _inertia_of_bodies(model: mujoco.MjModel, bodies: list[int]) -> Matrix3:
    data = _at_rest(model)
    return inertia_about(model, data, bodies, data.subtree_com[model.body("bus").id])


def inertia_about(model: mujoco.MjModel, data: mujoco.MjData, bodies: Iterable[int], center: Vector3) -> Matrix3:
    """Return the inertia of some bodies about a point, shape (3, 3), kg·m², inertial axes.

    Args:
        model: compiled.
        data: where they are.
        bodies: their numbers.
        center: the point, shape (3,), m, inertial axes.
    """
    inertia = np.zeros((3, 3))
    for body in bodies:
        rotation = data.ximat[body].reshape(3, 3)
        arm = data.xipos[body] - center
        inertia += rotation @ np.diag(model.body_inertia[body]) @ rotation.T
        inertia += model.body_mass[body] * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    return inertia


def _at_rest(model: mujoco.MjModel) -> mujoco.MjData:
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    return data


def _axes(model: mujoco.MjModel, data: mujoco.MjData, kind: str) -> Array:
    return np.array([data.xaxis[model.joint(name).id] for name in unit_names(kind, unit_count(model))]).reshape(-1, 3)


def _inertia_along(model: mujoco.MjModel, data: mujoco.MjData, bodies: list[int], axes_N: Array) -> Array:
    rotations = data.ximat[bodies].reshape(-1, 3, 3)
    in_principal_axes = np.einsum("bij,bi->bj", rotations, axes_N)
    return np.asarray((in_principal_axes**2 * model.body_inertia[bodies]).sum(axis=1))
