"""Attitude from body rate: the kinematic equation Ṙ = R ω×, integrated on the rotation group."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import CubicSpline

from testbed.arrays import Quaternions, Series, Vectors3
from testbed.rotation.quaternion import exponential, quaternion_product


def integrate_attitude(time: Series, body_rate: Vectors3) -> Quaternions:
    """Return the attitude at each sample relative to the first, shape (N, 4), scalar first.

    The samples are joined by a cubic spline, and each interval is turned by the fourth-order Magnus expansion
    φ = ∫ω dt + Δt²/12 ω₀ × ω₁, so that the result stays a rotation whatever the noise.

    Args:
        time: shape (N,), s, N ≥ 2.
        body_rate: ω, shape (N, 3), rad/s, body axes.
    """
    angle = np.diff(CubicSpline(time, body_rate).antiderivative()(time), axis=0)
    coning = np.diff(time)[:, None] ** 2 / 12.0 * np.cross(body_rate[:-1], body_rate[1:])
    return _running_product(exponential(np.vstack([np.zeros(3), angle + coning])))


def _running_product(steps: Quaternions) -> Quaternions:
    """Return steps[0] ⊗ … ⊗ steps[k] for every k, in log2(N) vectorised passes."""
    product = steps.copy()
    reach = 1
    while reach < len(product):
        product[reach:] = quaternion_product(product[:-reach], product[reach:])
        reach *= 2
    return product
