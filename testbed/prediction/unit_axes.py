"""A body rate in the axes of the units, which turn with their gimbals: s the spin axis, t = g × s across it."""

from __future__ import annotations

import numpy as np

from testbed.arrays import Array
from testbed.prediction.grid import Gimbals, at_nodes


def rate_across(gimbal_axis_B: Array, spin_axis_B: Array, angle: Array, body_rate: Array) -> tuple[Array, Array]:
    """Return ω·s and ω·t of every unit, each of shape (..., N, 6), rad/s, or of what is given as ω.

    Args:
        gimbal_axis_B: g, shape (..., 6, 3), body axes.
        spin_axis_B: s at gimbal angle zero, alike.
        angle: d, shape (..., N, 6), rad.
        body_rate: ω, shape (..., N, 3), rad/s.
    """
    along = body_rate @ np.swapaxes(spin_axis_B, -1, -2)
    across = body_rate @ np.swapaxes(np.cross(gimbal_axis_B, spin_axis_B), -1, -2)
    cosine, sine = np.cos(angle), np.sin(angle)
    return cosine * along + sine * across, cosine * across - sine * along


def along_units(gimbals: Gimbals, body_rate: Array, run: int) -> tuple[Array, Array]:
    """Return ω·s and ω·t of a run's gimbals at the nodes, each of shape (P, M + 1, 6), rad/s."""
    return rate_across(gimbals.gimbal_axis_B, gimbals.spin_axis_B, at_nodes(gimbals.angle, run), body_rate)
