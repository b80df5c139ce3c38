"""The law of the gimbals' servo: the controller flies it, and the prediction of the gimbals' angles follows it.

A tachometer loop inside each motor, of bandwidth ω_b, and a loop on the encoder around it make the angle's error e obey
ë + ω_b ė + ω_n² e = 0. The tachometer loop's set point is ḋ_s = ḋ_c + (ω_n² / ω_b) (d_c - d̄) within the rate limit; the
commanded angle d_c is the integral of the commanded rate ḋ_c, kept within a bound of the measured angle d̄.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from testbed.arrays import Array


@dataclass(frozen=True, kw_only=True)
class ServoLaw:
    """Numbers of the law, the same for every gimbal.

    Attributes:
        bandwidth: ω_b of the tachometer loop inside the motor, 1/s.
        stiffness: ω_n² of the loop on the encoder, 1/s².
        rate_limit: largest set point of the tachometer loop, rad/s.
    """

    bandwidth: float
    stiffness: float
    rate_limit: float

    @property
    def angle_error_bound(self) -> float:
        """How far the commanded angle may run ahead of a motor at its limit (anti-wind-up), rad: the limit over ω_n."""
        return float(self.rate_limit / np.sqrt(self.stiffness))


def stiffness_of(bandwidth: float, damping_ratio: float) -> float:
    """Return ω_n², 1/s², with ω_n = ω_b / (2 ζ).

    Args:
        bandwidth: ω_b, 1/s.
        damping_ratio: ζ of the poles.
    """
    return (bandwidth / (2.0 * damping_ratio)) ** 2


def set_point(commanded_rate: Array, angle_error: Array, angle_gain: Array | float) -> Array:
    """Return the tachometer loop's set point before its limit, rad/s.

    Args:
        commanded_rate: ḋ_c, shape (..., M), rad/s.
        angle_error: d_c - d̄, shape (..., M), rad.
        angle_gain: ω_n² / ω_b, 1/s.
    """
    return np.asarray(commanded_rate + angle_gain * angle_error)


def within(value: Array, bound: float) -> Array:
    """Return values cut at ±bound; by their real parts, so that derivatives by complex step pass or stop there."""
    return np.asarray(np.minimum(np.maximum(value, -bound), bound))


def next_commanded_angle(
    commanded_angle: Array, angle: Array, bound: float, commanded_rate: Array, period: float
) -> Array:
    """Return d_c a period later: it never runs away from a gimbal that cannot follow.

    Args:
        commanded_angle: d_c, shape (..., M), rad.
        angle: d̄, shape (..., M), rad.
        bound: between the two, rad.
        commanded_rate: ḋ_c of the period, shape (..., M), rad/s.
        period: s.
    """
    followed = np.minimum(np.maximum(commanded_angle, angle - bound), angle + bound)
    return np.asarray(followed + period * commanded_rate)
