"""How far a cluster is from losing a torque direction, and how much momentum it can hold."""

from __future__ import annotations

import numpy as np

from testbed.arrays import Array, Series, Units, UnitSeries, Vectors3
from testbed.cmg.cluster import Cluster, momentum_jacobian


def singularity_measure(jacobian: Array, rotor_momentum: Units) -> Series:
    """Return sqrt(det(A Aᵀ)), scaled so that no gimbal angles can exceed 1; shape (...,).

    det(A Aᵀ) ≤ (trace(A Aᵀ) / 3)³ = (Σ h² / 3)³, with equality where every torque direction is equally strong.

    Args:
        jacobian: A, shape (..., 3, M), N·m·s/rad.
        rotor_momentum: shape (M,), N·m·s.

    Source: the usual manipulability measure of CMG steering, e.g. Wie, Space Vehicle Dynamics and Control, ch. 7.
    """
    determinant = np.linalg.det(jacobian @ np.swapaxes(jacobian, -1, -2))
    best = (np.sum(np.square(rotor_momentum)) / 3.0) ** 3
    return np.asarray(np.sqrt(np.maximum(determinant, 0.0) / best))


def envelope_radius(cluster: Cluster, direction_B: Vectors3) -> Series:
    """Return the support Σ |h_i| sqrt(1 - (u·g_i)²) of the momentum envelope along u, shape (...,), N·m·s.

    It bounds u·h for every set of gimbal angles at rest, and is reached by one.

    Args:
        cluster: the units.
        direction_B: u, shape (..., 3), unit vectors, body axes.
    """
    along_gimbal = np.asarray(direction_B) @ cluster.gimbal_axis_B.T
    return np.sqrt(np.maximum(1.0 - along_gimbal**2, 0.0)) @ np.abs(cluster.rotor_momentum)


def envelope_fraction(cluster: Cluster, momentum_B: Vectors3, directions_B: Vectors3) -> Series:
    """Return the largest share of the envelope that h uses, max over u of (u·h) / support(u); shape (...,).

    Args:
        cluster: the units.
        momentum_B: h, shape (..., 3), N·m·s, body axes.
        directions_B: the directions u to look along, shape (K, 3), unit vectors.
    """
    shares = np.asarray(momentum_B) @ directions_B.T / envelope_radius(cluster, directions_B)
    return np.asarray(shares.max(axis=-1))


def sphere_directions(count: int) -> Vectors3:
    """Return evenly spread unit vectors on a Fibonacci spiral, shape (count, 3)."""
    index = np.arange(count) + 0.5
    height = 1.0 - 2.0 * index / count
    azimuth = np.pi * (1.0 + np.sqrt(5.0)) * index
    radius = np.sqrt(1.0 - height**2)
    return np.stack([radius * np.cos(azimuth), radius * np.sin(azimuth), height], axis=-1)


def null_space(cluster: Cluster, gimbal_angle: UnitSeries) -> Array:
    """Return an orthonormal basis of the gimbal rates that give no torque, shape (M, M - 3).

    Args:
        cluster: the units.
        gimbal_angle: d, shape (M,), rad, not singular.
    """
    return np.asarray(np.linalg.svd(momentum_jacobian(cluster, gimbal_angle))[2][3:].T)
