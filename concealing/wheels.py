"""Reaction wheels on a rigid body that flies freely or stands on a ball joint under gravity: Hamilton's equations.

A wheel adds ½ Js (Ω + ω·a)² - ½ Js (ω·a)² to the kinetic energy, as J holds it as if it stood still in the body. Its
momentum is l = Js (Ω + ω·a), and ω solves

    [J - Σ Js a aᵀ] ω = L - Σ l a,    l̇ = τ - c Ω - d sign Ω,

with the motor's torque τ and the friction of its bearing; the body feels the opposite, as L = J ω + Σ Js Ω a changes by
outside torques alone. On a pivot J and L are about it, and gravity gives m g u × c, u upwards and c from the pivot to
the centre of mass.

A motor holds the torque that its current shows, and gives a factor of that; a late one follows its command by
T i̇ = u - i. A rotor whose mass lies U e(φ) beside its axis, φ̇ = Ω, adds U Ω (ω × r)·e' to the kinetic energy, e' a
quarter turn ahead of e. Then U r × e' stands beside Js a in L and l, and l̇ has - U Ω ω·(r × e) beside it. What is a
thousandth of that is left out: terms in ω² U, and gravity on U.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import ClassVar, NamedTuple

import numpy as np

from concealing.craft import SIGN_WIDTH, Array, Craft, PlatformNumbers, cross, nominal_craft
from concealing.inner_effects import point_inertia
from concealing.mechanics import Mechanics, Velocities


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
        position: of the rotors from the centre of mass, (W, 3), m, body axes.
        torque_factor: torque of the motors over what their currents show, (W,).
        lag: time constant of the currents behind the commands, (W,), s.
        imbalance: mass of a rotor times the distance of its centre from the axis, (W,), kg·m.
        late: how long after their commands all motors answer, s.
    """

    axis: Array
    spin_inertia: Array
    torque_limit: Array
    viscous: Array
    coulomb: Array
    speed_bias: Array
    position: Array
    torque_factor: Array
    lag: Array
    imbalance: Array
    late: float


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


