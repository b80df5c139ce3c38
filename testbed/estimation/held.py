"""Torques that are held from sample to sample, and jump between them: what they give, exactly, on even grids."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import BSpline, make_interp_spline

from testbed.arrays import Array, Matrix3, Series


def impulse_of_held(middle: Series, samples: Array, axis: int = 0) -> BSpline:
    """Return the impulse that held samples have given since the first began.

    Args:
        middle: of the periods over which they are held, shape (K,), s.
        samples: shape (K, C), or with K on another axis.
        axis: along which they follow each other.
    """
    between = 0.5 * (middle[:-1] + middle[1:])
    edges = np.concatenate([[2.0 * middle[0] - between[0]], between, [2.0 * middle[-1] - between[-1]]])
    gained = np.cumsum(np.moveaxis(samples, axis, 0).T * np.diff(edges), axis=-1).T
    impulse = np.concatenate([np.zeros_like(gained[:1]), gained])
    return make_interp_spline(edges, np.moveaxis(impulse, 0, axis), k=1, axis=axis)


def corners_of(impulse: BSpline, inertia: Matrix3) -> BSpline:
    """Return the body rate that a held torque gives an inertia at rest, rad/s: it bends wherever the torque jumps.

    A measured rate less that of an inertia near the true one is smooth, and can be joined by a cubic spline.

    Args:
        impulse: as of `impulse_of_held`, N·m·s, body axes.
        inertia: shape (3, 3), kg·m².
    """
    by_axis = np.moveaxis(impulse.c, impulse.axis, -2) @ np.linalg.inv(inertia).T
    return BSpline(impulse.t, np.moveaxis(by_axis, -2, impulse.axis), impulse.k, axis=impulse.axis)


def along_steps(impulse: BSpline, at: Series) -> Array:
    """Return what is held along the grid of an integration, shape (T, C), on the impulse's axis.

    At nodes the mean about them stands; between two of them what makes the integration's rule, a sixth, four sixths and
    a sixth, give the step the very impulse that was held.

    Args:
        impulse: as of `impulse_of_held`.
        at: every half step, the last a node, shape (T,), s.
    """
    step, first = 2.0 * (at[1] - at[0]), (len(at) - 1) % 2
    reach = step / 6.0
    found = np.moveaxis((impulse(at + reach) - impulse(at - reach)) / (2.0 * reach), impulse.axis, 0)
    mean = np.moveaxis(np.diff(impulse(at[first::2]), axis=impulse.axis) / step, impulse.axis, 0)
    found[first + 1 :: 2] = (6.0 * mean - found[first:-1:2] - found[first + 2 :: 2]) / 4.0
    return np.asarray(np.moveaxis(found, 0, impulse.axis))
