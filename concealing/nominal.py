"""What the nominal model says that the gyro should show, and what of a flight it leaves unexplained.

The body rate is predicted from noise-free telemetry; the inertia and the initial rates, which every estimate finds for
itself, are projected out of the difference.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from concealing.craft import Array, cross

_ENTRIES = ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))
_NUDGE_INERTIA, _NUDGE_RATE = 1e-6, 1e-5


class DivergedError(Exception):
    """A flight leaves the finite numbers."""


class Telemetry(NamedTuple):
    """What the nominal model knows, on a grid of half control periods.

    Attributes:
        momentum: of the actuators, (2K - 1, B, 3), N·m·s, body axes.
        inertia_change: J(d) - J(0), (2K - 1, B, 3, 3), kg·m².
        torque: applied, (2K - 1, B, 3), N·m.
        weight_arm: m g c, (3,), N·m, body axes, of a platform that is released level on a pivot; None of a free one.
    """

    momentum: Array
    inertia_change: Array
    torque: Array
    weight_arm: Array | None = None


def predictions(telemetry: Telemetry, period: float, inertia: Array, released: Array) -> Array:
    """Integrate L̇ = -ω × L + T with L = J(d) ω + h over each period, (K, P, B, 3); RK4, exact to 1e-7 here.

    On a pivot T has the gravity torque u × m g c, and the vertical u, fixed in space, turns by u̇ = -ω × u.

    Args:
        telemetry: what is known.
        period: s.
        inertia: P of them, (P, 1, 3, 3), kg·m².
        released: initial rates, (P, B, 3), rad/s.
    """
    arm = telemetry.weight_arm

    def rate_at(half: int, state: Array) -> Array:
        whole = inertia + telemetry.inertia_change[half]
        return np.linalg.solve(whole, (state[..., :3] - telemetry.momentum[half])[..., None])[..., 0]

    def slope(half: int, state: Array) -> Array:
        rate = rate_at(half, state)
        turning = cross(state[..., :3], rate) + telemetry.torque[half]
        if arm is None:
            return turning
        up = state[..., 3:]
        return np.concatenate([turning + cross(up, np.broadcast_to(arm, up.shape)), cross(up, rate)], axis=-1)

    whole = inertia + telemetry.inertia_change[0]
    state = (whole @ released[..., None])[..., 0] + telemetry.momentum[0]
    if arm is not None:
        state = np.concatenate([state, np.broadcast_to([0.0, 0.0, 1.0], state.shape)], axis=-1)
    rates = [released]
    for half in range(0, len(telemetry.momentum) - 1, 2):
        first = slope(half, state)
        second = slope(half + 1, state + period / 2 * first)
        third = slope(half + 1, state + period / 2 * second)
        fourth = slope(half + 2, state + period * third)
        state = state + period / 6 * (first + 2 * second + 2 * third + fourth)
        rates.append(rate_at(half + 2, state))
    return np.array(rates)


def nudged(inertia: Array, released: Array) -> tuple[Array, Array]:
    """Return inertias, (10, 1, 3, 3), and initial rates, (10, B, 3): as they are, each entry, each axis more."""
    inertias, rates = np.tile(inertia, (10, 1, 1, 1)), np.tile(released, (10, 1, 1))
    for index, (row, column) in enumerate(_ENTRIES):
        inertias[1 + index, 0, row, column] += _NUDGE_INERTIA
        inertias[1 + index, 0, column, row] = inertias[1 + index, 0, row, column]
    for axis in range(3):
        rates[7 + axis, :, axis] += _NUDGE_RATE
    return inertias, rates


def unexplained(shown: Array, rates: Array, sampled: Callable[[Array], Array]) -> Array:
    """Return what is left of recorded body rates, flat, with the inertia and every run's initial rates projected out.

    Args:
        shown: by the gyro without noise, (K, B, 3), rad/s.
        rates: predictions of what `nudged` returns, (K, 10, B, 3), rad/s.
        sampled: takes values at the control ticks, (K, B, 3), to those that are recorded, flat.
    """
    residual = sampled(shown - rates[:, 0])
    columns = [sampled(rates[:, 1 + entry] - rates[:, 0]) / _NUDGE_INERTIA for entry in range(6)]
    for axis in range(3):
        slope = (rates[:, 7 + axis] - rates[:, 0]) / _NUDGE_RATE
        columns += [sampled(slope * own[:, None]) for own in np.eye(rates.shape[2])]
    matrix = np.stack(columns, axis=1)
    basis, _ = np.linalg.qr(matrix / np.linalg.norm(matrix, axis=0))
    return residual - basis @ (basis.T @ residual)
