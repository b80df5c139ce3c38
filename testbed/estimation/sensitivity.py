"""Analytic sensitivities of a predicted motion to the inertia, the initial momentum, and what the actuators hold."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from testbed.arrays import Array
from testbed.compiled import LONG, compiled
from testbed.dynamics.environment import gravity_basis
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
    """Return ∂ω/∂(θ, p, L₀) at the output times, shape (..., N, 3, 9 + E), SI.

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
    torque = torque_basis[..., ::2, :, :]
    if motion.up_B is not None:
        torque = np.concatenate([torque, np.zeros_like(torque)], axis=1)
    momentum = _momentum_sensitivity(drive, motion, torque)[..., :-3]
    return np.asarray(motion.inertia_inverse @ momentum)


def acting_basis(drive: Drive, motion: Motion) -> Array:
    """Return the torques of a unit of each unknown that acts, at the times of the integration, (4P+1, 3, K).

    Gravity's on a pendulum is along the motion: only every other time, an end of a step, is known, and used.
    """
    if drive.pendulum is None or motion.up_B is None:
        return drive.torque_basis
    basis = drive.torque_basis.copy()
    basis[::2, :, -3:] = gravity_basis(drive.pendulum.weight, motion.up_B)
    return basis


def _turned(motion: Motion, held: Array) -> Array:
    """Return -L× J⁻¹ ∂(J ω + h)/∂(θ, p), the torque that a change of what is held makes.

    Below it, of a pendulum, -u× J⁻¹ ∂(J ω + h)/∂(θ, p), by which it turns the vertical.
    """
    turned = np.asarray(-cross_matrix(motion.momentum_B) @ motion.node_inverse @ held)
    if motion.up_B is None:
        return turned
    return np.concatenate([turned, -cross_matrix(motion.up_B) @ motion.node_inverse @ held], axis=1)


def _momentum_sensitivity(drive: Drive, motion: Motion, torque: Array) -> Array:
    """Integrate Ṡ = A S + B, S = ∂L/∂(p, L₀), over pairs of the motion's steps; B is the torque of each p.

    Of a pendulum, u stands below L in S and B.
    """
    feedback = _feedback(drive, motion)
    forcing = np.zeros((*feedback.shape[:-1], torque.shape[-1] + 3))
    forcing[..., :-3] = torque
    time = drive.grid_time[::4]
    with np.errstate(over="ignore", invalid="ignore"):
        nodes = _linear_runge_kutta(feedback, forcing, time[1] - time[0])
    require_bounded(nodes, LARGEST)
    slope = feedback[..., ::2, :, :] @ nodes + forcing[..., ::2, :, :]
    columns = CubicHermiteSpline(time, nodes[..., :3, :], slope[..., :3, :], axis=-3)(drive.time)
    return np.ascontiguousarray(columns)


def _feedback(drive: Drive, motion: Motion) -> Array:
    """Return A = L× J⁻¹ - ω×; of a pendulum A of (L, u), with u̇ = u × ω and the torque m g u × c."""
    momentum_cross = cross_matrix(motion.momentum_B) @ motion.node_inverse
    turning = cross_matrix(motion.node_rate)
    feedback = momentum_cross - turning
    if drive.pendulum is None or motion.up_B is None:
        return np.asarray(feedback)
    gravity = np.broadcast_to(-drive.pendulum.weight * cross_matrix(drive.pendulum.offset_B), feedback.shape)
    swing = cross_matrix(motion.up_B) @ motion.node_inverse
    return np.concatenate(
        [np.concatenate([feedback, gravity], axis=2), np.concatenate([swing, -turning], axis=2)], axis=1
    )


def _linear_runge_kutta(feedback: Array, forcing: Array, step: float) -> Array:
    """Return S at every other node, from S = (0, I); all steps' transition matrices are made together."""
    size = feedback.shape[-1]
    start, middle, end = slice(0, -1, 2), slice(1, None, 2), slice(2, None, 2)

    def slope(at: slice, state: Array) -> Array:
        change = feedback[..., at, :, :] @ state
        change[..., size:] += forcing[..., at, :, :]
        return np.asarray(change)

    identity = np.zeros((*feedback.shape[:-3], feedback.shape[-3] // 2, size, size + forcing.shape[-1]))
    identity[..., :size] = np.eye(size)
    first = slope(start, identity)
    second = slope(middle, identity + step / 2 * first)
    third = slope(middle, identity + step / 2 * second)
    fourth = slope(end, identity + step * third)
    transition = identity + step / 6 * (first + 2 * second + 2 * third + fourth)
    return _chained(transition[..., :size], transition[..., size:])


def _chained(transition: Array, increment: Array) -> Array:
    """Return S of every step's end, S ← Φ S + G, after its start S = ∂L₀/∂(θ, p, L₀) = (0, 0, I)."""
    first = np.zeros((*increment.shape[:-3], *increment.shape[-2:]))
    first[..., :3, -3:] = np.eye(3)
    if transition.shape[-3] > LONG:
        chain = np.concatenate([first[..., None, :, :], increment], axis=-3)
        turns = np.ascontiguousarray(transition)
        for flight in np.ndindex(chain.shape[:-3]):
            compiled(_link)(turns[flight], chain[flight])
        return chain
    states = [first]
    for turn, growth in zip(np.moveaxis(transition, -3, 0), np.moveaxis(increment, -3, 0), strict=True):
        states.append(turn @ states[-1] + growth)
    return np.stack(states, axis=-3)


def _link(transition: Array, chain: Array) -> None:
    """Add to each increment of a chain, from its first state on, what its transition makes of the state before."""
    for step in range(len(transition)):
        for row in range(chain.shape[1]):
            for column in range(chain.shape[2]):
                carried = 0.0
                for inner in range(chain.shape[1]):
                    carried += transition[step, row, inner] * chain[step, inner, column]
                chain[step + 1, row, column] += carried
