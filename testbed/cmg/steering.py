"""Steering laws: which gimbal rates give a wanted change of the cluster's momentum.

All laws share one role, `SteeringLaw`: an inverse of the momentum Jacobian. Null motion toward preferred gimbal
angles is added alike to each. Jacobians are scaled by the cluster's momentum, so that the laws' constants have no unit.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from testbed.arrays import Array, Flags, Units, UnitSeries, Vectors3

_FLOOR = 1e-12 * np.eye(3)
"""Keeps an exactly singular A Aᵀ invertible; the rates it then gives are far beyond any limit, and recorded so."""
_PHASES = np.array([0.0, np.pi / 2, np.pi])


class SteeringLaw(Protocol):
    """A right inverse of A, exact or regularised."""

    def inverse(self, jacobian: Array, time: float) -> Array:
        """Return A#, shape (..., M, 3), of a Jacobian scaled to order one, shape (..., 3, M), at a time in s."""
        ...


@dataclass(frozen=True, kw_only=True)
class MoorePenrose:
    """A# = Aᵀ (A Aᵀ)⁻¹: the smallest gimbal rates, unbounded at a singularity."""

    def inverse(self, jacobian: Array, time: float) -> Array:  # noqa: ARG002 - the role's signature
        """See `SteeringLaw`."""
        transposed = np.swapaxes(jacobian, -1, -2)
        return transposed @ np.linalg.inv(jacobian @ transposed + _FLOOR)


@dataclass(frozen=True, kw_only=True)
class SingularityRobust:
    """A# = Aᵀ (A Aᵀ + λ 1)⁻¹ with λ = λ0 exp(-μ det(A Aᵀ)).

    Attributes:
        damping: λ0.
        decay: μ.

    Source: Nakamura and Hanafusa (1986); Bedrossian et al. (1990), SR inverse.
    """

    damping: float = 0.01
    decay: float = 10.0

    def inverse(self, jacobian: Array, time: float) -> Array:  # noqa: ARG002 - the role's signature
        """See `SteeringLaw`."""
        transposed = np.swapaxes(jacobian, -1, -2)
        gram = jacobian @ transposed
        return transposed @ np.linalg.inv(gram + _damping(self.damping, self.decay, gram) * np.eye(3))


@dataclass(frozen=True, kw_only=True)
class GeneralizedSingularityRobust:
    """A# = Aᵀ (A Aᵀ + λ E)⁻¹, E = [[1, ε3, ε2], [ε3, 1, ε1], [ε2, ε1, 1]], ε_i = ε0 sin(Ω t + φ_i).

    The dither ε escapes elliptic internal singularities where the SR inverse would lock.

    Attributes:
        damping: λ0.
        decay: μ.
        dither: ε0.
        dither_rate: Ω, rad/s.

    Source: Wie, Bailey and Heiberg (2001), "Singularity robust steering logic for redundant single-gimbal CMGs".
    """

    damping: float = 0.01
    decay: float = 10.0
    dither: float = 0.1
    dither_rate: float = np.pi / 2

    def inverse(self, jacobian: Array, time: float) -> Array:
        """See `SteeringLaw`."""
        transposed = np.swapaxes(jacobian, -1, -2)
        gram = jacobian @ transposed
        dithered = _dither_matrix(self.dither, self.dither_rate, time)
        return transposed @ np.linalg.inv(gram + _damping(self.damping, self.decay, gram) * dithered)


@dataclass(frozen=True, kw_only=True)
class OffDiagonalSingularityRobust:
    """A# = W Aᵀ (A W Aᵀ + λ E)⁻¹ with W = (1 - λ) 1 + λ 𝟏𝟏ᵀ: off-diagonal weights also escape gimbal lock.

    Attributes:
        damping: λ0.
        decay: μ.
        dither: ε0 of E.
        dither_rate: rad/s.

    Source: Wie (2005), "Singularity escape/avoidance steering logic for control moment gyro systems".
    """

    damping: float = 0.01
    decay: float = 10.0
    dither: float = 0.1
    dither_rate: float = np.pi / 2

    def inverse(self, jacobian: Array, time: float) -> Array:
        """See `SteeringLaw`."""
        transposed = np.swapaxes(jacobian, -1, -2)
        damping = _damping(self.damping, self.decay, jacobian @ transposed)
        units = jacobian.shape[-1]
        weight = np.eye(units) + damping * (np.ones((units, units)) - np.eye(units))
        weighted = weight @ transposed
        dithered = _dither_matrix(self.dither, self.dither_rate, time)
        return weighted @ np.linalg.inv(jacobian @ weighted + damping * dithered)


def steer(
    law: SteeringLaw,
    jacobian: Array,
    momentum_rate_B: Vectors3,
    preferred_rate: UnitSeries,
    momentum_scale: float,
    time: float,
) -> UnitSeries:
    """Return gimbal rates A# ḣ + (1 - A⁺A) v, shape (..., M), rad/s; the projector never lengthens v.

    Args:
        law: gives A#.
        jacobian: A, shape (..., 3, M), N·m·s/rad.
        momentum_rate_B: wanted ḣ, shape (..., 3), N·m, body axes.
        preferred_rate: v, shape (..., M), rad/s; only its share without torque is flown.
        momentum_scale: one rotor's momentum, N·m·s, by which the problem is scaled.
        time: s, for the laws that dither.
    """
    scaled = jacobian / momentum_scale
    inverse = law.inverse(scaled, time)
    exact = inverse if isinstance(law, MoorePenrose) else MoorePenrose().inverse(scaled, time)
    torque_rate = (inverse @ (momentum_rate_B / momentum_scale)[..., None])[..., 0]
    felt = (scaled @ preferred_rate[..., None])[..., 0]
    return np.asarray(torque_rate + preferred_rate - (exact @ felt[..., None])[..., 0])


def limit_rates(gimbal_rate: UnitSeries, limit: float) -> tuple[UnitSeries, Flags]:
    """Scale all gimbal rates alike so that none exceeds its limit: the torque keeps its direction.

    Args:
        gimbal_rate: shape (..., M), rad/s.
        limit: rad/s.

    Returns:
        The scaled rates, and which units asked for more than the limit, both shape (..., M).
    """
    excess = np.abs(gimbal_rate) / limit
    scale = np.maximum(excess.max(axis=-1, keepdims=True), 1.0)
    return gimbal_rate / scale, excess > 1.0


def preferred_rates(gimbal_angle: UnitSeries, preferred_angle: Units, feed_forward: Units, gain: float) -> UnitSeries:
    """Return v = ḋ_ref + k (d_ref - d), shape (..., M), rad/s, each difference taken the short way round.

    Args:
        gimbal_angle: d, shape (..., M), rad.
        preferred_angle: d_ref, shape (M,), rad.
        feed_forward: ḋ_ref, shape (M,), rad/s.
        gain: k, 1/s.
    """
    difference = np.remainder(preferred_angle - gimbal_angle + np.pi, 2.0 * np.pi) - np.pi
    return np.asarray(feed_forward + gain * difference)


def _damping(damping: float, decay: float, gram: Array) -> Array:
    return np.asarray(damping * np.exp(-decay * np.linalg.det(gram)))[..., None, None]


def _dither_matrix(amplitude: float, rate: float, time: float) -> Array:
    one, two, three = amplitude * np.sin(rate * time + _PHASES)
    return np.array([[1.0, three, two], [three, 1.0, one], [two, one, 1.0]])
