"""The drives of reaction wheels: torque demands that make each wheel gain momentum as asked, and null motion."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, NamedTuple, TypeAlias

import numpy as np

from testbed.arrays import Units, UnitSeries, Vectors3
from testbed.cmg.wheels import Wheels, minimax_allocation, wheel_momentum

WheelNullMotion: TypeAlias = Literal["none", "minimax", "preferred", "maneuver"]


@dataclass(frozen=True, kw_only=True)
class WheelDrive:
    """What the controller knows of the drives of W wheels, and where null motion takes these.

    Attributes:
        viscous_friction: of each bearing, shape (W,), N·m·s/rad; it is made up for.
        loop_gain: of the loop on a wheel's speed inside its drive, shape (W,), N·m·s/rad; 0 for none.
        null_motion: nowhere, to the minimax allocation, to preferred momenta, or along the maneuver's.
        null_gain: rate at which it takes them there, 1/s.
        preferred: momenta, shape (W,), N·m·s.
    """

    viscous_friction: Units
    loop_gain: Units
    null_motion: WheelNullMotion
    null_gain: float
    preferred: Units


class WheelReference(NamedTuple):
    """What a maneuver prescribes of W wheels.

    Attributes:
        momentum: Jw Ω, shape (W,), N·m·s.
        rate: of it, shape (W,), N·m.
    """

    momentum: Units
    rate: Units


def preferred_torques(drive: WheelDrive, wheels: Wheels, momentum: UnitSeries, reference: WheelReference) -> UnitSeries:
    """Return torques toward what null motion prefers, shape (..., W), N·m; only their share without torque is flown.

    Args:
        drive: what it prefers.
        wheels: the array.
        momentum: Jw Ω as measured, shape (..., W), N·m·s.
        reference: of the maneuver; it is looked at where null motion goes along it.
    """
    match drive.null_motion:
        case "none":
            return np.zeros_like(momentum)
        case "minimax":
            wanted = minimax_allocation(wheels, wheel_momentum(wheels, momentum), wheels.momentum_limit)
        case "preferred":
            wanted = drive.preferred
        case "maneuver":
            return np.asarray(reference.rate + drive.null_gain * (reference.momentum - momentum))
    return np.asarray(drive.null_gain * (wanted - momentum))


def wheel_demand(
    drive: WheelDrive,
    wheels: Wheels,
    momentum_rate: UnitSeries,
    momentum: UnitSeries,
    commanded: UnitSeries,
    reference_acceleration: Vectors3,
) -> tuple[UnitSeries, UnitSeries]:
    """Return the torque that every motor should give, and the demand that its drive is sent, both (..., W), N·m.

    Jw (Ω̇ + a·ω̇) = τ - c Ω: the wheel gains what it should, turns along with the body, and its friction is made up for.
    A drive with a loop on its speed is sent the torque at which this loop is at rest at the commanded speed.

    Args:
        drive: friction and loop.
        wheels: the array.
        momentum_rate: of Jw Ω, shape (..., W), N·m.
        momentum: Jw Ω as measured, shape (..., W), N·m·s.
        commanded: the integral of the momentum rates, shape (..., W), N·m·s.
        reference_acceleration: ω̇_ref, shape (..., 3), rad/s², body axes.
    """
    speed = momentum / wheels.spin_inertia
    along = reference_acceleration @ wheels.axis_B.T
    feed_forward = momentum_rate + wheels.spin_inertia * along + drive.viscous_friction * speed
    wanted_speed = commanded / wheels.spin_inertia
    return feed_forward + drive.loop_gain * (wanted_speed - speed), feed_forward + drive.loop_gain * wanted_speed


def next_commanded_momentum(
    drive: WheelDrive, wheels: Wheels, commanded: UnitSeries, momentum: UnitSeries, rate: UnitSeries, period: float
) -> UnitSeries:
    """Integrate the commanded momentum; it runs ahead of a wheel by no more than its motor's limit corrects.

    Args:
        drive: loop.
        wheels: the array.
        commanded: at the start of the period, shape (..., W), N·m·s.
        momentum: Jw Ω as measured there, shape (..., W), N·m·s.
        rate: of the period, shape (..., W), N·m.
        period: s.
    """
    ahead = wheels.torque_limit * wheels.spin_inertia / np.where(drive.loop_gain > 0.0, drive.loop_gain, np.inf)
    bounded = np.clip(commanded, momentum - ahead, momentum + ahead)
    return np.asarray(np.clip(bounded + rate * period, -wheels.momentum_limit, wheels.momentum_limit))
