"""A flight that could be flown next: how it is released, and the path of its gimbals."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import BSpline

from testbed.arrays import Array, Units, Vector3
from testbed.maneuver.splines import clamped_spline

_STILL = 1e-9
"""rad/s and rad: less is none, as scenarios are written with nine digits."""


@dataclass(frozen=True, kw_only=True, eq=False)
class NextFlight:
    """A release and a cubic spline of gimbal angles.

    Attributes:
        body_rate: ω at release, shape (3,), rad/s, body axes.
        control_points: of the gimbal angles, shape (n, 6), rad; the first two alike, and the last two: the gimbals
            stand still at both ends.
        duration: s.
    """

    body_rate: Vector3
    control_points: Array
    duration: float

    @property
    def gimbal_angle(self) -> BSpline:
        """The path, rad, on [0, duration]."""
        return clamped_spline(self.duration, self.control_points)

    @property
    def initial_gimbal_angle(self) -> Units:
        """At release, shape (6,), rad."""
        return np.asarray(self.control_points[0])

    @property
    def released_as(self) -> str:
        """How the platform is let go, in words."""
        spin = float(np.linalg.norm(self.body_rate))
        if spin > _STILL:
            rates = ", ".join(f"{rate:.3g}" for rate in self.body_rate)
            return f"with a spin of {spin:.2g} rad/s, ({rates}) in body axes"
        if np.abs(self.initial_gimbal_angle).max() > _STILL:
            angles = ", ".join(f"{angle:.2f}" for angle in self.initial_gimbal_angle)
            return f"at rest with the cluster holding momentum: gimbals at {angles} rad"
        return "at rest"
