"""What an estimator is given: gyro samples, the telemetry of the actuators, and what is known of the momentum.

Each kind of actuation is a type of its own. What works on gimbals takes a `GimbalTelemetry`, or a run of which
`has_gimbals` was asked once.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, fields, replace
from typing import Any, Generic, Literal, Self, TypeAlias, TypeGuard

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BSpline, CubicSpline, make_interp_spline
from typing_extensions import TypeVar

from testbed.arrays import Array, Flags, Matrix3, Series, Units, UnitSeries, Vectors3
from testbed.cmg.cluster import Cluster, cluster_part
from testbed.cmg.servo_law import ServoLaw
from testbed.cmg.wheels import Wheels
from testbed.dynamics.environment import Pivoted
from testbed.errors import InputError
from testbed.estimation.gaps import FEWEST_SAMPLES, covered_by, stretches
from testbed.estimation.held import along_steps, corners_of, impulse_of_held, within_held
from testbed.estimation.slow_bias import SlowBias
from testbed.estimation.surroundings import Surroundings

ALL_AXES = (True, True, True)
"""A platform that turns freely."""
ConstantTorque: TypeAlias = Literal["none", "body", "inertial", "both"]


@dataclass(frozen=True, kw_only=True)
class Servo(ServoLaw):
    """What is known of the servo that every gimbal has: its law, and its clock.

    Attributes:
        period: of the control loop, s; telemetry is sampled on its clock.
    """

    period: float


@dataclass(frozen=True, kw_only=True, eq=False)
class GimbalTelemetry:
    """What M control moment gyros sent, at the actuators' times, and what is known of them.

    Attributes:
        cluster: the units.
        angle: encoders, shape (K, M), rad.
        rotor_momentum: tachometers times Js, shape (K, M), N·m·s; the nominal one where None.
        torque: of the gimbal motors, shape (K, M), N·m; None where it was not sent.
        servo: of the gimbals; None where it is not known.
        angles_late: by how much angles and rotor momenta are later than the torques of the same rows, s.
        rotor_speed_noise: standard deviation of the tachometers that `rotor_momentum` was freed of, rad/s; 0 where it
            is as it was sent.
        angle_noise: standard deviation of the encoders that `angle` was freed of, rad; 0 where it is as it was sent.
        angle_variance: of the errors that then stay in it, shape (M,), rad²; None where it is as it was sent.
    """

    cluster: Cluster
    angle: UnitSeries
    rotor_momentum: UnitSeries | None = None
    torque: UnitSeries | None = None
    servo: Servo | None = None
    angles_late: float = 0.0
    rotor_speed_noise: float = 0.0
    angle_noise: float = 0.0
    angle_variance: Units | None = None

    def commanded(self, rate_command: UnitSeries) -> GimbalTelemetry:
        """Return the units with what their servo was commanded, shape (K, M), rad/s; as they are without a servo."""
        if self.servo is None:
            return self
        return CommandedGimbals(
            cluster=self.cluster,
            angle=self.angle,
            rotor_momentum=self.rotor_momentum,
            torque=self.torque,
            servo=self.servo,
            rate_command=rate_command,
        )

    def angles_only(self) -> GimbalTelemetry:
        """Return the units without the channels of their motors: neither torques nor commands."""
        return GimbalTelemetry(
            cluster=self.cluster, angle=self.angle, rotor_momentum=self.rotor_momentum, servo=self.servo
        )

    def unit(self, index: int) -> GimbalTelemetry:
        """Return one unit's angle and rotor momentum, shapes (K, 1)."""
        column = slice(index, index + 1)
        spin = self.rotor_momentum
        return GimbalTelemetry(
            cluster=cluster_part(self.cluster, column),
            angle=self.angle[:, column],
            rotor_momentum=None if spin is None else spin[:, column],
        )

    def with_samples(self, change: Callable[[Array], Array]) -> Self:
        """Return the units with every sampled channel changed alike."""
        values = {each.name: getattr(self, each.name) for each in fields(self)}
        sampled: dict[str, Any] = {
            name: change(value) for name, value in values.items() if isinstance(value, np.ndarray)
        }
        return replace(self, **sampled)


