"""Flights as paths of all gimbals and wheels, and how much of their limits these take, for many paths at once."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import final

import numpy as np

from testbed.arrays import Array, Flags, Quaternion, Units, Vector3
from testbed.assembly.maneuver import gimbal_limits
from testbed.assembly.platform import (
    PlatformModel,
    first_gimbal_angle,
    first_wheel_momentum,
    initial_momentum,
    platform_actuators,
)
from testbed.cmg.actuators import Actuators, dexterity
from testbed.cmg.cluster import cluster_momentum, momentum_jacobian
from testbed.cmg.singularity import envelope_fraction
from testbed.cmg.wheels import wheel_momentum
from testbed.dynamics.environment import Orbiting
from testbed.maneuver.design import GimbalLimits
from testbed.maneuver.splines import basis_matrix, clamped_spline, derivative_points_matrix
from testbed.next_experiment.flight import NextFlight, Release
from testbed.next_experiment.following import brought_to
from testbed.next_experiment.space import (
    BIAS,
    CONTROL_POINTS,
    FARTHEST,
    SPHERE,
    TURNS,
    flight_duration,
    motion_section,
    path_through,
    release_spin,
)
from testbed.scenario.scenario import Scenario

_CHECKS = 60
"""Instants at which what is not linear in the control points is kept, as many as the designer checks in 5 s."""
_DIAGONALS = np.array([[1.0, 1.0, 1.0], [1.0, 1.0, -1.0], [1.0, -1.0, 1.0], [-1.0, 1.0, 1.0]]) / np.sqrt(3.0)
"""Of a cube, up to their sign: spins that have all three rates at once, which products of rates need."""
_WHOLE = 1.0
"""Share of its momentum limit that a wheel gains on its way; the limits make it less."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class ActuatorSpace:
    """Paths of gimbals, in rad, and wheels, in shares of their momentum limits.

    Attributes:
        limits: margins taken off.
        platform: the nominal one. A unit whose rotor carries no momentum has failed and stays where it is.
        actuators: its gyros and wheels.
        duration: s.
        first: what gimbals, rad, and wheels, N·m·s, start from, shape (M + W,).
        attitude: quat_NB at release.
        kept_momentum_B: the total momentum that every release has, N·m·s, body axes, where nothing can give the
            platform another one, as on orbit; None where it is released by hand or by a launcher.
        first_rate: ω of a release with that momentum and the first motion, rad/s.
    """

    limits: GimbalLimits
    platform: PlatformModel
    actuators: Actuators
    duration: float
    first: Units
    attitude: Quaternion
    kept_momentum_B: Vector3 | None
    first_rate: Vector3

    @property
    def scale(self) -> Array:
        """Unit of each column's moves, shape (M + W,): rad and N·m·s."""
        return self.actuators.move_scale

    @property
    def free(self) -> Flags:
        """Which columns may move, shape (M + W,)."""
        return np.concatenate([self.platform.cluster.rotor_momentum != 0.0, self.platform.wheels.momentum_limit > 0.0])

    def releases(self) -> Iterator[Release]:
        """Yield releases at rest, with a spin and with a momentum bias; where the momentum is kept, spins it allows."""
        still = np.zeros(3)
        spins = release_spin(self.platform) * np.concatenate([np.eye(3), _DIAGONALS])
        if self.kept_momentum_B is not None:
            yield Release(self.first_rate, self.first)
            for spin in spins:
                rest_B = self.kept_momentum_B - self.platform.inertia @ spin
                yield Release(spin, brought_to(self.actuators, self.first, rest_B))
            return
        yield Release(still, self.first)
        for spin in spins:
            yield Release(spin, self.first)
        for axis in np.eye(3):
            turns = np.linalg.pinv(self._jacobian) @ axis
            yield Release(still, self.first + self.scale * (BIAS * turns / np.abs(turns).max()))

    def paths(self, rng: np.random.Generator) -> list[Array]:
        """Return paths of any motion, and as many that leave out null motion, which moves nothing but the actuators."""
        moving = np.linalg.pinv(self._jacobian) @ self._jacobian
        reach = np.where(np.arange(self.actuators.count) < self.actuators.units, 1.0, _WHOLE / FARTHEST)
        drawn = [reach * rng.uniform(-FARTHEST, FARTHEST, (turns, self.actuators.count)) for turns in TURNS]
        without_null = [each @ moving for each in drawn] if self.actuators.count > len(np.eye(3)) else []
        return [self.free * path_through(turns, CONTROL_POINTS - 3) for turns in (*drawn, *without_null)]

    def points(self, release: Release, moves: Array) -> Array:
        """Return control points that start from a release's motion and at rest, and end at rest, (..., n, M + W)."""
        still = np.zeros((*moves.shape[:-2], 2, moves.shape[-1]))
        return np.asarray(release.motion + self.scale * np.concatenate([still, moves, moves[..., -1:, :]], axis=-2))

    def moves(self, flight: NextFlight) -> Array:
        """Return the free control points less the first ones, shape (n - 3, M + W), rad and shares."""
        return np.asarray((flight.control_points[2:-1] - flight.release.motion) / self.scale)

    def flights(self, release: Release, points: Array) -> list[NextFlight]:
        """Return the flights of paths, shape (F, n, M + W)."""
        return [
            NextFlight(
                body_rate=release.body_rate,
                attitude=self.attitude,
                path="actuator" if len(self.platform.wheels.spin_inertia) else "gimbal",
                control_points=each,
                duration=self.duration,
                motion=clamped_spline(self.duration, each),
                units=self.actuators.units,
            )
            for each in points
        ]

    def shares(self, release: Release, points: Array) -> Array:
        """Return shares of limits, each at most 1 where a path keeps them, shape (F, L).

        Gimbal rate and acceleration, momentum and torque of each wheel by the convex hull; envelope, momentum, torque
        and singularity measure at instants; body rate, gimbal torque and what the turning body asks of the wheels'
        motors by bounds that hold whatever way the total momentum turns.

        Args:
            release: of all paths.
            points: control points, shape (F, n, M + W), rad and N·m·s.
        """
        limits, cluster, units, count = self.limits, self.platform.cluster, self.actuators.units, points.shape[1]
        slopes, bends = (derivative_points_matrix(self.duration, count, order) @ points for order in (1, 2))
        time = np.linspace(0.0, self.duration, _CHECKS + 1)
        at, turning = (basis_matrix(self.duration, count, time, order) @ points for order in (0, 1))
        held, torque = self._of_units(at, turning)
        momentum, jacobian = held, momentum_jacobian(cluster, at[..., :units])
        if points.shape[2] > units:
            wheels = self.platform.wheels
            momentum = held + wheel_momentum(wheels, at[..., units:])
            torque = torque + wheel_momentum(wheels, turning[..., units:])
        total, fastest = self._turning(release, momentum)
        shares = (
            np.abs(slopes[..., :units]) / limits.gimbal_rate,
            np.abs(bends[..., :units]) / limits.gimbal_acceleration,
            np.abs(momentum) / limits.cluster_momentum,
            np.abs(torque) / limits.cluster_torque,
            self._envelope(held),
            1.0 + limits.min_singularity_measure - dexterity(self.actuators, jacobian, cluster.rotor_momentum),
            fastest / limits.body_rate,
            self._motor(fastest, bends[..., :units]) / limits.gimbal_torque,
            *self._of_wheels(points[..., units:], slopes[..., units:], fastest * total + _longest(torque)),
        )
        return np.concatenate([share.reshape(len(points), -1) for share in shares], axis=1)

    def _of_units(self, at: Array, turning: Array) -> tuple[Array, Array]:
        """Return momentum and torque of the gyros along paths, both of shape (F, T, 3)."""
        cluster, units = self.platform.cluster, self.actuators.units
        angle, rate = at[..., :units], turning[..., :units]
        return cluster_momentum(cluster, angle, rate), np.matvec(momentum_jacobian(cluster, angle), rate)

    def _envelope(self, held: Array) -> Array:
        """Return the share of the gyros' envelope; wheels have a limit each."""
        if not self.actuators.units:
            return held[..., :0]
        return envelope_fraction(self.platform.cluster, held, SPHERE) / self.limits.envelope_fraction

    def _turning(self, release: Release, momentum: Array) -> tuple[Array, Array]:
        """Return the total momentum, N·m·s, and the fastest body rate that there can be, rad/s, both of shape (F,).

        ω = J⁻¹ (L - h), and L keeps its length.
        """
        inertia = self.platform.inertia
        total = np.linalg.norm(release.body_rate @ inertia + momentum[:, 0], axis=-1)
        return total, (total + _longest(momentum)) / np.linalg.eigvalsh(inertia)[0]

    def _motor(self, fastest: Array, bends: Array) -> Array:
        """Return the largest torque of a gimbal motor, shape (F,), N·m."""
        cluster, acceleration = self.platform.cluster, np.abs(bends).max(axis=(1, 2), initial=0.0)
        gyroscopic = np.abs(cluster.rotor_momentum).max(initial=0.0) * fastest
        return np.asarray(cluster.gimbal_axis_inertia.max(initial=0.0) * acceleration + gyroscopic)

    def _of_wheels(self, points: Array, slopes: Array, pull: Array) -> Iterator[Array]:
        """Yield shares of the wheels' limits.

        A motor gives Jw (Ω̇ + a·ω̇) + c Ω, and J ω̇ = -ω × L - ḣ.

        Args:
            points: of the wheels' momenta, shape (F, n, W), N·m·s.
            slopes: of their derivatives, shape (F, n - 1, W), N·m.
            pull: the largest |ω| |L| + |ḣ|, shape (F,), N·m.
        """
        wheels, limits = self.platform.wheels, self.limits
        if not points.shape[2]:
            return
        yield np.abs(points) / (limits.wheel_momentum_fraction * wheels.momentum_limit)
        along = np.multiply.outer(pull / np.linalg.eigvalsh(self.platform.inertia)[0], wheels.spin_inertia)
        slowed = np.abs(points).max(axis=1) * limits.wheel_friction / wheels.spin_inertia
        motor = np.abs(slopes) + (along + slowed)[:, None]
        yield motor / (limits.wheel_torque_fraction * wheels.torque_limit)

    @property
    def _jacobian(self) -> Array:
        """Of the momentum, by moves from the first motion, shape (3, M + W), N·m·s."""
        of_units = momentum_jacobian(self.platform.cluster, self.first[: self.actuators.units])
        wheels = self.platform.wheels
        return np.concatenate([of_units, (wheels.axis_B * wheels.momentum_limit[:, None]).T], axis=1)


def _longest(vectors: Array) -> Array:
    """Return the greatest length along paths, shape (F,), of vectors of shape (F, T, 3)."""
    return np.asarray(np.linalg.norm(vectors, axis=-1).max(axis=1))


def actuator_space(scenario: Scenario, nominal: PlatformModel) -> ActuatorSpace:
    """Return paths within the shares that the scenario's own design may use, or the designer's usual ones.

    Gimbals start from zero, and wheels from where the scenario has them; on orbit both as there.
    """
    kept = initial_momentum(scenario, nominal) if isinstance(nominal.environment, Orbiting) else None
    angle = first_gimbal_angle(scenario)
    return ActuatorSpace(
        limits=gimbal_limits(scenario, motion_section(scenario)),
        platform=nominal,
        actuators=platform_actuators(scenario, nominal),
        duration=flight_duration(scenario),
        first=np.concatenate([np.zeros_like(angle) if kept is None else angle, first_wheel_momentum(scenario)]),
        attitude=np.array(scenario.initial.attitude_quat_NB),
        kept_momentum_B=kept,
        first_rate=np.array(scenario.initial.body_rate_rad_s),
    )
