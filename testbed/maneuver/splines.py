"""Clamped cubic B-splines on uniform knots, and the matrices that make them linear in their control points."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import BSpline

from testbed.arrays import Array, Series

DEGREE = 3


def clamped_spline(duration: float, control_points: Array) -> BSpline:
    """Return s(t) = Σ c_k β_k(t) on [0, duration]; it starts at the first control point and ends at the last.

    Args:
        duration: s.
        control_points: c, shape (n, ...), n ≥ 4; the spline has the trailing shape.

    Source: paper eq. (8), with the knots clamped at both ends.
    """
    inner = np.linspace(0.0, duration, len(control_points) - DEGREE + 1)
    knots = np.concatenate([np.zeros(DEGREE), inner, np.full(DEGREE, duration)])
    return BSpline(knots, np.asarray(control_points, dtype=np.float64), DEGREE)  # eq. (8)


def basis_matrix(duration: float, count: int, time: Series, derivative: int = 0) -> Array:
    """Return B, shape (N, count), so that B @ control_points samples the spline or a derivative of it.

    Args:
        duration: s.
        count: number n of control points.
        time: shape (N,), s, within [0, duration].
        derivative: its order.
    """
    return np.asarray(clamped_spline(duration, np.eye(count))(time, nu=derivative))


def derivative_points_matrix(duration: float, count: int, derivative: int) -> Array:
    """Return D, shape (count - derivative, count), so that D @ control_points are the control points of a derivative.

    A spline stays within the convex hull of its control points: what bounds them bounds the curve, between samples too.

    Args:
        duration: s.
        count: number n of control points.
        derivative: its order, 1 or 2.

    Source: paper section 3, the convex hull property.
    """
    slopes = clamped_spline(duration, np.eye(count)).derivative(derivative)
    return np.asarray(slopes.c[: count - derivative])
