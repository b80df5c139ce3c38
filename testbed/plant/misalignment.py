"""Gimbal axes that do not stand as the model draws them."""

from __future__ import annotations

import mujoco
import numpy as np

from testbed.arrays import Array
from testbed.plant.geometry import unit_names
from testbed.rotation.quaternion import exponential, quaternion_product


def turn_units(spec: mujoco.MjSpec, misalignment: Array) -> None:
    """Turn every unit by a about its x axis (s0), then by b about the y axis (t) that this has made.

    Args:
        spec: the platform; each gimbal body stands in its mount with x along s0 and z along g.
        misalignment: a and b, shape (M, 2), rad, as in `testbed.cmg.misalignment`.
    """
    for name, (about_spin, about_transverse) in zip(unit_names("gimbal", len(misalignment)), misalignment, strict=True):
        first = exponential(np.array([about_spin, 0.0, 0.0]))
        second = exponential(np.array([0.0, about_transverse, 0.0]))
        body = spec.body(name)
        body.quat = quaternion_product(body.quat, quaternion_product(first, second))
