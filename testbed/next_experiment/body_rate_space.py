"""Flights as paths of the body rate, on a pivot, where gravity changes the momentum that gimbals and wheels share.

They follow the path with the least commands, and the platform ends as it began, at rest or with its spin: the tilt that
a bearing allows is a limit at every instant.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import cos, isinf
from typing import NamedTuple, final

import numpy as np
from scipy.interpolate import CubicSpline

from testbed.arrays import Array, Flags, Quaternion, Units
from testbed.assembly.maneuver import body_rate_limits, gimbal_limits
from testbed.assembly.platform import PlatformModel, first_gimbal_angle, first_wheel_momentum, platform_actuators
from testbed.cmg.actuators import Actuators, momentum_and_jacobian
from testbed.cmg.singularity import singularity_measure
from testbed.dynamics.environment import outside_torque
from testbed.maneuver.design import BodyRateLimits, GimbalLimits
from testbed.maneuver.splines import basis_matrix
from testbed.next_experiment.flight import NextFlight, Release
from testbed.next_experiment.following import followed
from testbed.next_experiment.space import (
    BIAS,
    CONTROL_POINTS,
    FARTHEST,
    TURNS,
    flight_duration,
    motion_section,
    path_through,
    release_spin,
)
from testbed.rotation.quaternion import exponential, matrix_of
from testbed.scenario.maneuver import BodyRateDesign
from testbed.scenario.scenario import Scenario

_INSTANTS = 10 * CONTROL_POINTS
"""At which limits are kept, ten for each control point, as a design limits a tilt."""
_REPEATED = 2
"""Paths drawn for each number of turns, as many as of gimbals, which are drawn with and without null motion."""


class _Motion(NamedTuple):
    """What F paths make of a platform at T instants.

    Attributes:
        momentum: h of gimbals and wheels, shape (F, T, 3), N·m·s, body axes.
        rise: cosine of the tilt, shape (F, T).
        actuators: gimbal angles, rad, and wheel momenta, N·m·s, shape (F, T, M + W).
    """

    momentum: Array
    rise: Array
    actuators: Array


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class BodyRateSpace:
    """Paths of the body rate, in shares of what the actuators' momentum allows.

    Attributes:
        limits: of body rate, tilt and what all actuators give together, margins taken off.
        inner: of gimbals and wheels, margins taken off.
        platform: the nominal one, on its pivot.
        actuators: its gyros and wheels.
        duration: s.
        first: what gimbals, rad, and wheels, N·m·s, start from, shape (M + W,).
        attitude: quat_NB at release.
    """

    limits: BodyRateLimits
    inner: GimbalLimits
    platform: PlatformModel
    actuators: Actuators
    duration: float
    first: Units
    attitude: Quaternion

    @property
    def scale(self) -> Array:
        """Unit of each axis' moves, shape (3,), rad/s."""
        return np.minimum(self.limits.cluster_momentum / np.diag(self.platform.turned_inertia), self.limits.body_rate)

    @property
    def free(self) -> Flags:
        """All three axes."""
        return np.ones(3, dtype=bool)

    def releases(self) -> Iterator[Release]:
        """Yield releases at rest, with a spin about the vertical, and with momentum in the actuators."""
        yield Release(np.zeros(3), self.first)
        yield Release(np.array([0.0, 0.0, release_spin(self.platform)]), self.first)
        units = self.actuators.units
        scale = self.actuators.move_scale
        _, jacobian = momentum_and_jacobian(self.actuators, self.first[:units], self.first[units:])
        by_move = jacobian * scale / self.actuators.command_scale
        for axis in np.eye(3):
            turns = np.linalg.pinv(by_move) @ axis
            yield Release(np.zeros(3), self.first + scale * (BIAS * turns / np.abs(turns).max()))

    def paths(self, rng: np.random.Generator) -> list[Array]:
        """Return the rates of paths through random angles about the body axes, those about x and y within the tilt."""
        reach = np.minimum([self.limits.tilt, self.limits.tilt, FARTHEST], FARTHEST)
        angles = [rng.uniform(-reach, reach, (turns, 3)) for turns in TURNS for _ in range(_REPEATED)]
        return [path_through(each, CONTROL_POINTS - 4, 1) / self.duration / self.scale for each in angles]

    def points(self, release: Release, moves: Array) -> Array:
        """Return control points that leave the release's rate and come back to it slowly, shape (..., n, 3), rad/s."""
        still = np.zeros((*moves.shape[:-2], 2, 3))
        return np.asarray(release.body_rate + self.scale * np.concatenate([still, moves, still], axis=-2))

    def moves(self, flight: NextFlight) -> Array:
        """Return the free control points less the first one, shape (n - 4, 3), in shares."""
        return np.asarray((flight.control_points[2:-2] - flight.body_rate) / self.scale)

    def flights(self, release: Release, points: Array) -> list[NextFlight]:
        """Return the flights of paths, shape (F, n, 3)."""
        return [
            NextFlight(
                body_rate=release.body_rate,
                attitude=self.attitude,
                path="body_rate",
                control_points=each,
                duration=self.duration,
                motion=CubicSpline(self._time, motion),
                units=self.actuators.units,
            )
            for each, motion in zip(points, self._moved(release, points).actuators, strict=True)
        ]

    def shares(self, release: Release, points: Array) -> Array:
        """Return shares of limits, each at most 1 where a path keeps them, shape (F, L); all at instants.

        Args:
            release: of all paths.
            points: control points, shape (F, n, 3), rad/s.
        """
        limits, inner, units, wheels = self.limits, self.inner, self.actuators.units, self.platform.wheels
        motion = self._moved(release, points)
        along = CubicSpline(self._time, motion.actuators, axis=1)
        rate = along(self._time, 1)
        acceleration = basis_matrix(self.duration, points.shape[1], self._time, 1) @ points
        along_axes = acceleration @ wheels.axis_B.T
        momenta = motion.actuators[..., units:]
        slowed = momenta * inner.wheel_friction / wheels.spin_inertia
        shares = (
            np.abs(points) / limits.body_rate,
            np.abs(motion.momentum) / limits.cluster_momentum,
            np.abs(CubicSpline(self._time, motion.momentum, axis=1)(self._time, 1)) / limits.cluster_torque,
            np.zeros_like(motion.rise) if isinf(limits.tilt) else (1.0 - motion.rise) / (1.0 - cos(limits.tilt)),
            np.abs(rate[..., :units]) / inner.gimbal_rate,
            np.abs(along(self._time, 2)[..., :units]) / inner.gimbal_acceleration,
            self._dexterity(motion.actuators),
            np.abs(momenta) / (inner.wheel_momentum_fraction * wheels.momentum_limit),
            np.abs(rate[..., units:] + wheels.spin_inertia * along_axes + slowed)
            / (inner.wheel_torque_fraction * wheels.torque_limit),
        )
        return np.concatenate([share.reshape(len(points), -1) for share in shares], axis=1)

    def _dexterity(self, motion: Array) -> Array:
        """Return how far below its floor the singularity measure is, more than 1 where it is, shape (F, T)."""
        units = self.actuators.units
        _, jacobian = momentum_and_jacobian(self.actuators, motion[..., :units], motion[..., units:])
        strengths = np.concatenate([self.platform.cluster.rotor_momentum, self.actuators.wheel_scale])
        return np.asarray(1.0 + self.inner.min_singularity_measure - singularity_measure(jacobian, strengths))

    @property
    def _time(self) -> Array:
        return np.linspace(0.0, self.duration, _INSTANTS + 1)

    def _moved(self, release: Release, points: Array) -> _Motion:
        """Return what paths make of the platform: h = Rᵀ (H₀ + ∫ R τ dt) - J ω."""
        inertia, step, environment = self.platform.turned_inertia, self._time[1], self.platform.environment
        body_rate = basis_matrix(self.duration, points.shape[1], self._time) @ points
        matrix_NB = self._attitudes(points, body_rate)
        assert environment is not None
        torque_N = np.matvec(
            matrix_NB, outside_torque(environment, self.platform.inertia, self._time, matrix_NB, body_rate)
        )
        impulse = np.cumsum(0.5 * step * (torque_N[:, 1:] + torque_N[:, :-1]), axis=1)
        units = self.actuators.units
        held_B, _ = momentum_and_jacobian(self.actuators, release.motion[:units], release.motion[units:])
        start_N = matrix_of(self.attitude) @ (inertia @ release.body_rate + held_B)
        total_N = start_N + np.concatenate([np.zeros_like(impulse[:, :1]), impulse], axis=1)
        momentum = np.vecmat(total_N, matrix_NB) - body_rate @ inertia
        actuators = followed(self.actuators, release.motion, momentum)
        return _Motion(momentum=momentum, rise=matrix_NB[..., 2, 2], actuators=actuators)

    def _attitudes(self, points: Array, body_rate: Array) -> Array:
        """Return R_NB at all instants, shape (F, T, 3, 3): each interval is turned by Simpson's mean of the rate."""
        step = self._time[1]
        middle = basis_matrix(self.duration, points.shape[1], self._time[:-1] + 0.5 * step) @ points
        turn = step / 6.0 * (body_rate[:, :-1] + 4.0 * middle + body_rate[:, 1:])
        turn = turn + step**2 / 12.0 * np.cross(body_rate[:, :-1], body_rate[:, 1:])
        turned = matrix_of(exponential(turn.reshape(-1, 3))).reshape(*turn.shape, 3)
        along = [np.broadcast_to(matrix_of(self.attitude), (len(points), 3, 3))]
        for instant in range(turned.shape[1]):
            along.append(along[-1] @ turned[:, instant])
        return np.stack(along, axis=1)


def body_rate_space(scenario: Scenario, nominal: PlatformModel) -> BodyRateSpace:
    """Return paths within what the scenario's own designs may use, or the designer's usual shares."""
    own, inner = scenario.maneuver, motion_section(scenario)
    section = (
        own
        if isinstance(own, BodyRateDesign)
        else BodyRateDesign(
            **inner.model_dump(include=_SHARED), parametrization="body_rate", constraint="hard", criterion="D"
        )
    )
    return BodyRateSpace(
        limits=body_rate_limits(scenario, section),
        inner=gimbal_limits(scenario, inner),
        platform=nominal,
        actuators=platform_actuators(scenario, nominal),
        duration=flight_duration(scenario),
        first=np.concatenate([first_gimbal_angle(scenario), first_wheel_momentum(scenario)]),
        attitude=np.array(scenario.initial.attitude_quat_NB),
    )


_SHARED = {
    "kind",
    "duration_s",
    "control_points",
    "starts",
    "seed",
    "sample_rate_hz",
    "prefilter_time_constant_s",
    "envelope_fraction",
}
"""Keys that designs of the body rate have in common with those of gimbals and wheels."""
