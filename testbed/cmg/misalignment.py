"""Units whose gimbal axes do not stand as drawn.

A unit's gimbal frame (s0, t0, g) is turned by a about s0, then by b about the t that this has made. A turn about g
itself is the same as an error of the encoder's zero.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from testbed.arrays import Array, Axes
from testbed.cmg.cluster import Cluster


class TurnedAxes(NamedTuple):
    """Axes of turned units, each of shape (M, 3), body axes."""

    gimbal_axis_B: Axes
    spin_axis_B: Axes
    transverse_axis_B: Axes


def turned_axes(gimbal_axis_B: Axes, spin_axis_B: Axes, misalignment: Array) -> TurnedAxes:
    """Return the axes of units that are turned out of their places.

    Args:
        gimbal_axis_B: g as drawn, shape (M, 3), unit vectors, body axes.
        spin_axis_B: s0 as drawn, shape (M, 3), body axes.
        misalignment: a about s0 and b about t, shape (M, 2), rad.
    """
    transverse_axis_B = np.cross(gimbal_axis_B, spin_axis_B)
    (cos_a, cos_b), (sin_a, sin_b) = (function(misalignment).T[..., None] for function in (np.cos, np.sin))
    transverse = cos_a * transverse_axis_B + sin_a * gimbal_axis_B
    upright = cos_a * gimbal_axis_B - sin_a * transverse_axis_B  # g after the first turn
    return TurnedAxes(
        gimbal_axis_B=cos_b * upright + sin_b * spin_axis_B,
        spin_axis_B=cos_b * spin_axis_B - sin_b * upright,
        transverse_axis_B=transverse,
    )


def misaligned(cluster: Cluster, misalignment: Array) -> Cluster:
    """Return a cluster whose units are turned out of their places.

    Args:
        cluster: as drawn.
        misalignment: a about s0 and b about t, shape (M, 2), rad.
    """
    axes = turned_axes(cluster.gimbal_axis_B, cluster.spin_axis_B, misalignment)
    return replace(cluster, gimbal_axis_B=axes.gimbal_axis_B, spin_axis_B=axes.spin_axis_B)


def turning_axes(cluster: Cluster, misalignment: Array) -> Array:
    """Return the axes about which a unit turns as a or b grows, shape (2, M, 3), body axes: s0, and t once turned.

    What is fixed to a unit changes by axis × vector.

    Args:
        cluster: as drawn.
        misalignment: shape (M, 2), rad.
    """
    turned = turned_axes(cluster.gimbal_axis_B, cluster.spin_axis_B, misalignment)
    return np.stack([cluster.spin_axis_B, turned.transverse_axis_B])
