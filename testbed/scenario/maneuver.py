"""What is flown: designed for this scenario, the paper's basic profile, a file, or the control points of a spline."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Literal, TypeAlias

from pydantic import Field, Strict, model_validator

from testbed.quantities import Acceleration, Factor, Moment, RateLimit, SignedMomentum
from testbed.scenario.section import Conflict, Section, refuse
from testbed.scenario.values import Angles, BodyRates, Duration, File, PerUnit, PrefilterTime, Rate, Seed, Share, Six

_MIN_CONTROL_POINTS = 4
"""A cubic spline has no fewer."""
_MOST_CONTROL_POINTS = 1000
"""Ten times as many as any maneuver here has; the optimiser's time grows with their square."""
_MOST_STARTS = 10_000
"""Of 0.3 s at the least: an hour."""
_KILOBYTE, _GIGABYTE = 1e3, 1e9
MOST_DESIGN_MEMORY = 2.0 * _GIGABYTE
"""Bytes that the optimiser may take: a laptop's 4 GB less everything else."""
_SEVERAL = Field(min_length=_MIN_CONTROL_POINTS, max_length=_MOST_CONTROL_POINTS)
MIN_SAMPLES = 10
"""Six parameters and an initial state are not identifiable from fewer."""


class _Design(Section):
    kind: Literal["design"]
    """Where the maneuver comes from: optimised when the scenario is run."""
    criterion: Literal["D", "A", "E", "condition"]
    """What is optimised: determinant, trace of the inverse, smallest eigenvalue or condition number of information."""
    metric: Literal["torque", "momentum"] = "torque"
    """Information of the paper's torque equation, Ψ_fᵀΨ_f behind the prefilter, or of the momentum equation, which is
    the Cramér-Rao bound's where the total momentum is zero."""
    target_std_kg_m2: Six[Moment] | None = None
    """Standard deviations of J11, J22, J33, J23, J13, J12 that count alike: A minimises the sum of (deviation /
    target)²; omitted: all parameters count alike."""
    duration_s: Duration
    """Duration, from rest to rest."""
    control_points: Annotated[int, Field(ge=_MIN_CONTROL_POINTS, le=_MOST_CONTROL_POINTS)]
    """Control points of the cubic spline of each axis or gimbal, ends included."""
    starts: Annotated[int, Field(ge=1, le=_MOST_STARTS)]
    """Number of random starts; the best of them is flown."""
    seed: Seed
    """Seed of the starts."""
    sample_rate_hz: Rate
    """Rate at which the information is sampled; the gyro's, as a rule."""
    prefilter_time_constant_s: PrefilterTime
    """Time constant γ of the prefilter inside Ψ_f, eq. (32)."""
    body_rate_limit_rad_s: RateLimit | None = None
    """Largest body rate about each axis; omitted: what the cluster's momentum allows."""

    @model_validator(mode="after")
    def _consistent(self) -> _Design:
        refuse(self._conflicts())
        return self

    def _conflicts(self) -> Iterator[Conflict]:
        samples = self.duration_s * self.sample_rate_hz
        if samples < MIN_SAMPLES:
            yield Conflict(
                key="duration_s",
                text=f"{self.duration_s} s at {self.sample_rate_hz} Hz gives {samples:.3g} samples; "
                f"at least {MIN_SAMPLES} are needed: {MIN_SAMPLES / self.sample_rate_hz:.3g} s",
            )
        elif self.control_points > samples:
            yield Conflict(
                key="control_points",
                text=f"{self.control_points} exceeds the {samples:.3g} samples of the maneuver; use fewer",
            )
        memory = samples * self._bytes_per_sample()
        if memory > MOST_DESIGN_MEMORY:
            most = MOST_DESIGN_MEMORY / self._bytes_per_sample()
            yield Conflict(
                key="sample_rate_hz",
                text=f"{self.sample_rate_hz} Hz over {self.duration_s} s are {samples:,.0f} samples, for which the "
                f"optimiser takes {memory / _GIGABYTE:.3g} GB; {MOST_DESIGN_MEMORY / _GIGABYTE:g} GB are allowed, "
                f"{most:,.0f} samples: use {most / self.duration_s:.3g} Hz",
            )
        if self.criterion == "D" and self.target_std_kg_m2 is not None:
            yield Conflict(
                key="target_std_kg_m2",
                text="has no effect on criterion D, whose optimum is the same in all units; use A or E, or omit it",
            )

    def _bytes_per_sample(self) -> float:
        """What the optimiser takes for a sample, measured at 1,000 to 60,000 samples and rounded up."""
        raise NotImplementedError


class BodyRateDesign(_Design):
    """The paper's design: splines for the body rate."""

    parametrization: Literal["body_rate"]
    """What the splines describe: body_rate (3 axes) or gimbal (an angle for each unit)."""
    constraint: Literal["hard", "penalty"]
    """Limits as constraints on the control points, or as the paper's sixth-power penalty, eqs. (27)-(29)."""
    envelope_fraction: Share
    """Share of the cluster's torque and momentum limits that the design may use, eqs. (25), (26), (31)."""
    start_from: Literal["random", "basic"] = "random"
    """Where the optimiser starts: random motions, or the paper's basic profile, which is one start."""

    def _conflicts(self) -> Iterator[Conflict]:
        yield from super()._conflicts()
        if self.start_from == "basic" and self.starts != 1:
            yield Conflict(
                key="starts",
                text=f'is {self.starts}, but the basic profile is one start; use 1, or start_from "random"',
            )

    def _bytes_per_sample(self) -> float:
        return 3.0 * _KILOBYTE * 3 * self.control_points  # second derivatives by each of them