@dataclass(frozen=True, kw_only=True, eq=False)
class CommandedGimbals(GimbalTelemetry):
    """Units whose servo is known, and what it was commanded: their angles can be predicted.

    Attributes:
        rate_command: by the steering law, shape (K, M), rad/s.
    """

    servo: Servo = field()  # known here, and therefore without a default
    rate_command: UnitSeries


@dataclass(frozen=True, kw_only=True, eq=False)
class Thrusters:
    """Single actuators that push: motors with propellers, jets.

    Attributes:
        position_B: of each about the centre of mass, shape (M, 3), m, body axes.
        direction_B: of its thrust, unit vectors, shape (M, 3).
        reaction: torque about that direction for each newton, shape (M,), m; zero of a jet.
    """

    position_B: Array
    direction_B: Array
    reaction: Array

    @property
    def torque_per_thrust_B(self) -> Array:
        """Shape (M, 3), m."""
        return self.torque_along(self.direction_B)

    def torque_along(self, direction_B: Array) -> Array:
        """Return what a newton of each makes about the centre of mass in other directions, shape (M, 3), m."""
        return np.asarray(np.cross(self.position_B, direction_B) + self.reaction[:, None] * direction_B)


@dataclass(frozen=True, kw_only=True, eq=False)
class WheelMotors:
    """What is known of the motors and bearings of W reaction wheels.

    Attributes:
        viscous_friction: of each bearing, shape (W,), N·m·s/rad.
        coulomb_friction: of each bearing, shape (W,), N·m.
        loop_bandwidth: of the loop on each wheel's speed inside its drive, shape (W,), rad/s; 0 for none.
        period: of the control loop, s; a motor holds its command through it, and telemetry is sampled on its clock.
        command_phase: share of the period for which a command has held when it is sampled.
        torque_phase: share of the period for which a measured torque goes on when it is sampled; none where it is what
            the motor gave until then, one half where it is what it gives at the instant.
        near_jumps: whether intervals beside a jump of a torque are compared, in which splines that end there err by a
            twentieth of what such a torque bends: to see its bends, not to compare impulses by.
    """

    viscous_friction: Units
    coulomb_friction: Units
    loop_bandwidth: Units
    period: float
    command_phase: float = 0.0
    torque_phase: float = 0.0
    near_jumps: bool = False


@dataclass(frozen=True, kw_only=True, eq=False)
class SmoothedMomentum:
    """What wheels hold behind the noise of their tachometers.

    Attributes:
        samples: Jw Ω at the actuators' times, shape (K, W), N·m·s.
        variance: of their errors, shape (W,), (N·m·s)².
        noise: standard deviation of the tachometers that was found, shape (W,), N·m·s; None where the torques show it.
    """

    samples: UnitSeries
    variance: Units
    noise: Units | None = None


@dataclass(frozen=True, kw_only=True, eq=False)
class CommandScatter:
    """What commands of wheels scatter by that change more often than they are sampled, and for how long it acts.

    Attributes:
        samples: of the commands less what of them changes smoothly, shape (K, W), N·m.
        behind: share of the interval between samples for which it acts behind its sample.
        before: likewise before it.
        unbelieved: whether commands were believed to hold from sample to sample.
    """

    samples: UnitSeries
    behind: float
    before: float
    unbelieved: bool = False


