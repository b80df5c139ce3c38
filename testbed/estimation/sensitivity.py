"""Analytic sensitivities of a predicted motion to the inertia and to the initial momentum."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from testbed.arrays import Array
from testbed.dynamics.inertia import cross_matrix, momentum_regressor
from testbed.errors import InputError
from testbed.estimation.motion import RUNAWAY, Drive, Motion

PARAMETERS = 9
"""Six of the inertia, then three of the initial momentum."""
LARGEST = 1e100
"""SI; sensitivities beyond it are no motion's, and their squares are still finite."""


def rate_sensitivity(drive: Drive, motion: Motion) -> Array:
    """Return ∂ω/∂(θ, L₀) at the output times, shape (N, 3, 9), (rad/s)/(kg·m²) and (rad/s)/(N·m·s).

    ∂ω = J⁻¹ (∂L - Γ(ω) ∂θ), and ∂L follows from the variational equation of the momentum.

    Args:
        drive: what the actuators did.
        motion: the motion that they and the parameters give.

    Raises:
        InputError: the sensitivities leave the finite numbers, as those of a wild motion do.
    """
    momentum = _momentum_sensitivity(drive, motion)
    momentum[..., :6] -= momentum_regressor(motion.body_rate)
    return np.asarray(motion.inertia_inverse @ momentum)


def _momentum_sensitivity(drive: Drive, motion: Motion) -> Array:
    """Integrate Ṡ = A S + B, S = ∂L/∂(θ, L₀), over pairs of the motion's steps."""
    momentum_cross = cross_matrix(motion.momentum_B) @ motion.node_inverse
    feedback = momentum_cross - cross_matrix(motion.node_rate)  # A = L× J⁻¹ - ω×
    forcing = np.zeros((len(feedback), 3, PARAMETERS))
    forcing[..., :6] = -momentum_cross @ momentum_regressor(motion.node_rate)  # B = -L× J⁻¹ Γ(ω)
    time = drive.grid_time[::4]
    with np.errstate(over="ignore", invalid="ignore"):
        nodes = _linear_runge_kutta(feedback, forcing, time[1] - time[0])
    if not np.abs(nodes).max() < LARGEST:  # also true for NaN
        raise InputError(RUNAWAY)
    slope = feedback[::2] @ nodes + forcing[::2]
    return np.asarray(CubicHermiteSpline(time, nodes, slope)(drive.time))


def _linear_runge_kutta(feedback: Array, forcing: Array, step: float) -> Array:
    """Return S at every other node, from S = (0, I); all steps' transition matrices are made at once."""
    start, middle, end = slice(0, -1, 2), slice(1, None, 2), slice(2, None, 2)

    def slope(at: slice, state: Array) -> Array:
        change = feedback[at] @ state
        change[..., 3:] += forcing[at]
        return np.asarray(change)

    identity = np.zeros((len(feedback) // 2, 3, 3 + PARAMETERS))
    identity[..., :3] = np.eye(3)
    first = slope(start, identity)
    second = slope(middle, identity + step / 2 * first)
    third = slope(middle, identity + step / 2 * second)
    fourth = slope(end, identity + step * third)
    transition = identity + step / 6 * (first + 2 * second + 2 * third + fourth)
    return _chained(transition[..., :3], transition[..., 3:])


def _chained(transition: Array, increment: Array) -> Array:
    """Return S of every step's end, S ← Φ S + G, after its start S = ∂L₀/∂(θ, L₀) = (0, I)."""
    states = [np.hstack([np.zeros((3, 6)), np.eye(3)])]
    for turn, growth in zip(transition, increment, strict=True):
        states.append(turn @ states[-1] + growth)
    return np.array(states)
