"""Analytic sensitivities of a predicted motion to the inertia, the initial momentum, and what the actuators hold."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from testbed.arrays import Array
from testbed.compiled import LONG, compiled
from testbed.dynamics.gyrostat import require_bounded
from testbed.dynamics.inertia import cross_matrix, momentum_regressor
from testbed.estimation.motion import Drive, Motion

LARGEST = 1e100
"""SI; sensitivities beyond it are no motion's, and their squares are still finite."""


class HeldMomentum(NamedTuple):
    """∂(J(d) ω + h)/∂p at unchanged ω, for E parameters p of what the actuators hold.

    Attributes:
        at_nodes: at the ends of the integration's steps, shape (2P+1, 3, E), N·m·s per unit of p.
        at_samples: at the output times, shape (N, 3, E).
    """

    at_nodes: Array
    at_samples: Array


def rate_sensitivity(drive: Drive, motion: Motion, held: HeldMomentum | None = None) -> Array:
    """Return ∂ω/∂(θ, p, L₀) at the output times, shape (N, 3, 9 + E), SI.

    ∂ω = J⁻¹ (∂L - Γ(ω) ∂θ - ∂(J ω + h)/∂p ∂p), and ∂L follows from the variational equation of the momentum.

    Args:
        drive: what the actuators did.
        motion: the motion that they and the parameters give.
        held: of parameters that what the actuators hold depends on; none where absent.

    Raises:
        InputError: the sensitivities leave the finite numbers, as those of a wild motion do.
    """
    regressors = HeldMomentum(momentum_regressor(motion.node_rate), momentum_regressor(motion.body_rate))
    if held is not None:
        pairs = zip(regressors, held, strict=True)
        regressors = HeldMomentum(*(np.concatenate(pair, axis=-1) for pair in pairs))
    momentum = _momentum_sensitivity(drive, motion, _turned(motion, regressors.at_nodes))
    momentum[..., :-3] -= regressors.at_samples
    return np.asarray(motion.inertia_inverse @ momentum)


def held_sensitivity(drive: Drive, motion: Motion, held: HeldMomentum) -> Array:
    """Return ∂ω/∂p at the output times, shape (N, 3, E), at unchanged inertia and initial momentum; as above."""
    momentum = _momentum_sensitivity(drive, motion, _turned(motion, held.at_nodes))[..., :-3] - held.at_samples
    return np.asarray(motion.inertia_inverse @ momentum)


def torque_sensitivity(drive: Drive, motion: Motion, torque_basis: Array) -> Array:
    """Return ∂ω/∂c at the output times, shape (N, 3, K), of torques c that act along given directions.

    Args:
        drive: what the actuators did.
        motion: the motion that they and the parameters give.
        torque_basis: the directions at the times of the integration, shape (4P+1, 3, K), body axes.
    """
    momentum = _momentum_sensitivity(drive, motion, torque_basis[::2])[..., :-3]
    return np.asarray(motion.inertia_inverse @ momentum)


def _turned(motion: Motion, held: Array) -> Array:
    """Return -L× J⁻¹ ∂(J ω + h)/∂(θ, p), the torque that a change of what is held makes."""
    return np.asarray(-cross_matrix(motion.momentum_B) @ motion.node_inverse @ held)


def _momentum_sensitivity(drive: Drive, motion: Motion, torque: Array) -> Array:
    """Integrate Ṡ = A S + B, S = ∂L/∂(p, L₀), over pairs of the motion's steps; B is the torque of each p."""
    momentum_cross = cross_matrix(motion.momentum_B) @ motion.node_inverse
    feedback = momentum_cross - cross_matrix(motion.node_rate)  # A = L× J⁻¹ - ω×
    forcing = np.zeros((*torque.shape[:-1], torque.shape[-1] + 3))
    forcing[..., :-3] = torque
    time = drive.grid_time[::4]
    with np.errstate(over="ignore", invalid="ignore"):
        nodes = _linear_runge_kutta(feedback, forcing, time[1] - time[0])
    require_bounded(nodes, LARGEST)
    slope = feedback[::2] @ nodes + forcing[::2]
    return np.asarray(CubicHermiteSpline(time, nodes, slope)(drive.time))


def _linear_runge_kutta(feedback: Array, forcing: Array, step: float) -> Array:
    """Return S at every other node, from S = (0, I); all steps' transition matrices are made together."""
    start, middle, end = slice(0, -1, 2), slice(1, None, 2), slice(2, None, 2)

    def slope(at: slice, state: Array) -> Array:
        change = feedback[at] @ state
        change[..., 3:] += forcing[at]
        return np.asarray(change)

    identity = np.zeros((len(feedback) // 2, 3, 3 + forcing.shape[-1]))
    identity[..., :3] = np.eye(3)
    first = slope(start, identity)
    second = slope(middle, identity + step / 2 * first)
    third = slope(middle, identity + step / 2 * second)
    fourth = slope(end, identity + step * third)
    transition = identity + step / 6 * (first + 2 * second + 2 * third + fourth)
    return _chained(transition[..., :3], transition[..., 3:])


def _chained(transition: Array, increment: Array) -> Array:
    """Return S of every step's end, S ← Φ S + G, after its start S = ∂L₀/∂(θ, p, L₀) = (0, 0, I)."""
    first = np.eye(3, increment.shape[-1], increment.shape[-1] - 3)
    if len(transition) > LONG:
        chain = np.concatenate([first[None], increment])
        compiled(_link)(np.ascontiguousarray(transition), chain)
        return chain
    states = [first]
    for turn, growth in zip(transition, increment, strict=True):
        states.append(turn @ states[-1] + growth)
    return np.array(states)


def _link(transition: Array, chain: Array) -> None:
    """Add to each increment of a chain, from its first state on, what its transition makes of the state before."""
    for step in range(len(transition)):
        for row in range(3):
            for column in range(chain.shape[2]):
                carried = 0.0
                for inner in range(3):
                    carried += transition[step, row, inner] * chain[step, inner, column]
                chain[step + 1, row, column] += carried