class _MotionDesign(_Design):
    envelope_fraction: Share
    """Share of the cluster's true momentum envelope that the design may use, in every direction."""
    cluster_torque_fraction: Share = 1.0
    """Share of the cluster's torque limits that the design may use; a small one leaves most to null motion."""
    gimbal_acceleration_limit_rad_s2: Acceleration | None = None
    """Largest gimbal acceleration, to spare the servo; omitted: only the gimbal torque limits it."""

    def _bytes_per_sample(self) -> float:
        if self.criterion == "condition":
            return 5.0 * _KILOBYTE * 6 * self.control_points  # second derivatives by each of them
        return 150.0 * _KILOBYTE if self.criterion == "E" else 17.0 * _KILOBYTE


class GimbalDesign(_MotionDesign):
    """Splines for the gimbal angles; the body rate follows from zero total momentum, so it can be flown."""

    parametrization: Literal["gimbal"]
    """What the splines describe: body_rate (3 axes) or gimbal (an angle for each unit)."""
    parameters: Literal["inertia", "alignments"] = "inertia"
    """What the criterion is about: the inertia, or together with it every unit's gimbal-axis misalignment, encoder zero
    and momentum scale."""
    gimbal_rate_fraction: Share
    """Share of the gimbal-rate limit that the design may use; the rest is the tracker's margin."""
    min_singularity_measure: Annotated[float, Field(ge=0, lt=1)]
    """Smallest singularity measure on the way; a pure number, 1 at the best."""

    def _conflicts(self) -> Iterator[Conflict]:
        yield from super()._conflicts()
        if self.parameters == "inertia":
            return
        if self.metric != "momentum":
            text = 'is "torque", but alignments are designed for in the momentum equation; use "momentum"'
            yield Conflict(key="metric", text=text)
        if self.criterion != "D":
            text = f'is "{self.criterion}", but 29 parameters of three units are designed for; use "D", which has none'
            yield Conflict(key="criterion", text=text)


class ActuatorDesign(_MotionDesign):
    """Splines for the angle of every gimbal and the momentum of every wheel; the body rate follows from conservation.

    To fly along all of it, null motion has to go along the maneuver too: of gimbals by
    controller.steering.preferred_gimbal_angle_rad, of wheels by controller.wheels.null_motion.
    """

    parametrization: Literal["actuator"]
    """What the splines describe: actuator (an angle for each gimbal and a momentum for each wheel)."""
    gimbal_rate_fraction: Share = 0.8
    """Share of the gimbal-rate limit that the design may use; the rest is the tracker's margin."""
    wheel_momentum_fraction: Share = 0.9
    """Share of each wheel's momentum limit that the design may use."""
    wheel_torque_fraction: Share = 0.8
    """Share of each wheel's torque limit that the design may use; the rest is the tracker's margin."""
    min_singularity_measure: Annotated[float, Field(ge=0, lt=1)] = 0.0
    """Smallest singularity measure of gyros and wheels together on the way; a pure number, 1 at the best."""


class BasicManeuver(Section):
    """The paper's basic profile: all three axes excited, differently."""

    kind: Literal["basic"]
    """Where the maneuver comes from: the paper's basic profile."""
    duration_s: Duration
    """Duration, from rest to rest."""
    scale: Factor
    """Factor on the body rate; 1.5 is the paper's scaled profile."""


class CsvManeuver(Section):
    """A profile from a table of samples."""

    kind: Literal["csv"]
    """Where the maneuver comes from: a table of samples."""
    file: File
    """Table with time_s and the body rate columns of a record, and those of all gimbal angles or wheel speeds where it
    prescribes them; relative to the scenario's folder."""


class _ControlPoints(Section):
    kind: Literal["control_points"]
    """Where the maneuver comes from: the control points of a clamped cubic spline, such as an earlier design's."""
    duration_s: Duration
    """Duration; the knots are uniform on it."""


class BodyRatePoints(_ControlPoints):
    """A body-rate spline."""

    parametrization: Literal["body_rate"]
    """What the spline describes: body_rate (3 axes) or gimbal (an angle for each unit)."""
    body_rate_rad_s: Annotated[tuple[BodyRates, ...], Strict(False), _SEVERAL]
    """Control points of the body rate, one row of 3 each."""


class ActuatorPoints(_ControlPoints):
    """A spline of gimbal angles and wheel momenta; the body rate follows from conservation of momentum."""

    parametrization: Literal["actuator"]
    """What the spline describes: actuator (an angle for each gimbal and a momentum for each wheel)."""
    gimbal_angle_rad: Annotated[tuple[Angles, ...], Strict(False), Field(max_length=_MOST_CONTROL_POINTS)] = ()
    """Control points of the gimbal angles: rows with one for each unit; omitted on a platform with wheels alone."""
    wheel_momentum_N_m_s: Annotated[tuple[PerUnit[SignedMomentum], ...], Strict(False), _SEVERAL]
    """Control points of the wheels' momenta: rows with one for each wheel, as many as of the gimbals."""


class GimbalPoints(_ControlPoints):
    """A gimbal-angle spline; the body rate follows from zero total momentum."""

    parametrization: Literal["gimbal"]
    """What the spline describes: body_rate (3 axes) or gimbal (an angle for each unit)."""
    gimbal_angle_rad: Annotated[tuple[Angles, ...], Strict(False), _SEVERAL]
    """Control points of the gimbal angles: rows with one for each unit."""


Designed: TypeAlias = BodyRateDesign | GimbalDesign | ActuatorDesign
"""Maneuvers that are designed."""
Maneuver: TypeAlias = Annotated[
    Annotated[Designed, Field(discriminator="parametrization")]
    | BasicManeuver
    | CsvManeuver
    | Annotated[BodyRatePoints | GimbalPoints | ActuatorPoints, Field(discriminator="parametrization")],
    Field(discriminator="kind"),
]
