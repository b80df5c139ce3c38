"""A maneuver: the reference body rate and, where the design has one, the reference motion of gimbals and wheels."""

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
        gimbal_angle: preferred gimbal angles, shape (N, M), rad; None where the design leaves them open.
        gimbal_rate: their derivative, shape (N, M), rad/s; None likewise.
        wheel_momentum: preferred Jw Ω, shape (N, W), N·m·s; None where the design leaves it open.
        wheel_momentum_rate: its derivative, shape (N, W), N·m; None likewise.
    """

    time: Series
    body_rate: Vectors3
    body_acceleration: Vectors3
    gimbal_angle: UnitSeries | None
    gimbal_rate: UnitSeries | None
    wheel_momentum: UnitSeries | None
    wheel_momentum_rate: UnitSeries | None


@dataclass(frozen=True, kw_only=True)
class Maneuver:
    """A reference profile on [0, duration], held at its end values outside.

    Attributes:
        name: what the maneuver is called in reports.
        duration: s.
        body_rate: vector-valued spline ω_ref(t), 3 components, rad/s, body axes.
        gimbal_angle: vector-valued spline d_ref(t), M components, rad; None where left open.
        wheel_momentum: vector-valued spline of Jw Ω, W components, N·m·s; None where left open.
    """

    name: str
    duration: float
    body_rate: BSpline
    gimbal_angle: BSpline | None = None
    wheel_momentum: BSpline | None = None

    @property
    def splines(self) -> tuple[BSpline, ...]:
        """All that are given: of the body rate, then of the actuators' motions."""
        return tuple(each for each in (self.body_rate, self.gimbal_angle, self.wheel_momentum) if each is not None)

    def reference(self, time: Series) -> Reference:
        """Sample the maneuver. Rates of change are zero outside [0, duration].

        Args:
            time: shape (N,), s; need not be sorted.
        """
        gimbal, wheel = self.gimbal_angle, self.wheel_momentum
        return Reference(
            time=time,
            body_rate=self._value(self.body_rate, time),
            body_acceleration=self._slope(self.body_rate, time),
            gimbal_angle=None if gimbal is None else self._value(gimbal, time),
            gimbal_rate=None if gimbal is None else self._slope(gimbal, time),
            wheel_momentum=None if wheel is None else self._value(wheel, time),
            wheel_momentum_rate=None if wheel is None else self._slope(wheel, time),
        )

    def _value(self, spline: BSpline, time: Series) -> Vectors3:
        return np.asarray(spline(np.clip(time, 0.0, self.duration)))

    def _slope(self, spline: BSpline, time: Series) -> Vectors3:
        inside = (time >= 0.0) & (time <= self.duration)
        return np.asarray(spline(np.clip(time, 0.0, self.duration), nu=1)) * inside[:, None]
