"""A flight that could be flown next: how it is released, and how gimbals and wheels turn."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, NamedTuple, TypeAlias

import numpy as np
from scipy.interpolate import BSpline, CubicSpline

from testbed.arrays import Array, Quaternion, Series, Units, UnitSeries, Vector3

Path: TypeAlias = Literal["gimbal", "actuator", "body_rate"]
"""What a flight's control points describe, as `maneuver.parametrization` of scenarios."""
_DIGITS = 9
"""With which scenarios are written."""
_STILL = 10.0**-_DIGITS
"""rad/s, rad and N·m·s: less is none."""


class Release(NamedTuple):
    """How a platform is let go.

    Attributes:
        body_rate: ω, shape (3,), rad/s, body axes.
        motion: gimbal angles, rad, then wheel momenta, N·m·s, shape (M + W,).
    """

    body_rate: Vector3
    motion: Units


@dataclass(frozen=True, kw_only=True, eq=False)
class NextFlight:
    """A release and a cubic spline.

    Attributes:
        body_rate: ω at release, shape (3,), rad/s, body axes.
        attitude: quat_NB at release.
        path: what the spline describes.
        control_points: of gimbal angles, rad, and wheel momenta, N·m·s, or of the body rate, rad/s, shape (n, K). The
            first two are alike, and the last two: all stands still at both ends.
        duration: s.
        motion: gimbal angles, rad, then wheel momenta, N·m·s, as splines of M + W components on [0, duration].
        units: M.
    """

    body_rate: Vector3
    attitude: Quaternion
    path: Path
    control_points: Array
    duration: float
    motion: BSpline | CubicSpline
    units: int

    def gimbal_angle(self, time: Series | float, derivative: int = 0) -> UnitSeries:
        """Return the gimbal angles at given times, or a derivative, shape (..., M), rad."""
        return np.asarray(self.motion(time, derivative)[..., : self.units])

    def wheel_momentum(self, time: Series | float, derivative: int = 0) -> UnitSeries:
        """Return the wheels' momenta at given times, or a derivative, shape (..., W), N·m·s."""
        return np.asarray(self.motion(time, derivative)[..., self.units :])

    @property
    def release(self) -> Release:
        """How the platform is let go."""
        return Release(self.body_rate, np.asarray(self.motion(0.0)))

    @property
    def initial_gimbal_angle(self) -> Units:
        """At release, shape (M,), rad."""
        return self.release.motion[: self.units]

    @property
    def initial_wheel_momentum(self) -> Units:
        """At release, shape (W,), N·m·s."""
        return self.release.motion[self.units :]

    @property
    def released_as(self) -> str:
        """How the platform is let go, in words."""
        spin = float(np.linalg.norm(self.body_rate))
        angles, momenta = self.initial_gimbal_angle, self.initial_wheel_momentum
        gimbals = [f"gimbals at {_listed(angles, '.2f')} rad"] if np.abs(angles).max(initial=0.0) > _STILL else []
        wheels = [f"wheels at {_listed(momenta, '.3g')} N·m·s"] if np.abs(momenta).max(initial=0.0) > _STILL else []
        if spin > _STILL:
            turning = f"with a spin of {spin:.2g} rad/s, ({_listed(self.body_rate, '.3g')}) in body axes"
            return ", ".join([turning, *([" and ".join(gimbals + wheels)] if wheels else [])])
        if wheels:
            return f"at rest with {' and '.join(gimbals + wheels)}"
        return f"at rest with the cluster holding momentum: {gimbals[0]}" if gimbals else "at rest"


def _listed(values: Array, digits: str) -> str:
    return ", ".join(f"{round(float(value), _DIGITS) + 0.0:{digits}}" for value in values)
