"""The share of the cluster's momentum envelope that a momentum uses, smooth enough for an optimiser."""

from __future__ import annotations

import casadi as ca
import numpy as np

from testbed.arrays import Matrix3
from testbed.cmg.cluster import Cluster

_AT_REST = 1e-3
"""Keeps the roots differentiable where the cluster carries no momentum; the normal is of order 0.1 where the envelope
is near."""


def envelope_share_function(cluster: Cluster) -> ca.Function:
    """Return max over u of (u·h)/support(u) as a function of h, shape (3,); 1 on the envelope, right within 1 %.

    The direction that comes closest to cutting h off is the normal u of the surface beyond it. The surface lies at
    ∇support(u) = Q(u) u, Q(u) = Σ |h_i| (I - g gᵀ)/sqrt(|u|² - (u·g)²): so u follows from h by repeated substitution,
    and an error of u is squared in the share. One row at each instant takes the place of dozens of fixed directions.
    Of parallel gimbals the envelope is a disc, and what little the gimbals carry along their axis is left out.

    Args:
        cluster: the units, two or more: the momentum of one is always on its envelope.
    """
    momentum = ca.SX.sym("momentum", 3)
    flat = _without_envelope(cluster)
    within, filled = np.eye(3) - flat, np.abs(cluster.rotor_momentum).sum() * flat

    def normal_to(weight: ca.SX) -> ca.SX:
        found: ca.SX = ca.solve(_surface(cluster, weight) + filled, within @ momentum)
        return found

    normal = normal_to(ca.SX.ones(len(cluster.rotor_momentum)))
    normal = normal_to(1.0 / _across(cluster, normal))
    support = ca.dot(np.abs(cluster.rotor_momentum), _across(cluster, normal))
    return ca.Function("envelope_share", [momentum], [ca.dot(normal, momentum) / support])


_PARALLEL = 1e-9
"""Square of the sine between gimbal axes below which they are parallel: above rounding, below any mounting error."""


def _without_envelope(cluster: Cluster) -> Matrix3:
    """Return g gᵀ of gimbals that are all parallel, along which the rotors carry nothing; else zero."""
    share, axes = np.linalg.eigh(cluster.gimbal_axis_B.T @ cluster.gimbal_axis_B / len(cluster.gimbal_axis_B))
    return np.outer(axes[:, -1], axes[:, -1]) if share[-1] > 1.0 - _PARALLEL else np.zeros((3, 3))


def _surface(cluster: Cluster, weight: ca.SX) -> ca.SX:
    """Q = Σ weight |h_i| (I - g gᵀ)."""
    strength = weight * ca.DM(np.abs(cluster.rotor_momentum))
    gimbal = ca.DM(cluster.gimbal_axis_B.T)
    return ca.sum1(strength) * ca.SX.eye(3) - gimbal @ ca.diag(strength) @ gimbal.T


def _across(cluster: Cluster, normal: ca.SX) -> ca.SX:
    """Length of u across each gimbal axis, sqrt(|u|² - (u·g)²)."""
    along = ca.DM(cluster.gimbal_axis_B) @ normal
    return ca.sqrt(ca.sumsqr(normal) - along**2 + _AT_REST**2)
