"""Torques on the bus that follow its motion: actuators without a control, written into an MjSpec."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, final

import mujoco
import numpy as np
from typing_extensions import override

from testbed.arrays import Quaternion, Vector3
from testbed.plant.additions import Addition

_FASTEST = 20.0
"""rad/s; a quadratic torque is exact below it. No rate of such a platform comes near it."""


@final
@dataclass(frozen=True, kw_only=True)
class RateTorque(Addition):
    """A torque -c ω on each body axis.

    Attributes:
        coefficient: c, shape (3,), N·m·s/rad.
    """

    coefficient: Vector3

    @override
    def write(self, spec: mujoco.MjSpec, name: str) -> None:
        """An actuator's bias is linear in its speed, which is that axis' body rate."""
        spec.body("bus").add_site(name=name)
        for axis, coefficient in _each_axis(self.coefficient):
            _axis_actuator(spec, name, axis, **_bias(speed=-coefficient))


@final
@dataclass(frozen=True, kw_only=True)
class QuadraticRateTorque(Addition):
    """A torque -k ω |ω| on each body axis, each with its own rate.

    Attributes:
        coefficient: k, shape (3,), N·m·s²/rad².
    """

    coefficient: Vector3

    @override
    def write(self, spec: mujoco.MjSpec, name: str) -> None:
        """A muscle's force is F (1 + 2 v - v |v|), v the speed as a share of the greatest; a bias takes off 1 + 2 v.

        It is held at the length at which its force is greatest, and, by the range of its control, at activation -1.
        """
        spec.body("bus").add_site(name=name)
        for axis, coefficient in _each_axis(self.coefficient):
            force = float(f"{coefficient * _FASTEST**2:.6g}")  # six digits are what a file keeps: bias and force agree
            _axis_actuator(
                spec,
                name,
                axis,
                **_bias(-force, speed=-2.0 * force / _FASTEST),
                gaintype=mujoco.mjtGain.mjGAIN_MUSCLE,
                # two lengths, force, scale, shortest, longest, greatest speed, passive force, most gained by speed
                gainprm=[0.5, 1.5, force, 1.0, 0.5, 1.5, _FASTEST, 1.0, 2.0, 0.0],
                lengthrange=[-0.5, 0.5],
                ctrllimited=True,
                ctrlrange=[-2.0, -1.0],
            )


@final
@dataclass(frozen=True, kw_only=True)
class BodyTorque(Addition):
    """A constant torque that turns with the body.

    Attributes:
        torque_B: shape (3,), N·m.
    """

    torque_B: Vector3

    @override
    def write(self, spec: mujoco.MjSpec, name: str) -> None:
        spec.body("bus").add_site(name=name)
        for axis, torque in _each_axis(self.torque_B):
            _axis_actuator(spec, name, axis, **_bias(torque))


@final
@dataclass(frozen=True, kw_only=True)
class InertialTorque(Addition):
    """A constant torque that does not turn with the body.

    Attributes:
        torque: shape (3,), N·m, along the axes below.
        quat_NA: the axes it is given in, constant in N.
    """

    torque: Vector3
    quat_NA: Quaternion

    @override
    def write(self, spec: mujoco.MjSpec, name: str) -> None:
        spec.body("bus").add_site(name=name)
        axes = spec.worldbody.add_site(name=f"{name}_axes", quat=self.quat_NA)
        for axis, torque in _each_axis(self.torque):
            _axis_actuator(spec, name, axis, **_bias(torque), refsite=axes.name)


@final
@dataclass(frozen=True, kw_only=True)
class Tether(Addition):
    """A torque -K θ - C ω on each body axis, θ the rotation vector from an attitude at rest to the present one.

    Attributes:
        stiffness: K, shape (3,), N·m/rad.
        damping: C, shape (3,), N·m·s/rad.
        quat_NB: attitude without torque.
    """

    stiffness: Vector3
    damping: Vector3
    quat_NB: Quaternion

    @override
    def write(self, spec: mujoco.MjSpec, name: str) -> None:
        """The actuator turns a site of N as seen from the bus: its length is -θ and its torque on the bus reversed."""
        spec.worldbody.add_site(name=name, quat=self.quat_NB)
        axes = spec.body("bus").add_site(name=f"{name}_axes")
        for (axis, stiffness), damping in zip(_each_axis(self.stiffness), self.damping, strict=True):
            _axis_actuator(spec, name, axis, **_bias(length=-stiffness, speed=-float(damping)), refsite=axes.name)


def _each_axis(values: Vector3) -> Iterable[tuple[int, float]]:
    return enumerate(map(float, values))


def _axis_actuator(spec: mujoco.MjSpec, site: str, axis: int, **more: Any) -> None:  # noqa: ANN401 - MjSpec's own settings
    gear = np.zeros(6)
    gear[3 + axis] = 1.0
    settings = {"gaintype": mujoco.mjtGain.mjGAIN_FIXED, "gainprm": [0.0] * 10} | more
    spec.add_actuator(
        name=f"{site}_{'xyz'[axis]}", trntype=mujoco.mjtTrn.mjTRN_SITE, target=site, gear=gear, **settings
    )


def _bias(constant: float = 0.0, *, length: float = 0.0, speed: float = 0.0) -> dict[str, Any]:
    return {"biastype": mujoco.mjtBias.mjBIAS_AFFINE, "biasprm": [constant, length, speed] + [0.0] * 7}
