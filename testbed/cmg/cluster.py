"""Geometry and momentum of a cluster of single-gimbal control moment gyros, in body axes.

All functions broadcast over leading axes of the gimbal angles, so that one sample, a time series or a batch of
platforms go through the same code.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from testbed.arrays import Array, Axes, Matrices3, Matrix3, Units, UnitSeries, Vectors3


@dataclass(frozen=True, kw_only=True)
class Cluster:
    """Axes and inertias of the CMG units; M units, six on the shipped platform.

    Attributes:
        gimbal_axis_B: g, shape (M, 3), unit vectors, body axes.
        spin_axis_B: s at gimbal angle zero, shape (M, 3), body axes.
        rotor_momentum: nominal Js·Ω, shape (M,), N·m·s, Ω relative to the gimbal.
        rotor_spin_inertia: Js, shape (M,), kg·m², about the spin axis.
        rotor_transverse_inertia: Jt, shape (M,), kg·m², about any axis normal to it.
        gimbal_inertia: Jg, shape (M,), kg·m², of the gimbal body about the gimbal axis, rotor not included.
        position_B: of the rotors' centres from the platform's centre of mass, shape (M, 3), m, body axes; None where it
            is not known, which only a rotor's imbalance asks for.
    """

    gimbal_axis_B: Axes
    spin_axis_B: Axes
    rotor_momentum: Units
    rotor_spin_inertia: Units
    rotor_transverse_inertia: Units
    gimbal_inertia: Units
    position_B: Axes | None = None

    @cached_property
    def transverse_axis_B(self) -> Axes:
        """Transverse axes t = g × s at gimbal angle zero, shape (M, 3)."""
        return np.cross(self.gimbal_axis_B, self.spin_axis_B)

    @cached_property
    def axes_by_column(self) -> tuple[Array, Array]:
        """Spin and transverse axes at gimbal angle zero as contiguous columns, each of shape (3, M)."""
        return np.ascontiguousarray(self.spin_axis_B.T), np.ascontiguousarray(self.transverse_axis_B.T)

    @cached_property
    def gimbal_axis_inertia(self) -> Units:
        """Inertia Jg + Jt that a gimbal motor turns about its axis, shape (M,), kg·m²."""
        return self.gimbal_inertia + self.rotor_transverse_inertia


def cluster_part(cluster: Cluster, units: slice) -> Cluster:
    """Return some units of a cluster."""
    return Cluster(
        gimbal_axis_B=cluster.gimbal_axis_B[units],
        spin_axis_B=cluster.spin_axis_B[units],
        rotor_momentum=cluster.rotor_momentum[units],
        rotor_spin_inertia=cluster.rotor_spin_inertia[units],
        rotor_transverse_inertia=cluster.rotor_transverse_inertia[units],
        gimbal_inertia=cluster.gimbal_inertia[units],
        position_B=None if cluster.position_B is None else cluster.position_B[units],
    )


def spin_axes(cluster: Cluster, gimbal_angle: UnitSeries) -> Array:
    """Return s(d) = s0 cos d + t0 sin d, shape (..., M, 3), body axes."""
    cos, sin = np.cos(gimbal_angle)[..., None], np.sin(gimbal_angle)[..., None]
    return np.asarray(cluster.spin_axis_B * cos + cluster.transverse_axis_B * sin)


def transverse_axes(cluster: Cluster, gimbal_angle: UnitSeries) -> Array:
    """Return t(d) = ds/dd = -s0 sin d + t0 cos d, shape (..., M, 3), body axes."""
    cos, sin = np.cos(gimbal_angle)[..., None], np.sin(gimbal_angle)[..., None]
    return np.asarray(cluster.transverse_axis_B * cos - cluster.spin_axis_B * sin)


def cluster_momentum(
    cluster: Cluster,
    gimbal_angle: UnitSeries,
    gimbal_rate: UnitSeries,
    rotor_momentum: UnitSeries | None = None,
) -> Vectors3:
    """Return h = Σ (Js Ω s(d) + (Jg + Jt) ḋ g), shape (..., 3), N·m·s, body axes.

    The platform's total angular momentum is J(d) ω + h, with J(d) from `inertia_change`.

    Args:
        cluster: the units.
        gimbal_angle: d, shape (..., M), rad.
        gimbal_rate: ḋ, shape (..., M), rad/s.
        rotor_momentum: Js·Ω, shape (..., M), N·m·s, Ω relative to the gimbal; the nominal one where absent.
    """
    spin_momentum = cluster.rotor_momentum if rotor_momentum is None else rotor_momentum
    return np.asarray(
        (spin_momentum * np.cos(gimbal_angle)) @ cluster.spin_axis_B
        + (spin_momentum * np.sin(gimbal_angle)) @ cluster.transverse_axis_B
        + (cluster.gimbal_axis_inertia * gimbal_rate) @ cluster.gimbal_axis_B
    )


def momentum_jacobian(cluster: Cluster, gimbal_angle: UnitSeries, rotor_momentum: UnitSeries | None = None) -> Array:
    """Return A(d) = dh/dd, columns Js Ω t(d), shape (..., 3, M), N·m·s/rad.

    Args:
        cluster: the units.
        gimbal_angle: d, shape (..., M), rad.
        rotor_momentum: as in `cluster_momentum`.
    """
    spin_momentum = cluster.rotor_momentum if rotor_momentum is None else rotor_momentum
    along_transverse = spin_momentum * np.cos(gimbal_angle)
    along_spin = -spin_momentum * np.sin(gimbal_angle)
    return np.asarray(
        cluster.transverse_axis_B.T * along_transverse[..., None, :] + cluster.spin_axis_B.T * along_spin[..., None, :]
    )


def spin_momentum_and_jacobian(cluster: Cluster, gimbal_angle: UnitSeries) -> tuple[Vectors3, Array]:
    """Return Σ Js Ω s(d), shape (..., 3), and A(d), shape (..., 3, M), at nominal rotor speeds, for the price of one.

    Args:
        cluster: the units.
        gimbal_angle: d, shape (..., M), rad.
    """
    along = cluster.rotor_momentum * np.cos(gimbal_angle)
    across = cluster.rotor_momentum * np.sin(gimbal_angle)
    spin_T, transverse_T = cluster.axes_by_column
    jacobian = transverse_T * along[..., None, :] - spin_T * across[..., None, :]
    # vecmat: a matrix product of a whole batch would round one platform's row by how many platforms there are.
    return np.vecmat(along, cluster.spin_axis_B) + np.vecmat(across, cluster.transverse_axis_B), jacobian


def inertia_change(cluster: Cluster, gimbal_angle: UnitSeries) -> Matrices3:
    """Return J(d) - J(0) = Σ (Js - Jt)(s sᵀ - s0 s0ᵀ), shape (..., 3, 3), kg·m².

    J(0) is the platform's inertia with rotors locked and all gimbal angles zero, the quantity estimated.
    """
    weight = cluster.rotor_spin_inertia - cluster.rotor_transverse_inertia
    turned = spin_axes(cluster, gimbal_angle)
    outer = np.einsum("m,...mi,...mj->...ij", weight, turned, turned)
    return np.asarray(outer - np.einsum("m,mi,mj->ij", weight, cluster.spin_axis_B, cluster.spin_axis_B))


def platform_momentum(
    cluster: Cluster, inertia: Matrix3, body_rate: Vectors3, gimbal_angle: UnitSeries, gimbal_rate: UnitSeries
) -> Vectors3:
    """Return the whole platform's momentum J(d) ω + h, shape (..., 3), N·m·s, body axes; nominal rotor speeds.

    Args:
        cluster: the units.
        inertia: J with all gimbals at zero, shape (3, 3), kg·m².
        body_rate: ω, shape (..., 3), rad/s, body axes.
        gimbal_angle: d, shape (..., M), rad.
        gimbal_rate: ḋ, shape (..., M), rad/s.
    """
    turning = ((inertia + inertia_change(cluster, gimbal_angle)) @ body_rate[..., None])[..., 0]
    return np.asarray(turning + cluster_momentum(cluster, gimbal_angle, gimbal_rate))