@dataclass(frozen=True, kw_only=True, eq=False)
class WheelTelemetry:
    """What W reaction wheels sent, at the actuators' times, and what is known of them.

    Attributes:
        wheels: the array.
        momentum: tachometers times Jw, shape (K, W), N·m·s.
        torque: of their motors, shape (K, W), N·m; None where it was not sent.
        torque_command: that they should give, shape (K, W), N·m; None where it was not sent.
        motors: None where they are not known.
        smoothed: the momentum without the tachometers' noise; None where it was not separated.
        scatter: of the commands; None where it is not known, or they hold from sample to sample.
    """

    wheels: Wheels
    momentum: UnitSeries
    torque: UnitSeries | None = None
    torque_command: UnitSeries | None = None
    motors: WheelMotors | None = None
    smoothed: SmoothedMomentum | None = None
    scatter: CommandScatter | None = None

    @property
    def best_momentum(self) -> UnitSeries:
        """Jw Ω as well as it is known, shape (K, W), N·m·s."""
        return self.momentum if self.smoothed is None else self.smoothed.samples

    def with_samples(self, change: Callable[[Array], Array]) -> WheelTelemetry:
        """Return the wheels with every sampled channel changed alike."""
        channels = {"momentum": self.momentum, "torque": self.torque, "torque_command": self.torque_command}
        sampled: dict[str, Any] = {name: change(each) for name, each in channels.items() if each is not None}
        smoothed = self.smoothed and replace(self.smoothed, samples=change(self.smoothed.samples))
        scatter = self.scatter and replace(self.scatter, samples=change(self.scatter.samples))
        return replace(self, **sampled, smoothed=smoothed, scatter=scatter)


