"""The torque by which gravity turns a body on a circular orbit: the near side of it is pulled a little more."""

from __future__ import annotations

import numpy as np

from testbed.arrays import Matrix3, Vectors3
from testbed.rotation.vectors import cross


def gravity_gradient_torque(inertia: Matrix3, outward_B: Vectors3, orbit_rate: float) -> Vectors3:
    """Return 3 n² r × J r about the centre of mass, shape (..., 3), N·m, body axes; n² = μ / R³.

    The first term in the body's size over the orbit's radius R. Source: Wie, Space Vehicle Dynamics and Control,
    ch. 6.10.

    Args:
        inertia: J about the centre of mass, shape (3, 3) or (..., 3, 3), kg·m², body axes.
        outward_B: r, unit vectors from the Earth's centre to the body, or reversed, shape (..., 3), body axes.
        orbit_rate: n, rad/s.
    """
    outward_B = np.asarray(outward_B)
    return np.asarray(3.0 * orbit_rate**2 * cross(outward_B, np.matvec(inertia, outward_B)))