def horizontal_axis(axis: Array) -> Array:
    """Return the unit vectors along z × a, or x where a stands along z, (W, 3)."""
    across = np.stack([-axis[:, 1], axis[:, 0], np.zeros(len(axis))], axis=1)
    length = np.linalg.norm(across, axis=1, keepdims=True)
    return np.where(length < 1e-8, [1.0, 0.0, 0.0], across / np.maximum(length, 1e-8))


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
        asked: torque that each motor is to give, within its limit, (B, W), N·m.
        current: that its current shows at the period's start, (B, W), N·m.
        since: the period's start, s.
    """

    asked: Array
    current: Array
    since: float


_TRANSIENT = 16.0
"""Time constants after which a current differs from what was asked for by 1e-7 of the step that it followed."""


@dataclass(frozen=True, kw_only=True)
class WheelMechanics(Mechanics):
    """The equations of motion of a craft with wheels, for B runs side by side; a state is (B, n).

    Attributes:
        craft: what flies.
        wheel_speed: relative to the body at release, (B, W), rad/s.
        wheel_angle: then, of what is out of balance, from the direction normal to its axis that
            `horizontal_axis` gives, (B, W), rad.
    """

    slowest: ClassVar[float] = 20.0
    craft: WheelCraft
    wheel_speed: Array = field(kw_only=True)
    wheel_angle: Array = field(kw_only=True)

    @cached_property
    def slices(self) -> dict[str, slice]:
        """Where each quantity stands in a state: `wheel` holds l, and `turned` φ where it matters."""
        others, count = Mechanics.slices.func(self), len(self.craft.wheels.spin_inertia)
        end = max(part.stop for part in others.values())
        turned = slice(end + count, end + count * (1 + self._is_unbalanced))
        return others | {"wheel": slice(end, end + count), "turned": turned}

    @cached_property
    def fastest(self) -> float:
        """Fastest rate of any motion here, 1/s, for the integrator's step."""
        return float(max([self.calm, *(1.0 / self._lags)]))

    @cached_property
    def calm(self) -> float:
        """Fastest rate of what goes on when the currents are what was asked for, 1/s."""
        wheels = self.craft.wheels
        rates = [Mechanics.fastest.func(self), *(wheels.coulomb / SIGN_WIDTH / wheels.spin_inertia)]
        if self._is_unbalanced:
            rates.append(2.0 * float(np.abs(self.wheel_speed).max()))
        return float(max(rates))

    @cached_property
    def restless(self) -> float:
        """How long after a tick currents still change, s."""
        return _TRANSIENT * float(self._lags.max(initial=0.0)) or np.inf

    @property
    def _lags(self) -> Array:
        return self.craft.wheels.lag[self.craft.wheels.lag > 0.0]

    def start(self, body_rate: Array, gimbal_angle: Array) -> Array:
        """Return the state at release, (B, n); arguments as in `Mechanics`, without gimbals."""
        wheels = self.craft.wheels
        state = super().start(body_rate, gimbal_angle)
        held = wheels.spin_inertia * (self.wheel_speed + body_rate @ wheels.axis.T)
        momentum_B = held @ wheels.axis
        if self._is_unbalanced:
            state[:, self.slices["turned"]] = self.wheel_angle
            beside = self._beside(state)
            held = held + np.einsum("bwi,bi->bw", beside, body_rate)
            momentum_B = momentum_B + np.einsum("bw,bwi->bi", self.wheel_speed, beside)
        state[:, self.slices["wheel"]] = held
        state[:, self.slices["momentum"]] += np.einsum("bij,bj->bi", self.release_attitude, momentum_B)
        return state

    def speeds(self, time: float, state: Array) -> Array:
        """Return Ω, the wheels' speeds relative to the body, (B, W), rad/s."""
        return self._speeds(state, self.velocities(time, state).body_rate)

    def current(self, time: float, inputs: WheelInputs) -> Array:
        """Return what the motors' currents show at a time in a control period, (B, W), N·m: T i̇ = u - i."""
        lag = self.craft.wheels.lag
        if not self._lags.size:
            return inputs.asked
        left = np.exp(-(time - inputs.since) / np.where(lag > 0.0, lag, np.inf)) * (lag > 0.0)
        return inputs.asked + left * (inputs.current - inputs.asked)

    @cached_property
    def _is_unbalanced(self) -> bool:
        return bool(np.any(self.craft.wheels.imbalance))

    @cached_property
    def _fixed(self) -> Array:
        wheels = self.craft.wheels
        turning = np.einsum("w,wi,wj->ij", wheels.spin_inertia, wheels.axis, wheels.axis)
        return self.craft.turned_inertia - turning

    @cached_property
    def _inverse(self) -> Array:
        return np.linalg.inv(self._fixed)

    def _velocities(self, time: float, state: Array, axes: object, imbalance: object) -> Velocities:  # noqa: ARG002
        attitude = state[:, self.slices["attitude"]].reshape(-1, 3, 3)
        momentum_B = (state[:, self.slices["momentum"]][:, None, :] @ attitude)[:, 0]
        if not (self.craft.attachments or self._is_unbalanced):  # nothing changes what turns with the body
            body_rate = (momentum_B - state[:, self.slices["wheel"]] @ self.craft.wheels.axis) @ self._inverse
            return Velocities(body_rate, body_rate[:, :0], body_rate[:, :0])
        turning = self._matrix(time, axes) - self._loosened(state)
        body_rate = np.linalg.solve(turning, (momentum_B - self._carried(time, state, axes))[..., None])[..., 0]
        return Velocities(body_rate, body_rate[:, :0], body_rate[:, :0])

    def _turn_units(
        self,
        time: float,
        state: Array,
        change: Array,
        inputs: WheelInputs,
        axes: object,  # noqa: ARG002 - the base's signature
        velocities: Velocities,
    ) -> None:
        """Write l̇ and φ̇."""
        wheels, speed = self.craft.wheels, self._speeds(state, velocities.body_rate)
        friction = wheels.viscous * speed + wheels.coulomb * np.tanh(speed / SIGN_WIDTH)
        change[:, self.slices["wheel"]] = wheels.torque_factor * self.current(time, inputs) - friction
        if self._is_unbalanced:
            change[:, self.slices["turned"]] = speed
            behind = self._beside(state, ahead=0.0)
            change[:, self.slices["wheel"]] -= speed * np.einsum("bwi,bi->bw", behind, velocities.body_rate)

    def _carried(self, time: float, state: Array, axes: object) -> Array:
        held = state[:, self.slices["wheel"]]
        carried = super()._carried(time, state, axes) + held @ self.craft.wheels.axis
        if self._is_unbalanced:
            carried = carried + np.einsum("bw,bwi->bi", held / self.craft.wheels.spin_inertia, self._beside(state))
        return carried

    def _speeds(self, state: Array, body_rate: Array) -> Array:
        wheels = self.craft.wheels
        held = state[:, self.slices["wheel"]]
        if self._is_unbalanced:
            held = held - np.einsum("bwi,bi->bw", self._beside(state), body_rate)
        return held / wheels.spin_inertia - body_rate @ wheels.axis.T

    def _beside(self, state: Array, ahead: float = 0.5 * np.pi) -> Array:
        """Return U r × e', (B, W, 3), kg·m², or that of the direction which is so much ahead of e, rad."""
        wheels, turn = self.craft.wheels, (state[:, self.slices["turned"]] + ahead)[..., None]
        first, second = self._across
        direction = np.cos(turn) * first + np.sin(turn) * second
        return cross(wheels.imbalance[:, None] * wheels.position, direction)

    @cached_property
    def _across(self) -> tuple[Array, Array]:
        """Directions from which each rotor's angle counts, and a quarter turn on, (W, 3) each."""
        first = horizontal_axis(self.craft.wheels.axis)
        return first, cross(self.craft.wheels.axis, first)

    def _loosened(self, state: Array) -> Array | float:
        """Return what of Σ (Js a + U r × e') (Js a + U r × e')ᵀ / Js is not Σ Js a aᵀ, (B, 3, 3), kg·m²."""
        if not self._is_unbalanced:
            return 0.0
        wheels, beside = self.craft.wheels, self._beside(state)
        mixed = np.einsum("wi,bwj->bij", wheels.axis, beside)
        return mixed + np.swapaxes(mixed, 1, 2) + np.einsum("bwi,bwj,w->bij", beside, beside, 1.0 / wheels.spin_inertia)

    def _external(self, time: float, state: Array, attitude: Array, body_rate: Array) -> Array | None:
        others = super()._external(time, state, attitude, body_rate)
        if self.craft.pivot is None:
            return others
        up = attitude[:, 2, :]
        weight = cross(up, np.broadcast_to(self.craft.weight_arm, up.shape))
        return weight if others is None else others + weight
