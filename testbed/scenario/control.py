"""The rate tracker and its steering law."""

from __future__ import annotations

from typing import Annotated, Literal, TypeAlias

from pydantic import Field

from testbed.quantities import Gain, PositiveGain, RateLimit, SignedMomentum, Weight
from testbed.scenario.section import Section
from testbed.scenario.values import Angles, Many, ManyOrOne, One, PerUnit


class _Steering(Section):
    null_motion_gain_1_s: Gain = 0.0
    """Rate at which null motion takes the gimbals toward their preferred angles; 0: no null motion."""
    preferred_gimbal_angle_rad: Annotated[
        Annotated[Literal["maneuver", "zero"], One] | Annotated[Angles, Many], ManyOrOne
    ] = "zero"
    """Preferred gimbal angles: those of a gimbal-space "maneuver", "zero", or a list with one for each unit."""


class MoorePenrose(_Steering):
    """The smallest gimbal rates, unbounded at a singularity."""

    law: Literal["moore_penrose"]
    """Steering law: which gimbal rates give a wanted torque."""


class SingularityRobust(_Steering):
    """Damped near a singularity, at the price of torque: λ = damping · exp(-decay · det(A Aᵀ)), A scaled to order 1."""

    law: Literal["singularity_robust"]
    """Steering law: which gimbal rates give a wanted torque."""
    damping: Weight
    """Damping λ at a singularity; a pure number."""
    decay: Weight
    """How fast λ fades away from a singularity; a pure number."""


class _Dithered(_Steering):
    damping: Weight
    """Damping λ at a singularity; a pure number."""
    decay: Weight
    """How fast λ fades away from a singularity; a pure number."""
    dither: Annotated[float, Field(ge=0, lt=1)]
    """Amplitude of the off-diagonal dither that escapes singularities; a pure number below 1."""
    dither_rate_rad_s: RateLimit
    """Angular frequency of the dither."""


class GeneralizedSingularityRobust(_Dithered):
    """Singularity-robust with a dithered damping matrix, which escapes elliptic singularities."""

    law: Literal["generalized_singularity_robust"]
    """Steering law: which gimbal rates give a wanted torque."""


class OffDiagonalSingularityRobust(_Dithered):
    """Generalised singularity-robust with off-diagonal weights too, which also escape gimbal lock."""

    law: Literal["off_diagonal_singularity_robust"]
    """Steering law: which gimbal rates give a wanted torque."""


Steering: TypeAlias = Annotated[
    MoorePenrose | SingularityRobust | GeneralizedSingularityRobust | OffDiagonalSingularityRobust,
    Field(discriminator="law"),
]


class WheelAllocation(Section):
    """How the wheels of a redundant array share what they hold: all of it is null motion, which gives no torque."""

    null_motion: Literal["none", "minimax", "preferred", "maneuver"] = "none"
    """Where null motion takes the wheels: nowhere; to the momenta whose largest share of its limit is least; to
    preferred momenta, which keep wheels away from standing still or let them turn for excitation; or along the momenta
    that the maneuver prescribes."""
    gain_1_s: Gain = 0.5
    """Rate at which it takes them there."""
    preferred_momentum_N_m_s: PerUnit[SignedMomentum] = ()
    """Preferred momentum of each wheel; an empty list: none. What differs from them by a torque stays as it is."""


class Controller(Section):
    """Tracks the maneuver's body rate; its model is the nominal platform."""

    feedback: bool
    """Whether the gyro is fed back; without, the torque is the feed-forward of the maneuver alone."""
    feedback_gain_1_s: PositiveGain | None = None
    """Rate feedback gain per unit of inertia; omitted: chosen from the gyro's noise."""
    steering: Steering
    """Which gimbal rates, and torques of wheels, give the wanted torque."""
    wheels: WheelAllocation = WheelAllocation()
    """How the reaction wheels share it."""
