"""What acts on a user's own model, and no scenario can say: springs, armatures, laws of motors, a medium."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import mujoco
import numpy as np

from testbed.plant.adopted_roles import Taken
from testbed.plant.own_model import OwnModel


def left_out(own: OwnModel, taken: Sequence[Taken]) -> Iterator[str]:
    """Yield what of joints, motors and surroundings is not flown.

    Args:
        own: the model.
        taken: every joint of the platform, and what it was taken for, its own first.
    """
    moving = [each for each in taken if each.role != "locked"]
    for each in moving:
        yield from (f"{each.name}: its {part} is left out" for part in _of_joint(own.model, each))
        if own.model.jnt_limited[each.joint]:
            yield f"{each.name}: its stops are left out"
    for each in moving[1:]:
        for motor in own.motors(each.joint):
            yield from (f"{each.name}: its motor's {part} is left out" for part in _of_motor(own, motor, each))
    for each in taken:
        if each.role == "locked" and own.model.jnt_stiffness[each.joint]:
            yield f"{each.name}: it is locked as drawn, and its spring is left out"
    yield from _beside(own, taken[0].joint)
    yield from _others(own, {each.joint for each in moving[1:]})
    yield from _surroundings(own, taken[0].joint)


def written(*numbers: float) -> str:
    """Return the numbers of an attribute as a model has them, less the zeros at its end."""
    digits = [f"{number:.3g}" for number in numbers]
    while digits[1:] and digits[-1] == "0":
        digits.pop()
    return " ".join(digits)


def _of_joint(model: mujoco.MjModel, taken: Taken) -> Iterator[str]:
    joint, freedom = taken.joint, int(model.jnt_dofadr[taken.joint])
    if model.dof_armature[freedom]:
        yield f"armature of {model.dof_armature[freedom]:.3g} kg·m²"
    if model.jnt_stiffness[joint] or model.jnt_stiffnesspoly[joint].any():
        yield f"spring of {written(model.jnt_stiffness[joint], *model.jnt_stiffnesspoly[joint])} N·m/rad"
    damping, growing = model.dof_damping[freedom], model.dof_dampingpoly[freedom]
    if taken.role == "wheel" or model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_BALL:
        if growing.any():
            yield f"damping of {written(damping, *growing)} N·m·s/rad, but for the first number,"
    elif damping or growing.any():
        yield f"damping of {written(damping, *growing)} N·m·s/rad"
    if taken.role != "wheel" and model.dof_frictionloss[freedom]:
        yield f"dry friction of {model.dof_frictionloss[freedom]:.3g} N·m"


def _of_motor(own: OwnModel, motor: int, taken: Taken) -> Iterator[str]:
    """Yield what a torque as commanded, and a wheel's loop about its speed, do not say."""
    model, gear = own.model, float(own.model.actuator_gear[motor, 0])
    if model.actuator_dyntype[motor] != mujoco.mjtDyn.mjDYN_NONE:
        kind = mujoco.mjtDyn(int(model.actuator_dyntype[motor])).name.removeprefix("mjDYN_").lower()
        yield f"activation, dyntype {kind} {written(*model.actuator_dynprm[motor, :3])},"
    if model.actuator_delay[motor]:
        yield f"delay of {model.actuator_delay[motor]:.3g} s"
    if model.actuator_armature[motor]:
        yield f"armature of {model.actuator_armature[motor] * gear**2:.3g} kg·m²"
    damping = gear**2 * np.array([model.actuator_damping[motor], *model.actuator_dampingpoly[motor]])
    if damping.any():
        yield f"damping of {written(*damping)} N·m·s/rad"
    gain, bias = int(model.actuator_gaintype[motor]), int(model.actuator_biastype[motor])
    if gain != mujoco.mjtGain.mjGAIN_FIXED or bias not in {mujoco.mjtBias.mjBIAS_NONE, mujoco.mjtBias.mjBIAS_AFFINE}:
        kinds = [kind.name.partition("_")[2].lower() for kind in (mujoco.mjtGain(gain), mujoco.mjtBias(bias))]
        yield f"law, gaintype {kinds[0]} and biastype {kinds[1]},"
    elif bias == mujoco.mjtBias.mjBIAS_NONE:
        least, most = model.actuator_ctrlrange[motor]
        if model.actuator_ctrllimited[motor] and least != -most:
            yield f"one-sided range, {least:.3g} to {most:.3g} in place of ±{max(-least, most):.3g},"
    elif bias == mujoco.mjtBias.mjBIAS_AFFINE:
        constant, angle, speed = model.actuator_biasprm[motor, :3]
        if constant:
            yield f"constant torque of {gear * constant:.3g} N·m"
        if angle:
            yield f"loop about its angle, {-(gear**2) * angle:.3g} N·m/rad,"
        if speed and (taken.role == "gimbal" or (taken.role == "wheel" and own.loop_gain(taken.joint) <= 0.0)):
            yield f"loop about its speed, {-(gear**2) * speed:.3g} N·m·s/rad,"


def _beside(own: OwnModel, base: int) -> Iterator[str]:
    """Yield what else moves in the model's world."""
    platform = own.subtree(own.body(base))
    apart = [body for body in range(1, own.model.nbody) if body not in platform and own.joints(body)]
    for body in apart:
        if not any(own.joints(carrier) for carrier in own.ancestors(body)):
            name = str(own.model.body(body).name) or own.name(own.joints(body)[0])
            mass = own.model.body_subtreemass[body]
            yield f"{name}: it is no part of the platform, and is left out with its {mass:.6g} kg"


def _others(own: OwnModel, joints: set[int]) -> Iterator[str]:
    """Yield actuators that turn none of the joints that move, such as thrusters."""
    motors = {motor for joint in joints for motor in own.motors(joint)}
    others = [motor for motor in range(len(own.model.actuator_trntype)) if motor not in motors]
    if others:
        names = ", ".join(str(own.model.actuator(motor).name) or f"number {motor + 1}" for motor in others)
        yield f"actuators that turn no wheel, gimbal or rotor are left out: {names}"


def _surroundings(own: OwnModel, base: int) -> Iterator[str]:
    model = own.model
    if model.jnt_type[base] == mujoco.mjtJoint.mjJNT_BALL:
        if np.any(model.opt.gravity[:2]):
            yield "gravity is flown along -z of the world, wherever the model's points"
        if buoyant := [body for body in own.subtree(own.body(base)) if model.body_gravcomp[body]]:
            names = ", ".join(str(model.body(body).name) or f"body {body}" for body in buoyant)
            yield f"the gravcomp of bodies is left out: {names}"
    if model.opt.density or model.opt.viscosity:
        yield f"a medium of {model.opt.density:.3g} kg/m³ and {model.opt.viscosity:.3g} Pa·s is left out"
    for count, kind in ((model.neq, "equality constraint"), (model.ntendon, "tendon")):
        if count:
            yield f"{count} {kind}{' is' if count == 1 else 's are'} left out"
