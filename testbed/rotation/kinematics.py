"""Attitude from body rate: the kinematic equation Ṙ = R ω×, integrated on the rotation group."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import BSpline, CubicSpline

from testbed.arrays import Quaternions, Series, Vectors3
from testbed.compiled import LONG, compiled
from testbed.rotation.quaternion import exponential, quaternion_product


def integrate_attitude(time: Series, body_rate: Vectors3, corners: BSpline | None = None) -> Quaternions:
    """Return the attitude at each sample relative to the first, shape (..., N, 4), scalar first.

    The samples are joined by a cubic spline, and each interval is turned by the fourth-order Magnus expansion
    φ = ∫ω dt + Δt²/12 ω₀ × ω₁, so that the result stays a rotation whatever the noise.

    Args:
        time: shape (N,), s, N ≥ 2.
        body_rate: ω, shape (..., N, 3), rad/s, body axes; of motions side by side on leading axes.
        corners: part of it that is not smooth between the samples; the rest is. None where all of it is smooth.
    """
    smooth = body_rate if corners is None else body_rate - corners(time)
    angle = np.diff(CubicSpline(time, smooth, axis=-2).antiderivative()(time), axis=-2)
    if corners is not None:
        angle = angle + np.diff(corners.antiderivative()(time), axis=-2)
    coning = np.diff(time)[:, None] ** 2 / 12.0 * np.cross(body_rate[..., :-1, :], body_rate[..., 1:, :])
    turns = np.zeros(body_rate.shape)
    turns[..., 1:, :] = angle + coning
    return _running_product(exponential(turns))


def _running_product(steps: Quaternions) -> Quaternions:
    """Return steps[0] ⊗ … ⊗ steps[k] for every k, in log2(N) vectorised passes, or one by one where they are many."""
    product, samples = steps.copy(), steps.shape[-2]
    if samples > LONG:
        for motion in product.reshape(-1, samples, 4):
            compiled(_turn_on)(motion)
        return product
    reach = 1
    while reach < samples:
        product[..., reach:, :] = quaternion_product(product[..., :-reach, :], product[..., reach:, :])
        reach *= 2
    return product


def _turn_on(product: Quaternions) -> None:
    """Turn each quaternion on from the product before it, kept at unit length against rounding."""
    for last in range(len(product) - 1):
        before, turned = product[last], product[last + 1]
        a, b, c, d = before[0], before[1], before[2], before[3]
        e, f, g, h = turned[0], turned[1], turned[2], turned[3]
        w, x = a * e - b * f - c * g - d * h, a * f + b * e + c * h - d * g
        y, z = a * g - b * h + c * e + d * f, a * h + b * g - c * f + d * e
        length = (w * w + x * x + y * y + z * z) ** 0.5
        turned[0], turned[1], turned[2], turned[3] = w / length, x / length, y / length, z / length
