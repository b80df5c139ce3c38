"""A user's own model and the platform that was built after it, moved by the same torques."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import mujoco
import numpy as np

from testbed.arrays import Array, Units
from testbed.errors import InputError
from testbed.plant.adopted import AdoptedPlatform
from testbed.plant.adopted_notes import written
from testbed.plant.layout import layout_of

_STEP = 1.25e-3
"""s; RK4 is then within 1e-9 rad/s (docs/reference/agreement.md)."""
_DURATION = 10.0
"""s, as the agreement with other engines is stated for."""
_BODY_RATE = (0.1, -0.07, 0.05)
"""rad/s, at the start: so that products of inertia show."""
_GIMBAL_ACCELERATION = 10.0
"""rad/s², amplitude of what motors ask of gimbals: half a radian a second against the damping."""
_GIMBAL_DAMPING = 20.0
"""1/s, added to all gimbals: left free, six of them move chaotically, and rounding grows to 1e-4 rad/s in 10 s."""


def motion_difference(
    adopted: AdoptedPlatform, built: mujoco.MjModel, wheel_torque: Units, rotor_speed: Units
) -> float:
    """Return the largest difference of body rates over 10 s, rad/s, in which both are moved by the same torques.

    Motors' own loops and limits are off in both, and gimbals damped alike: what is compared are bodies and joints. In
    the user's model contacts, constraints and stops are off, gravity too but on a bearing, and locked joints as drawn.

    Args:
        adopted: the user's model.
        built: the platform.
        wheel_torque: amplitude of each wheel's torque, shape (W,), N·m.
        rotor_speed: of each gyro's rotor at the start, shape (M,), rad/s.

    Raises:
        InputError: the user's model cannot be compiled without its locked joints.
    """
    theirs, base = _moving(adopted)
    gravity = 0.0 if adopted.bearing is None else adopted.bearing.gravity
    models = (_bare(theirs, gravity), _bare(built, gravity))
    layout = layout_of(models[1])
    free = models[0].joint(base).dofadr[0] + (3 if adopted.bearing is None else 0)
    rates = (slice(free, free + 3), layout.body_rate)
    wheels = (_freedoms(models[0], [wheel.name for wheel in adopted.wheels]), layout.wheel_speed)
    gimbals = (_freedoms(models[0], [gyro.name for gyro in adopted.gyros]), layout.gimbal_rate)
    rotors = (_freedoms(models[0], [gyro.rotor.name for gyro in adopted.gyros]), layout.rotor_speed)
    states = [mujoco.MjData(model) for model in models]
    inertia = np.array([gyro.inertia + gyro.rotor.transverse_inertia for gyro in adopted.gyros])
    for model, gimballed in zip(models, gimbals, strict=True):
        model.dof_damping[gimballed] += _GIMBAL_DAMPING * inertia
    if adopted.bearing is not None:
        states[1].qpos[layout.attitude] = adopted.bearing.attitude
    sign = np.array([-1.0 if gyro.is_reversed else 1.0 for gyro in adopted.gyros])
    for state, turning, spinning, speed in zip(states, rates, rotors, (sign * rotor_speed, rotor_speed), strict=True):
        state.qvel[turning], state.qvel[spinning] = _BODY_RATE, speed
    worst = 0.0
    for step in range(round(_DURATION / _STEP)):
        asked = _waves(wheel_torque, step * _STEP), _waves(_GIMBAL_ACCELERATION * inertia, step * _STEP)
        for model, state, turned, gimballed in zip(models, states, wheels, gimbals, strict=True):
            state.qfrc_applied[turned], state.qfrc_applied[gimballed] = asked
            mujoco.mj_step(model, state)
        differ = states[0].qvel[rates[0]] - states[1].qvel[rates[1]]
        worst = max(worst, float(np.abs(differ).max()))
    return worst


def softness_notes(adopted: AdoptedPlatform, built: mujoco.MjModel) -> Iterator[str]:
    """Yield where a wheel's dry friction is flown otherwise about standstill than in the user's model.

    MuJoCo has friction grow with the speed there, as solref and solimp say, which no scenario states.

    Args:
        adopted: the user's model.
        built: the platform.
    """
    own, layout = adopted.own.model, layout_of(built)
    for wheel, flown in zip(adopted.wheels, layout.wheel_speed, strict=True):
        drawn = own.joint(wheel.name).dofadr[0]
        for key, theirs, ours in (
            ("solreffriction", own.dof_solref[drawn], built.dof_solref[flown]),
            ("solimpfriction", own.dof_solimp[drawn], built.dof_solimp[flown]),
        ):
            if wheel.dry_friction and not np.array_equal(theirs, ours):
                yield (
                    f"{wheel.name}: the softness of its dry friction of {wheel.dry_friction:.3g} N·m about standstill, "
                    f"{key} {written(*theirs)}, is left out; {written(*ours)} is flown"
                )


def _waves(amplitude: Units, time: float) -> Units:
    """Return torques that are not in step."""
    number = np.arange(len(amplitude))
    return np.asarray(amplitude * np.sin(2.0 * np.pi * (0.2 + 0.07 * number) * time + number))


def _moving(adopted: AdoptedPlatform) -> tuple[mujoco.MjModel, str]:
    """Return the user's model without its locked joints, and the name of its free joint."""
    spec = adopted.own.spec.copy()
    for each in adopted.taken:
        if each.role == "locked":
            spec.delete(spec.joint(each.name))
    for actuator in list(spec.actuators):
        spec.delete(actuator)
    for key in list(spec.keys):
        spec.delete(key)
    try:
        return spec.compile(), adopted.taken[0].name
    except ValueError as error:
        raise InputError(f"{adopted.own.path}: cannot be compiled without its locked joints: {error}") from error


def _bare(model: mujoco.MjModel, gravity: float) -> mujoco.MjModel:
    """Let nothing but bodies, joints and gravity on a bearing act."""
    flags, option = mujoco.mjtDisableBit, model.opt
    option.integrator, option.timestep = mujoco.mjtIntegrator.mjINT_RK4, _STEP
    option.gravity[:] = (0.0, 0.0, -gravity)
    option.disableflags &= ~flags.mjDSBL_GRAVITY.value
    option.density = option.viscosity = 0.0
    for flag in (flags.mjDSBL_CONTACT, flags.mjDSBL_EQUALITY, flags.mjDSBL_LIMIT, flags.mjDSBL_ACTUATION):
        option.disableflags |= flag.value
    return model


def _freedoms(model: mujoco.MjModel, names: Sequence[str]) -> Array:
    return np.array([model.joint(name).dofadr[0] for name in names], dtype=np.intp)
