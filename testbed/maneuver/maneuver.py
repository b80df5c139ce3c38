"""A maneuver: the reference body rate and, where the design has one, the reference gimbal motion."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import BSpline

from testbed.arrays import Series, UnitSeries, Vectors3


@dataclass(frozen=True, kw_only=True)
class Reference:
    """A maneuver sampled at given times.

    Attributes:
        time: shape (N,), s.
        body_rate: ω_ref, shape (N, 3), rad/s, body axes.
        body_acceleration: its derivative, shape (N, 3), rad/s².
        gimbal_angle: preferred gimbal angles, shape (N, 6), rad; None where the design leaves them open.
        gimbal_rate: their derivative, shape (N, 6), rad/s; None likewise.
    """

    time: Series
    body_rate: Vectors3
    body_acceleration: Vectors3
    gimbal_angle: UnitSeries | None
    gimbal_rate: UnitSeries | None


@dataclass(frozen=True, kw_only=True)
class Maneuver:
    """A reference profile on [0, duration], held at its end values outside.

    Attributes:
        name: what the maneuver is called in reports.
        duration: s.
        body_rate: vector-valued spline ω_ref(t), 3 components, rad/s, body axes.
        gimbal_angle: vector-valued spline d_ref(t), 6 components, rad; None where left open.
    """

    name: str
    duration: float
    body_rate: BSpline
    gimbal_angle: BSpline | None = None

    def reference(self, time: Series) -> Reference:
        """Sample the maneuver. Rates of change are zero outside [0, duration].

        Args:
            time: shape (N,), s; need not be sorted.
        """
        gimbal = self.gimbal_angle
        return Reference(
            time=time,
            body_rate=self._value(self.body_rate, time),
            body_acceleration=self._slope(self.body_rate, time),
            gimbal_angle=None if gimbal is None else self._value(gimbal, time),
            gimbal_rate=None if gimbal is None else self._slope(gimbal, time),
        )

    def _value(self, spline: BSpline, time: Series) -> Vectors3:
        return np.asarray(spline(np.clip(time, 0.0, self.duration)))

    def _slope(self, spline: BSpline, time: Series) -> Vectors3:
        inside = (time >= 0.0) & (time <= self.duration)
        return np.asarray(spline(np.clip(time, 0.0, self.duration), nu=1)) * inside[:, None]
