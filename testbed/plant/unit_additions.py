"""What effects change in the CMG units and in the actuators of a platform, written into an MjSpec."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import final

import mujoco
from typing_extensions import override

from testbed.plant.additions import Addition
from testbed.signals import KINDS

_NO_TORQUE = 1e-12
"""N·m, a limit that MuJoCo takes for one; a scenario writes over the servo's gain, and its target stays to be read."""
_APPLIED_TORQUE = "applied_torque"
"""Actuators of a torque on the bus are named `applied_torque_x`, `_y`, `_z`; their control is the torque asked for."""

_LINES = 1
"""Of a motor's `interp`: its control goes along a line from sample to sample."""


@final
@dataclass(frozen=True, kw_only=True)
class RotorDrag(Addition):
    """A rotor that is not driven any more and slows down against a drag.

    Attributes:
        unit: index from 0.
        decay: of its speed, 1/s.
    """

    unit: int
    decay: float

    @override
    def write(self, spec: mujoco.MjSpec, name: str) -> None:
        unit = f"cmg{self.unit + 1}"
        motor = spec.actuator(f"{unit}_rotor_motor")
        motor.forcelimited, motor.forcerange = True, [-_NO_TORQUE, _NO_TORQUE]
        spec.joint(f"{unit}_rotor").damping[0] += self.decay * spec.body(f"{unit}_rotor").inertia[0]


@final
@dataclass(frozen=True, kw_only=True)
class GimbalFriction(Addition):
    """Friction between the bus and a gimbal.

    Attributes:
        unit: index from 0.
        viscous: torque over the gimbal's rate, N·m·s/rad.
        dry: torque against any motion, N·m.
    """

    unit: int
    viscous: float = 0.0
    dry: float = 0.0

    @override
    def write(self, spec: mujoco.MjSpec, name: str) -> None:
        joint = spec.joint(f"cmg{self.unit + 1}_gimbal")
        joint.damping[0] += self.viscous
        joint.frictionloss += self.dry
        joint.solref_friction = [2.0 * spec.option.timestep, 1.0]  # the quickest that MuJoCo integrates


@final
@dataclass(frozen=True, kw_only=True)
class GimbalMotorLag(Addition):
    """A gimbal motor whose torque follows the demand late; its tachometer loop, inside the motor, is as quick as ever.

    Attributes:
        unit: index from 0.
        time_constant: of a first-order lag, s.
    """

    unit: int
    time_constant: float

    @override
    def write(self, spec: mujoco.MjSpec, name: str) -> None:
        _slow_down(spec.actuator(f"cmg{self.unit + 1}_gimbal_motor"), self.time_constant)


@final
@dataclass(frozen=True, kw_only=True)
class UnbalancedRotor(Addition):
    """A rotor whose centre of mass lies beside its axis.

    Attributes:
        unit: index from 0.
        static: its mass times that distance, kg·m.
    """

    unit: int
    static: float

    @override
    def write(self, spec: mujoco.MjSpec, name: str) -> None:
        rotor = spec.body(f"cmg{self.unit + 1}_rotor")
        rotor.ipos[1] += self.static / rotor.mass


@final
@dataclass(frozen=True, kw_only=True)
class WheelDelay(Addition):
    """Reaction wheels whose motors give their torques late.

    Attributes:
        delay: s.
    """

    delay: float

    @override
    def write(self, spec: mujoco.MjSpec, name: str) -> None:
        for motor in spec.actuators:
            if motor.name.startswith(KINDS["wheel"].prefix):
                _put_off(spec, motor, self.delay)


@final
@dataclass(frozen=True, kw_only=True)
class ActuatorResponse(Addition):
    """Actuators of a torque on the bus that respond late; a platform that has none is given them.

    Attributes:
        time_constant: of a first-order lag, s.
        delay: s.
    """

    time_constant: float = 0.0
    delay: float = 0.0

    @override
    def write(self, spec: mujoco.MjSpec, name: str) -> None:
        for motor in _torque_actuators(spec, name):
            _slow_down(motor, self.time_constant)
            _put_off(spec, motor, self.delay)


def _put_off(spec: mujoco.MjSpec, motor: mujoco.MjsActuator, delay: float) -> None:
    """Let a motor answer to its control so much later, s; by a time below a step, a whole step or not at all.

    Controls are held through a step. Of held values, RK4 reads the next one in a step's last stage, a sixth of a step
    early. On lines between them, half a step later, each acts on average as late as it should.
    """
    step = spec.option.timestep
    if delay < 0.5 * step:
        return
    before = motor.delay or 0.5 * step
    motor.delay, motor.interp = before + delay, _LINES
    motor.nsample = math.ceil(motor.delay / step) + 2


def _slow_down(motor: mujoco.MjsActuator, time_constant: float) -> None:
    """Let a motor follow its control through a first-order lag, or through a longer one than it has.

    `filter`, not `filterexact`: that one is exact for a single stage only, and under RK4 late by another half step.
    """
    if time_constant > 0.0:
        present = motor.dynprm[0] if motor.dyntype == mujoco.mjtDyn.mjDYN_FILTER else 0.0
        motor.dyntype = mujoco.mjtDyn.mjDYN_FILTER
        motor.dynprm[0] = present + time_constant


def _torque_actuators(spec: mujoco.MjSpec, name: str) -> list[mujoco.MjsActuator]:
    present = [each for each in spec.actuators if each.name.startswith(_APPLIED_TORQUE)]
    return present or _added_torque_actuators(spec, name)


def _added_torque_actuators(spec: mujoco.MjSpec, name: str) -> list[mujoco.MjsActuator]:
    site = spec.body("bus").add_site(name=name)
    motors = []
    for axis in range(3):
        gear = [0.0] * 6
        gear[3 + axis] = 1.0
        motor = spec.add_actuator(
            name=f"{_APPLIED_TORQUE}_{'xyz'[axis]}", trntype=mujoco.mjtTrn.mjTRN_SITE, target=site.name, gear=gear
        )
        motor.set_to_motor()
        motors.append(motor)
    return motors
