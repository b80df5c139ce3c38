"""The request for a maneuver design, and its result."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from math import inf
from typing import Literal, TypeAlias

import numpy as np

from testbed.arrays import Array, Matrix3, Theta, Units, Vector3
from testbed.cmg.actuators import Actuators, held_capacity
from testbed.cmg.cluster import Cluster, platform_momentum
from testbed.cmg.wheels import Wheels, no_wheels, wheel_momentum
from testbed.maneuver.criteria import Criterion
from testbed.maneuver.information import Information
from testbed.maneuver.maneuver import Maneuver

Parametrization: TypeAlias = Literal["body_rate", "gimbal", "actuator"]
Metric: TypeAlias = Literal["torque", "momentum"]
"""Of the information: the paper's Ψ_fᵀΨ_f, or that of the momentum equation, which is the Cramér-Rao bound's."""

Parameters: TypeAlias = Literal["inertia", "alignments"]
"""What the criterion is about: the inertia alone, or together with the alignments of every unit."""


@dataclass(frozen=True, kw_only=True)
class DesignProblem:
    """What to design, for which platform.

    Attributes:
        name: of the maneuver.
        criterion: what is optimised.
        duration: s.
        control_points: of the spline of each axis or gimbal, those that fix its ends included.
        sample_rate: of the gyro, Hz.
        prefilter_time_constant: γ, s, eq. (32).
        inertia: J with all gimbals at zero, kg·m², body axes.
        cluster: units; one whose rotor carries no momentum has failed and keeps its gimbal angle.
        initial_body_rate: ω(0), shape (3,), rad/s, body axes.
        initial_gimbal_angle: d(0), shape (M,), rad.
        wheels: reaction wheels beside the units, or without any.
        initial_wheel_momentum: Jw Ω at the start, shape (W,), N·m·s.
        gimbal_rate_limit: of the units, rad/s; the scale on which wheels count beside them in the singularity measure.
        metric: which information the criterion is taken of.
        target_std: of θ, kg·m²; the criterion counts each parameter in shares of its target; None counts all alike.
        initial_up_B: the vertical at the start, a unit vector in body axes; it counts where a tilt is limited.
        parameters: what the criterion is about; alignments take the momentum equation and a start without momentum.
    """

    name: str
    criterion: Criterion
    duration: float
    control_points: int
    sample_rate: float
    prefilter_time_constant: float
    inertia: Matrix3
    cluster: Cluster
    initial_body_rate: Vector3 = field(default_factory=lambda: np.zeros(3))
    initial_gimbal_angle: Units = field(default_factory=lambda: np.zeros(6))
    wheels: Wheels = field(default_factory=no_wheels)
    initial_wheel_momentum: Units = field(default_factory=lambda: np.zeros(0))
    gimbal_rate_limit: float = 1.0
    metric: Metric = "torque"
    target_std: Theta | None = None
    initial_up_B: Vector3 = field(default_factory=lambda: np.array([0.0, 0.0, 1.0]))
    parameters: Parameters = "inertia"

    @property
    def total_momentum_B(self) -> Vector3:
        """J(d) ω + h at the start, N·m·s, body axes at that time; conserved in inertial axes."""
        angle = self.initial_gimbal_angle
        of_units_B = platform_momentum(self.cluster, self.inertia, self.initial_body_rate, angle, np.zeros_like(angle))
        return of_units_B + wheel_momentum(self.wheels, self.initial_wheel_momentum)

    @property
    def actuators(self) -> Actuators:
        """Gyros and wheels."""
        return Actuators(cluster=self.cluster, wheels=self.wheels, gimbal_rate_limit=self.gimbal_rate_limit)

    @property
    def initial_motion(self) -> Array:
        """What the splines start from: gimbal angles, rad, then wheel momenta in shares of their limits."""
        return np.concatenate([self.initial_gimbal_angle, self.initial_wheel_momentum / self.wheels.momentum_limit])

    @property
    def held_momentum(self) -> float:
        """The sum of what all rotors and wheels can hold, N·m·s."""
        return held_capacity(self.cluster, self.wheels)


@dataclass(frozen=True, kw_only=True)
class BodyRateLimits:
    """What a body-rate design may use, per body axis.

    Attributes:
        cluster_torque: shape (3,), N·m.
        cluster_momentum: shape (3,), N·m·s.
        body_rate: about each axis, rad/s.
        tilt: of the body z axis from the vertical, rad.
    """

    cluster_torque: Vector3
    cluster_momentum: Vector3
    body_rate: float = inf
    tilt: float = inf


@dataclass(frozen=True, kw_only=True)
class GimbalLimits:
    """What a design of gimbal angles and wheel momenta may use; margins are taken off by the caller.

    Attributes:
        gimbal_rate: rad/s.
        gimbal_torque: of each motor, N·m.
        cluster_torque: per body axis, shape (3,), N·m.
        gimbal_acceleration: rad/s²; a servo follows a smooth reference better.
        cluster_momentum: per body axis, shape (3,), N·m·s.
        envelope_fraction: share of the cluster's true momentum envelope, in every direction.
        min_singularity_measure: smallest on the way, 1 at the best.
        body_rate: about each axis, rad/s.
        wheel_momentum_fraction: share of each wheel's momentum limit.
        wheel_torque_fraction: share of each wheel's torque limit.
        wheel_friction: of each wheel's bearing, which its motor makes up for, shape (W,), N·m·s/rad.
    """

    gimbal_rate: float
    gimbal_torque: float
    cluster_torque: Vector3
    gimbal_acceleration: float = inf
    cluster_momentum: Vector3 = field(default_factory=lambda: np.full(3, inf))
    envelope_fraction: float = 1.0
    min_singularity_measure: float = 0.0
    body_rate: float = inf
    wheel_momentum_fraction: float = 1.0
    wheel_torque_fraction: float = 1.0
    wheel_friction: Units = field(default_factory=lambda: np.zeros(0))


@dataclass(frozen=True, kw_only=True)
class Start:
    """One start of the optimiser.

    Attributes:
        index: of its seed, from 0.
        cost: logarithm of what was minimised; infinite where the start did not end within the limits.
        seconds: of this solve.
        status: the optimiser's own word.
    """

    index: int
    cost: float
    seconds: float
    status: str

    @property
    def number(self) -> int:
        """Number of the start in outputs, from 1."""
        return self.index + 1

    @property
    def ended(self) -> str:
        """How the optimiser says that it ended, in words."""
        return self.status.replace("_", " ").lower()


@dataclass(frozen=True, kw_only=True)
class Search:
    """Settings of the multi-start search.

    Attributes:
        starts: number of random starts.
        seed: of all of them; start i is the same whatever the number of starts.
        progress: called with each start as it ends.
    """

    starts: int
    seed: int
    progress: Callable[[Start], None] = field(default=lambda _: None)


@dataclass(frozen=True, kw_only=True)
class Design:
    """A designed maneuver and how it was found.

    Attributes:
        maneuver: the reference.
        criterion: what was optimised.
        parametrization: what the splines describe.
        information: figures of Ψ_fᵀΨ_f of the maneuver.
        starts: all starts, in order.
        best: index of the start that became the maneuver.
        setup_seconds: before the first start.
    """

    maneuver: Maneuver
    criterion: Criterion
    parametrization: Parametrization
    information: Information
    starts: tuple[Start, ...]
    best: int
    setup_seconds: float

    @property
    def seconds(self) -> float:
        """Time of the start that became the maneuver, s."""
        return self.starts[self.best].seconds