Gimbals_co = TypeVar("Gimbals_co", bound=GimbalTelemetry | None, default=GimbalTelemetry | None, covariant=True)
"""Whether gimbals are known, by the type: None, a `GimbalTelemetry`, or either."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Telemetry(Generic[Gimbals_co]):
    """The measurements of one run. Channels that were not sent are None; there are no NaN inside.

    Two are the same only if they are one object, by which what follows from them is remembered.

    Attributes:
        gyro_time: shape (N,), s, strictly increasing; gaps and jitter are allowed.
        body_rate: measured ω, shape (N, 3), rad/s, body axes.
        gyro_noise: standard deviation of its white noise per sample, rad/s.
        actuator_time: shape (K,), s, strictly increasing; may differ from the gyro's in rate, start and end.
        gimbals: what the control moment gyros sent.
        wheels: what the reaction wheels sent, beside the gyros or without any.
        cluster_momentum: h as the platform itself reports it, shape (K, 3), N·m·s, body axes; used where `gimbals` and
            `wheels` are None, and then the inertia's change with the gimbal angles is left out.
        applied_torque: torque of actuators that store no momentum, shape (K, 3), N·m, body axes; beside either.
        torque_held: whether a sample of `applied_torque` and `thrust` is held about its time, half way to its
            neighbours, as thrusters are switched; otherwise it changes smoothly from sample to sample.
        momentum_held: whether the torque of wheels' motors is held from one sample of the telemetry to the next, so
            that momenta go along chords; otherwise they change smoothly.
        held_inertia: near the true one, shape (3, 3), kg·m²; by it a held torque bends the rate between samples. Where
            None, rates are joined smoothly.
        thrust: of single actuators as commanded, shape (K, M), N; what they make together is in `applied_torque`.
        thrusters: where these are.
        initial_momentum: whether the whole platform's momentum at the first sample is known to be zero.
        constant_torque: which constant torques on the platform are estimated jointly: fixed in the body, fixed in
            inertial axes, or both.
        slow_bias: how the gyro's bias is stated to wander; None where it is not.
        noise_freedom: degrees of freedom with which `gyro_noise` is known; infinite where it is stated.
        gyro_error: what of `body_rate` is known to be the gyro's own, or what the body moves between its clock and the
            actuators', shape (N, 3), rad/s; nothing where None.
        reading_error: the part of it by which the gyro misreads the rate that it is of, alike.
        surroundings: what acts on the platform from outside, and its attitude; None where nothing does. On a pivot the
            place of the centre of mass is estimated jointly, and all inertias are about the pivot.
        followed_from: when the motion that is predicted begins, s, where that is before the first gyro sample that is
            compared; None where it is that.
        live: about which body axes the platform turns; about the others a rig's bearing holds it, their rates are zero
            and compared with nothing.
    """

    gyro_time: Series
    body_rate: Vectors3
    gyro_noise: float
    actuator_time: Series
    gimbals: Gimbals_co
    wheels: WheelTelemetry | None = None
    cluster_momentum: Vectors3 | None = None
    applied_torque: Vectors3 | None = None
    torque_held: bool = False
    momentum_held: bool = False
    held_inertia: Matrix3 | None = None
    thrust: Array | None = None
    thrusters: Thrusters | None = None
    initial_momentum: Literal["estimated", "zero"] = "estimated"
    constant_torque: ConstantTorque = "none"
    slow_bias: SlowBias | None = None
    noise_freedom: float = np.inf
    gyro_error: Vectors3 | None = None
    reading_error: Vectors3 | None = None
    followed_from: float | None = None
    live: tuple[bool, bool, bool] = ALL_AXES
    surroundings: Surroundings | None = None

    def with_motors(self, change: Callable[[WheelMotors], WheelMotors]) -> Telemetry:
        """Return the run with its wheels' motors changed; itself where these are not known."""
        if self.wheels is None or self.wheels.motors is None:
            return self
        return replace(self, wheels=replace(self.wheels, motors=change(self.wheels.motors)))

    @property
    def pivot(self) -> Pivoted | None:
        """The pivot that the platform is believed to stand on; None of one that floats."""
        environment = self.surroundings and self.surroundings.environment
        return environment if isinstance(environment, Pivoted) else None

    @property
    def momentum_unknowns(self) -> int:
        """Number of unknowns that the initial momentum makes."""
        return 0 if self.initial_momentum == "zero" else 3

    @property
    def torque_names(self) -> tuple[str, ...]:
        """Names of the constant torques' components; their unknowns stand behind inertia and momentum."""
        frames = {"none": (), "body": ("body",), "inertial": ("inertial",), "both": ("body", "inertial")}
        return tuple(f"{frame}_{axis}" for frame in frames[self.constant_torque] for axis in "xyz")

    @property
    def torque_unknowns(self) -> int:
        """Number of unknowns of constant torques and, on a pivot, of the place of the centre of mass, behind them."""
        return len(self.torque_names) + (0 if self.pivot is None else 3)

    def torque_of(self, unknowns: Array) -> Array:
        """Return the constant torques among an estimator's unknowns, N·m, then the offset's error, m, (..., K)."""
        return unknowns[..., unknowns.shape[-1] - self.torque_unknowns :]

    def through(self, samples: Array, axis: int = 0) -> CubicSpline:
        """Return the cubic spline through samples of an actuator channel, shape (K, ...), or on another axis."""
        return CubicSpline(self.actuator_time, samples, axis=axis)

    def momentum_through(self, samples: Array, axis: int = 0) -> CubicSpline | BSpline:
        """Return what joins samples of wheels' momenta, or of one that is reported; arguments as `through`."""
        if self.momentum_held:
            return make_interp_spline(self.actuator_time, samples, k=1, axis=axis)
        return self.through(samples, axis)

    def held_impulse(self, samples: Array) -> BSpline:
        """Return the impulse since the first of samples, shape (..., K, C), each held about its time; on axis -2."""
        return impulse_of_held(self.actuator_time, samples, axis=-2)

    def driven(self, samples: Array, at: Series) -> Array:
        """Return samples of what drives the platform, shape (K, C), along an integration's grid, shape (T, C).

        Args:
            samples: of the applied torque, or of thrusts, at the actuators' times.
            at: every half step, the last a node, shape (T,), s.
        """
        if self.torque_held:
            return along_steps(self.held_impulse(samples), at)
        return np.asarray(self.through(samples)(at))

    @property
    def held_torque(self) -> BSpline | None:
        """The impulse of an applied torque that is held from sample to sample, N·m·s, body axes; None without one."""
        return self.held_impulse(self.applied_torque) if self.torque_held and self.applied_torque is not None else None

    @property
    def held_momentum(self) -> BSpline | None:
        """The impulse that motors with held torque give the body, N·m·s, body axes; None where none is known."""
        if not self.momentum_held or self.gimbals is not None:
            return None
        wheels, reported = self.wheels, self.cluster_momentum
        momentum = reported if wheels is None else wheels.best_momentum @ wheels.wheels.axis_B
        return None if momentum is None else make_interp_spline(self.actuator_time, -momentum, k=1, axis=-2)

    @property
    def corners(self) -> BSpline | None:
        """The body rate that bends where a held torque jumps, rad/s; None where rates are joined smoothly."""
        impulse = self.held_momentum if self.held_torque is None else self.held_torque
        return None if impulse is None or self.held_inertia is None else corners_of(impulse, self.held_inertia)

    def with_held_momentum(self, inertia: Matrix3) -> Telemetry:
        """Return the run with momenta along chords, which bend the rate of a body of about this inertia, kg·m²."""
        return replace(self, momentum_held=True, held_inertia=inertia)

    def with_actuator_samples(self: Telemetry, time: Series, change: Callable[[Array], Array]) -> Telemetry:
        """Return the run with every actuator channel changed alike.

        Args:
            time: of the new samples, shape (K',), s.
            change: of a channel's samples, shape (K, ...), to those at `time`, shape (K', ...).
        """
        momentum, torque = self.cluster_momentum, self.applied_torque
        return replace(
            self,
            actuator_time=time,
            gimbals=None if self.gimbals is None else self.gimbals.with_samples(change),
            wheels=None if self.wheels is None else self.wheels.with_samples(change),
            cluster_momentum=None if momentum is None else change(momentum),
            applied_torque=None if torque is None else change(torque),
            thrust=None if self.thrust is None else change(self.thrust),
        )

    def with_best_momentum(self: Telemetry) -> Telemetry:
        """Return the run with the momentum of its wheels as well as it is known."""
        return replace(self, wheels=self.wheels and replace(self.wheels, momentum=self.wheels.best_momentum))

    def with_actuator_rows(self: Telemetry, rows: slice | Flags) -> Telemetry:
        """Return the run with some of its actuators' samples."""
        return self.with_actuator_samples(self.actuator_time[rows], lambda samples: samples[rows])

    @property
    def begin(self) -> float:
        """When the motion that is predicted begins, s."""
        return float(self.gyro_time[0]) if self.followed_from is None else self.followed_from

    def with_gyro_rows(self: Telemetry, rows: slice | Flags | NDArray[np.intp]) -> Telemetry:
        """Return the run with some of its gyro's samples, as they were read."""
        return replace(self, gyro_time=self.gyro_time[rows], body_rate=self.body_rate[rows])


