"""Reaction wheels on a rigid body that flies freely or stands on a ball joint under gravity: Hamilton's equations.

A wheel adds ½ Js (Ω + ω·a)² - ½ Js (ω·a)² to the kinetic energy, as J holds it as if it stood still in the body. Its
momentum is l = Js (Ω + ω·a), and ω solves

    [J - Σ Js a aᵀ] ω = L - Σ l a,    l̇ = τ - c Ω - d sign Ω,

with the motor's torque τ and the friction of its bearing; the body feels the opposite, as L = J ω + Σ Js Ω a changes by
outside torques alone. On a pivot J and L are about it, and gravity gives m g u × c, u upwards and c from the pivot to
the centre of mass.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import ClassVar, NamedTuple

import numpy as np

from concealing.craft import SIGN_WIDTH, Array, Craft, PlatformNumbers, nominal_craft
from concealing.inner_effects import point_inertia
from concealing.mechanics import Mechanics, Velocities
from concealing.nominal import cross


@dataclass(frozen=True, kw_only=True)
class Wheels:
    """W reaction wheels.

    Attributes:
        axis: (W, 3), unit vectors, body axes.
        spin_inertia: (W,), kg·m².
        torque_limit: of the motors, (W,), N·m.
        viscous: friction, (W,), N·m·s/rad.
        coulomb: dry friction, (W,), N·m.
        speed_bias: shown less true speed, (W,), rad/s.
    """

    axis: Array
    spin_inertia: Array
    torque_limit: Array
    viscous: Array
    coulomb: Array
    speed_bias: Array


@dataclass(frozen=True, kw_only=True)
class Pivot:
    """A ball joint under gravity, which acts along -z of inertial axes.

    Attributes:
        offset: from the joint to the centre of mass, (3,), m, body axes.
        gravity: m/s².
    """

    offset: Array
    gravity: float


@dataclass(frozen=True, kw_only=True)
class WheelCraft(Craft):
    """A craft without gimbals that wheels turn.

    Attributes:
        wheels: as they are.
        pivot: None of a craft that flies freely.
    """

    wheels: Wheels
    pivot: Pivot | None = None

    @property
    def weight_arm(self) -> Array:
        """m g c, (3,), N·m, body axes."""
        return self.mass * self.pivot.gravity * self.pivot.offset

    @property
    def turned_inertia(self) -> Array:
        """Inertia about the point that the craft turns about, (3, 3), kg·m²; `inertia` is about the centre of mass."""
        return self.inertia if self.pivot is None else self.inertia + point_inertia(self.mass, self.pivot.offset)


def wheel_craft(inertia: Array, mass: float, wheels: Wheels, pivot: Pivot | None) -> WheelCraft:
    """Return a craft without any effect.

    Args:
        inertia: of all of it, wheels locked, about the centre of mass, (3, 3), kg·m².
        mass: kg.
        wheels: as drawn.
        pivot: where it has one.
    """
    bare = nominal_craft(PlatformNumbers(inertia, mass, 0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0))
    return WheelCraft(**vars(bare), wheels=wheels, pivot=pivot)


class WheelInputs(NamedTuple):
    """What is held through one control period.

    Attributes:
        wheel_torque: of each motor, (B, W), N·m.
    """

    wheel_torque: Array


@dataclass(frozen=True, kw_only=True)
class WheelMechanics(Mechanics):
    """The equations of motion of a craft with wheels, for B runs side by side; a state is (B, n).

    Attributes:
        craft: what flies.
        wheel_speed: relative to the body at release, (B, W), rad/s.
    """

    slowest: ClassVar[float] = 20.0
    craft: WheelCraft
    wheel_speed: Array = field(kw_only=True)

    @cached_property
    def slices(self) -> dict[str, slice]:
        """Where each quantity stands in a state: `wheel` holds l."""
        others = Mechanics.slices.func(self)
        end = max(part.stop for part in others.values())
        return others | {"wheel": slice(end, end + len(self.craft.wheels.spin_inertia))}

    def start(self, body_rate: Array, gimbal_angle: Array) -> Array:
        """Return the state at release, (B, n); arguments as in `Mechanics`, without gimbals."""
        wheels = self.craft.wheels
        state = super().start(body_rate, gimbal_angle)
        held = wheels.spin_inertia * (self.wheel_speed + body_rate @ wheels.axis.T)
        state[:, self.slices["wheel"]] = held
        state[:, self.slices["momentum"]] += np.einsum("bij,bj->bi", self.release_attitude, held @ wheels.axis)
        return state

    def speeds(self, time: float, state: Array) -> Array:
        """Return Ω, the wheels' speeds relative to the body, (B, W), rad/s."""
        return self._speeds(state, self.velocities(time, state).body_rate)

    @cached_property
    def _fixed(self) -> Array:
        wheels = self.craft.wheels
        turning = np.einsum("w,wi,wj->ij", wheels.spin_inertia, wheels.axis, wheels.axis)
        return self.craft.turned_inertia - turning

    @cached_property
    def _inverse(self) -> Array:
        return np.linalg.inv(self._fixed)

    def _velocities(self, time: float, state: Array, axes: object, imbalance: object) -> Velocities:
        if self.craft.attachments:  # they change what turns with the body
            return super()._velocities(time, state, axes, imbalance)
        attitude = state[:, self.slices["attitude"]].reshape(-1, 3, 3)
        momentum_B = (state[:, self.slices["momentum"]][:, None, :] @ attitude)[:, 0]
        body_rate = (momentum_B - state[:, self.slices["wheel"]] @ self.craft.wheels.axis) @ self._inverse
        return Velocities(body_rate, body_rate[:, :0], body_rate[:, :0])

    def _turn_units(
        self,
        time: float,  # noqa: ARG002 - the base's signature
        state: Array,
        change: Array,
        inputs: WheelInputs,
        axes: object,  # noqa: ARG002
        velocities: Velocities,
    ) -> None:
        """Write l̇."""
        wheels, speed = self.craft.wheels, self._speeds(state, velocities.body_rate)
        friction = wheels.viscous * speed + wheels.coulomb * np.tanh(speed / SIGN_WIDTH)
        change[:, self.slices["wheel"]] = inputs.wheel_torque - friction

    def _carried(self, time: float, state: Array, axes: object) -> Array:
        return super()._carried(time, state, axes) + state[:, self.slices["wheel"]] @ self.craft.wheels.axis

    def _speeds(self, state: Array, body_rate: Array) -> Array:
        wheels = self.craft.wheels
        return state[:, self.slices["wheel"]] / wheels.spin_inertia - body_rate @ wheels.axis.T

    def _external(self, time: float, state: Array, attitude: Array, body_rate: Array) -> Array | None:
        others = super()._external(time, state, attitude, body_rate)
        if self.craft.pivot is None:
            return others
        up = attitude[:, 2, :]
        weight = cross(up, np.broadcast_to(self.craft.weight_arm, up.shape))
        return weight if others is None else others + weight
