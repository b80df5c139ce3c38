"""Equations of motion from Hamilton's principle, with momenta as states.

T = ½ ωᵀJ(d)ω + Σ [½ Ig (ḋ + ω·g)² - ½ Ig (ω·g)² + ½ Js (Ω + ω·s)² - ½ Js (ω·s)²],

with J(d) = J_fixed + Σ (Js - Jt) s sᵀ and Ig = Jg + Jt, has the momenta

    L = ∂T/∂ω,   p = ∂T/∂ḋ = Ig (ḋ + ω·g),   l = ∂T/∂Ω = Js (Ω + ω·s),

and in them ω solves the symmetric 3 × 3 system

    [J_fixed - Σ Ig g gᵀ - Σ Jt s sᵀ] ω = L - Σ p g - Σ l s.

The states are the attitude as a rotation matrix, the whole momentum in inertial axes (which only external torques
change, L̇_N = R T), p, d and l of each unit with

    ṗ = τ + ∂T/∂d = τ + (ω·t)(l - Jt ω·s),   ḋ = p / Ig - ω·g,   l̇ = servo torque,

the motors' own lag, the gyro's low-pass and whatever is attached. Rotor imbalances add the linear terms
Ω [Jd (ω + ḋ g)·e + U (ω × r)·e'] to T, e the rotor's direction of imbalance at its speed, e' a quarter turn ahead.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar, NamedTuple

import numpy as np

from concealing.craft import ROTOR_SERVO_RATE, SIGN_WIDTH, Array, Craft, Motion, cross


class Inputs(NamedTuple):
    """What is held through one control period.

    Attributes:
        gimbal_torque: demand on each motor before its tachometer loop and limit, (B, M), N·m.
    """

    gimbal_torque: Array


class Velocities(NamedTuple):
    """What the momenta say; leading axes as the states'.

    Attributes:
        body_rate: (..., 3), rad/s.
        gimbal_rate: (..., M), rad/s.
        rotor_speed: relative to the gimbal, (..., M), rad/s.
    """

    body_rate: Array
    gimbal_rate: Array
    rotor_speed: Array


class _Axes(NamedTuple):
    spin: Array
    transverse: Array


class _Imbalance(NamedTuple):
    momentum: Array
    gimbal: Array
    gimbal_torque: Array


@dataclass(frozen=True, kw_only=True)
class Mechanics:
    """The equations of motion of a craft, for B runs side by side; a state is (B, n).

    Attributes:
        craft: what flies.
        epoch: (B,), s.
        release_attitude: (B, 3, 3).
        applied: torque asked of actuators that store no momentum, a function of time, (B, 3), N·m; None for none.
        slowest: rate up to which the integrator's steps resolve whatever happens, 1/s.
        restless: how long after a tick something may change at `fastest`, s; after that at `calm`.
    """

    slowest: ClassVar[float] = 100.0
    restless: ClassVar[float] = np.inf
    craft: Craft
    epoch: Array
    release_attitude: Array
    applied: Callable[[float], Array] | None = None

    @cached_property
    def count(self) -> int:
        """Number of units."""
        return len(self.craft.units.spin_inertia)

    @cached_property
    def slices(self) -> dict[str, slice]:
        """Where each quantity stands in a state."""
        widths = {
            "attitude": 9,
            "momentum": 3,
            **dict.fromkeys(("p", "angle", "l", "motor"), self.count),
            "lowpass": 3,
            "applied": 3,
            **{f"attachment{index}": item.width for index, item in enumerate(self.craft.attachments)},
        }
        ends = np.cumsum(list(widths.values()))
        return {name: slice(end - width, end) for (name, width), end in zip(widths.items(), ends, strict=True)}

    @cached_property
    def fastest(self) -> float:
        """Fastest rate of any motion here, 1/s, for the integrator's step."""
        units, rates = self.craft.units, [self.slowest]
        if self.count:
            friction = (units.coulomb + units.stribeck) / SIGN_WIDTH + units.viscous + units.rate_gain
            rates += [ROTOR_SERVO_RATE, *(friction / units.turning_inertia), *(1.0 / units.lag[units.lag > 0.0])]
            if np.any(units.static_imbalance) or np.any(units.dynamic_imbalance):
                rates.append(2.0 * float(np.abs(units.rotor_speed).max()))
        rates += [item.fastest for item in self.craft.attachments]
        if self.craft.applied.lag > 0.0:
            rates.append(1.0 / self.craft.applied.lag)
        if self.craft.gyro.bandwidth < np.inf:
            rates.append(2.0 * np.pi * self.craft.gyro.bandwidth)
        return float(max(rates))

    @cached_property
    def calm(self) -> float:
        """Fastest rate of what goes on for longer than `restless` after a tick, 1/s."""
        return self.fastest

    def start(self, body_rate: Array, gimbal_angle: Array) -> Array:
        """Return the state at release: gimbals at rest, rotors at speed, (B, n).

        Args:
            body_rate: (B, 3), rad/s.
            gimbal_angle: (B, M), rad.
        """
        units, runs = self.craft.units, len(body_rate)
        state = np.zeros((runs, max(part.stop for part in self.slices.values())))
        axes = self._axes(gimbal_angle)
        state[:, self.slices["attitude"]] = self.release_attitude.reshape(runs, 9)
        state[:, self.slices["angle"]] = gimbal_angle
        state[:, self.slices["lowpass"]] = body_rate
        imbalance = self._imbalance(0.0, axes)
        state[:, self.slices["p"]] = units.turning_inertia * (body_rate @ units.gimbal_axis.T)
        state[:, self.slices["l"]] = units.spin_inertia * (
            units.rotor_speed + np.einsum("bi,bmi->bm", body_rate, axes.spin)
        )
        if imbalance is not None:
            state[:, self.slices["p"]] += imbalance.gimbal
        for index, item in enumerate(self.craft.attachments):
            state[:, self.slices[f"attachment{index}"]] = item.start(body_rate)
        momentum_B = np.einsum("bij,bj->bi", self._matrix(0.0, axes), body_rate) + self._carried(0.0, state, axes)
        state[:, self.slices["momentum"]] = np.einsum("bij,bj->bi", self.release_attitude, momentum_B)
        return state

    def velocities(self, time: float, state: Array) -> Velocities:
        """Return the rates at a state, (B, n)."""
        axes = self._axes(state[:, self.slices["angle"]])
        imbalance = self._imbalance(time, axes)
        return self._velocities(time, state, axes, imbalance)

    def motor_torque(self, state: Array, gimbal_rate: Array, demand: Array) -> Array:
        """Return the torque of the gimbal motors, (B, M), N·m."""
        units = self.craft.units
        if np.any(units.lag):
            demand = np.where(units.lag > 0.0, state[:, self.slices["motor"]], demand)
        limit = units.torque_limit
        return np.minimum(np.maximum(demand - units.rate_gain * gimbal_rate, -limit), limit)

    def shown_speed(self, time: float, rotor_speed: Array) -> Array:
        """Return what noise-free tachometers show, (B, M), rad/s: scale and drift are what the speed servos trust."""
        return rotor_speed / self.craft.tachometer_scale * np.exp(self.craft.units.spin_down * time)

    def derivative(self, time: float, state: Array, inputs: Inputs) -> Array:
        """Return the rate of change of a state, (B, n)."""
        at = self.slices
        axes = self._axes(state[:, at["angle"]])
        imbalance = self._imbalance(time, axes)
        velocities = self._velocities(time, state, axes, imbalance)
        body_rate = velocities.body_rate
        change = np.zeros_like(state)
        attitude = state[:, at["attitude"]].reshape(-1, 3, 3)
        change[:, at["attitude"]] = (attitude @ _cross_matrices(body_rate)).reshape(-1, 9)
        torque_B = self._external(time, state, attitude, body_rate)
        if torque_B is not None:
            change[:, at["momentum"]] = (attitude @ torque_B[..., None])[..., 0]
        self._turn_units(time, state, change, inputs, axes, velocities)
        if imbalance is not None:
            change[:, at["p"]] += np.einsum("bmi,bi->bm", imbalance.gimbal_torque, body_rate)
        self._follow_behind(time, state, change, inputs, body_rate)
        for index, item in enumerate(self.craft.attachments):
            part = at[f"attachment{index}"]
            change[:, part] = item.derivative(time, state[:, part], body_rate)
        return change

    def _turn_units(
        self, time: float, state: Array, change: Array, inputs: Inputs, axes: _Axes, velocities: Velocities
    ) -> None:
        """Write ḋ, ṗ and l̇."""
        if not self.count:
            return
        units, at = self.craft.units, self.slices
        change[:, at["angle"]] = velocities.gimbal_rate
        change[:, at["p"]] = self._gimbal_torque(state, inputs, velocities.gimbal_rate)
        change[:, at["p"]] += self._gyroscopic(state, axes, velocities.body_rate)
        target = units.rotor_speed * np.exp(-units.spin_down * time)
        change[:, at["l"]] = units.spin_inertia * ROTOR_SERVO_RATE * (target - velocities.rotor_speed)

    def _follow_behind(self, time: float, state: Array, change: Array, inputs: Inputs, body_rate: Array) -> None:
        """Write what follows as a first-order lag: motors, the gyro's low-pass, applied torques."""
        craft, at = self.craft, self.slices
        if np.any(craft.units.lag):
            lag = np.where(craft.units.lag > 0.0, craft.units.lag, 1.0)
            change[:, at["motor"]] = (inputs.gimbal_torque - state[:, at["motor"]]) / lag
        if craft.gyro.bandwidth < np.inf:
            change[:, at["lowpass"]] = 2.0 * np.pi * craft.gyro.bandwidth * (body_rate - state[:, at["lowpass"]])
        if self.applied is not None and craft.applied.lag > 0.0:
            asked = self.applied(time - craft.applied.delay)
            change[:, at["applied"]] = (asked - state[:, at["applied"]]) / craft.applied.lag

    @cached_property
    def _fixed(self) -> Array:
        units = self.craft.units
        change = units.spin_inertia - units.transverse_inertia
        return (
            self.craft.inertia
            - np.einsum("m,mi,mj->ij", change, units.spin_axis, units.spin_axis)
            - np.einsum("m,mi,mj->ij", units.turning_inertia, units.gimbal_axis, units.gimbal_axis)
        )

    @cached_property
    def _transverse_axis(self) -> Array:
        return self.craft.units.transverse_axis

    @cached_property
    def _is_imbalanced(self) -> bool:
        units = self.craft.units
        return bool(np.any(units.static_imbalance) or np.any(units.dynamic_imbalance))

    @cached_property
    def _is_dry(self) -> bool:
        return bool(np.any(self.craft.units.coulomb) or np.any(self.craft.units.stribeck))

    def _axes(self, angle: Array) -> _Axes:
        cos, sin = np.cos(angle)[..., None], np.sin(angle)[..., None]
        spin, transverse = self.craft.units.spin_axis, self._transverse_axis
        return _Axes(spin * cos + transverse * sin, transverse * cos - spin * sin)

    def _matrix(self, time: float, axes: _Axes) -> Array:
        """J_fixed - Σ Ig g gᵀ - Σ Jt s sᵀ, less what attachments do not let turn with the body."""
        weighted = axes.spin * self.craft.units.transverse_inertia[:, None]
        matrix = self._fixed - np.swapaxes(weighted, -1, -2) @ axes.spin
        for item in self.craft.attachments:
            matrix = matrix - item.released_inertia(time, self.epoch)
        return matrix

    def _carried(self, time: float, state: Array, axes: _Axes) -> Array:
        """Σ p g + Σ l s, and what attachments carry, (B, 3)."""
        at = self.slices
        carried = state[:, at["p"]] @ self.craft.units.gimbal_axis
        carried = carried + (state[:, at["l"]][:, None, :] @ axes.spin)[:, 0]
        for index, item in enumerate(self.craft.attachments):
            carried = carried + item.momentum(time, self.epoch, state[:, at[f"attachment{index}"]])
        imbalance = self._imbalance(time, axes)
        if imbalance is not None:
            carried = carried + imbalance.momentum - imbalance.gimbal @ self.craft.units.gimbal_axis
        return carried

    def _velocities(self, time: float, state: Array, axes: _Axes, imbalance: _Imbalance | None) -> Velocities:
        units, at = self.craft.units, self.slices
        attitude = state[:, at["attitude"]].reshape(-1, 3, 3)
        momentum_B = (state[:, at["momentum"]][:, None, :] @ attitude)[:, 0]
        body_rate = np.linalg.solve(
            self._matrix(time, axes), (momentum_B - self._carried(time, state, axes))[..., None]
        )[..., 0]
        turned = state[:, at["p"]] if imbalance is None else state[:, at["p"]] - imbalance.gimbal
        gimbal_rate = turned / units.turning_inertia - body_rate @ units.gimbal_axis.T
        along_spin = (axes.spin @ body_rate[..., None])[..., 0]
        rotor_speed = state[:, at["l"]] / units.spin_inertia - along_spin
        return Velocities(body_rate, gimbal_rate, rotor_speed)

    def _gyroscopic(self, state: Array, axes: _Axes, body_rate: Array) -> Array:
        """∂T/∂d = (ω·t)(l - Jt ω·s), (B, M)."""
        column = body_rate[..., None]
        along_spin, along_transverse = (axes.spin @ column)[..., 0], (axes.transverse @ column)[..., 0]
        return along_transverse * (state[:, self.slices["l"]] - self.craft.units.transverse_inertia * along_spin)

    def _gimbal_torque(self, state: Array, inputs: Inputs, gimbal_rate: Array) -> Array:
        """Motor and friction about each gimbal axis; the body feels the opposite, as L does not change."""
        units = self.craft.units
        torque = self.motor_torque(state, gimbal_rate, inputs.gimbal_torque) - units.viscous * gimbal_rate
        if self._is_dry:
            level = units.coulomb + units.stribeck * np.exp(-((gimbal_rate / units.stribeck_rate) ** 2))
            torque = torque - level * np.tanh(gimbal_rate / SIGN_WIDTH)
        return torque

    def _external(self, time: float, state: Array, attitude: Array, body_rate: Array) -> Array | None:
        parts = []
        if self.craft.torques:
            motion = Motion(time, self.epoch, attitude, self.release_attitude, body_rate)
            parts = [torque(motion) for torque in self.craft.torques]
        if self.applied is not None:
            lagged = self.craft.applied.lag > 0.0
            parts.append(state[:, self.slices["applied"]] if lagged else self.applied(time - self.craft.applied.delay))
        return sum(parts) if parts else None

    def _imbalance(self, time: float, axes: _Axes) -> _Imbalance | None:
        """Momenta of the imbalances and their torques on the gimbals; e = t cos φ + g sin φ."""
        if not self._is_imbalanced:
            return None
        units = self.craft.units
        phase = units.imbalance_phase + units.rotor_speed * (self.epoch[:, None] + time)
        cos, sin = np.cos(phase)[..., None], np.sin(phase)[..., None]
        ahead = units.gimbal_axis * cos - axes.transverse * sin
        dynamic = (units.dynamic_imbalance * units.rotor_speed)[:, None]
        static = (units.static_imbalance * units.rotor_speed)[:, None]
        momentum = dynamic * (axes.transverse * cos + units.gimbal_axis * sin) + static * cross(units.position, ahead)
        # ∂t/∂d = -s turns e by -s cos φ and e' by +s sin φ.
        turning = -dynamic * cos * axes.spin + static * cross(units.position, sin * axes.spin)
        return _Imbalance(momentum=momentum.sum(axis=1), gimbal=(dynamic * sin)[..., 0], gimbal_torque=turning)


def _cross_matrices(vector: Array) -> Array:
    """Return [v ×], (B, 3, 3)."""
    matrix = np.zeros((len(vector), 3, 3))
    matrix[:, 2, 1] = vector[:, 0]
    matrix[:, 0, 2] = vector[:, 1]
    matrix[:, 1, 0] = vector[:, 2]
    matrix[:, 1, 2], matrix[:, 2, 0], matrix[:, 0, 1] = -vector[:, 0], -vector[:, 1], -vector[:, 2]
    return matrix
