"""What the CMG units hold: their momentum and their share of the inertia, for any axes, angles and rotor speeds."""

from __future__ import annotations

import numpy as np

from testbed.arrays import Array
from testbed.prediction.grid import Gimbals


def held_momentum(gimbals: Gimbals) -> Array:
    """Return h = Σ (Js Ω s(d) + (Jg + Jt) ḋ g), shape (R, P, T, 3), N·m·s, body axes.

    Not h0 Σ s(d), which omits the gimbals' own momentum and biases J (docs/explanation/pitfalls.md).
    """
    along = gimbals.rotor_momentum * np.cos(gimbals.angle)
    across = gimbals.rotor_momentum * np.sin(gimbals.angle)
    turning = gimbals.cluster.gimbal_axis_inertia * gimbals.rate
    transverse_B = np.cross(gimbals.gimbal_axis_B, gimbals.spin_axis_B)
    return along @ gimbals.spin_axis_B + across @ transverse_B + turning @ gimbals.gimbal_axis_B


def held_inertia(gimbals: Gimbals) -> Array:
    """Return J(d) - J(0) = Σ (Js - Jt)(s sᵀ - s0 s0ᵀ), shape (R, P, T, 3, 3), kg·m².

    With c = cos d and σ = sin d, s sᵀ - s0 s0ᵀ = σ² (t tᵀ - s0 s0ᵀ) + c σ (s0 tᵀ + t s0ᵀ).
    """
    cluster = gimbals.cluster
    weight = cluster.rotor_spin_inertia - cluster.rotor_transverse_inertia
    spin_B = gimbals.spin_axis_B
    transverse_B = np.cross(gimbals.gimbal_axis_B, spin_B)
    cross = _outer(spin_B, transverse_B)
    square = (_outer(transverse_B, transverse_B) - _outer(spin_B, spin_B)).reshape(len(spin_B), -1, 9)
    mixed = (cross + np.swapaxes(cross, -1, -2)).reshape(len(spin_B), -1, 9)
    sine, cosine = np.sin(gimbals.angle), np.cos(gimbals.angle)
    change = (weight * sine**2) @ square + (weight * sine * cosine) @ mixed
    return np.asarray(change.reshape(*change.shape[:-1], 3, 3))


def _outer(left: Array, right: Array) -> Array:
    return np.asarray(left[..., :, None] * right[..., None, :])
