"""The motion of gimbals and wheels that holds a given momentum, with the least commands, as the controller steers."""

from __future__ import annotations

import numpy as np

from testbed.arrays import Array, Units, UnitSeries, Vector3, Vectors3
from testbed.cmg.actuators import Actuators, momentum_and_jacobian

_ROUNDS = 3
"""Steps of Gauss and Newton toward each momentum: the first leaves the square of how far the gimbals turn, 0.1 rad
between instants, and the second less than 1e-4 of it."""
_STEPS = 10
"""In which a momentum is approached from another one, so that gimbals turn a little in each."""
_SINGULAR = 1e-9
"""Share of the mean square of the columns by which directions are damped that no column has: above rounding."""


def followed(actuators: Actuators, first: Units, momentum_B: Vectors3) -> UnitSeries:
    """Return gimbal angles, rad, and wheel momenta, N·m·s, that hold a momentum in time, shape (..., T, M + W).

    The least commands on the scale of `cmg.actuators`: the Moore-Penrose law without null motion.

    Args:
        actuators: gyros and wheels.
        first: motion to start from, shape (M + W,).
        momentum_B: h at T instants, shape (..., T, 3), N·m·s, body axes.
    """
    motion = np.broadcast_to(first, (*momentum_B.shape[:-2], len(first)))
    along = []
    for instant in range(momentum_B.shape[-2]):
        for _ in range(_ROUNDS if actuators.units else 1):  # of wheels alone the momentum is linear
            held_B, jacobian = momentum_and_jacobian(
                actuators, motion[..., : actuators.units], motion[..., actuators.units :]
            )
            motion = motion + actuators.command_scale * _least(jacobian, momentum_B[..., instant, :] - held_B)
        along.append(motion)
    return np.stack(along, axis=-2)


def brought_to(actuators: Actuators, first: Units, momentum_B: Vector3) -> Units:
    """Return the motion that holds a momentum, from another one on, shape (M + W,)."""
    held_B, _ = momentum_and_jacobian(actuators, first[: actuators.units], first[actuators.units :])
    shares = np.linspace(0.0, 1.0, _STEPS + 1)[1:, None]
    return np.asarray(followed(actuators, first, held_B + shares * (momentum_B - held_B))[-1])


def _least(jacobian: Array, behind_B: Vectors3) -> Array:
    """Return the shortest commands that gain a momentum, shape (..., M + W)."""
    square = jacobian @ np.swapaxes(jacobian, -1, -2)
    damping = _SINGULAR * np.einsum("...ii->...", square)[..., None, None] * np.eye(3)
    gained = np.linalg.solve(square + damping, behind_B[..., None])
    return np.asarray((np.swapaxes(jacobian, -1, -2) @ gained)[..., 0])