def has_momentum(run: Telemetry) -> bool:
    """Return whether what the actuators hold is known, by gimbals, wheels, or as the platform reports it."""
    return run.gimbals is not None or run.wheels is not None or run.cluster_momentum is not None


GimbalRun: TypeAlias = Telemetry[GimbalTelemetry]
CommandedRun: TypeAlias = Telemetry[CommandedGimbals]


def has_gimbals(run: Telemetry) -> TypeGuard[GimbalRun]:
    """Return whether a run's gimbal angles are known."""
    return run.gimbals is not None


def is_commanded(run: Telemetry) -> TypeGuard[CommandedRun]:
    """Return whether a run carries the commanded gimbal rates, and the servo is known."""
    return isinstance(run.gimbals, CommandedGimbals)


def covered_part(telemetry: Telemetry) -> Telemetry:
    """Return the telemetry without the gyro samples that no actuator telemetry covers, or that stand alone.

    Raises:
        InputError: too few samples are left.
    """
    if len(telemetry.actuator_time) < FEWEST_SAMPLES:
        raise InputError(
            f"the actuator telemetry has {len(telemetry.actuator_time)} samples; an estimate needs {FEWEST_SAMPLES}"
        )
    asked = telemetry.gyro_time
    if telemetry.torque_held:
        asked = within_held(asked, telemetry.actuator_time)
    covered = np.flatnonzero(covered_by(asked, telemetry.actuator_time))
    keep = np.concatenate([covered[run] for run in stretches(telemetry.gyro_time[covered])] or [covered[:0]])
    if len(keep) == 0:
        raise InputError(
            f"{len(covered)} of {len(telemetry.gyro_time)} gyro samples lie within the actuator telemetry, and no "
            f"{FEWEST_SAMPLES} of them follow one another without a gap: give a longer record"
        )
    return replace(telemetry, gyro_time=telemetry.gyro_time[keep], body_rate=telemetry.body_rate[..., keep, :])
