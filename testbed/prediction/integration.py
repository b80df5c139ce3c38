"""The motion of many runs under many parameter sets, integrated side by side.

The state is the platform's whole momentum L in body axes, L̇ = τ - ω × L, with (J(d) - Ĵ) ω = L - h - ĥ, where the hat
marks what does not turn with the body (a hinged or sloshing mass). No measurement is differentiated.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from testbed.arrays import Array
from testbed.dynamics.inertia import inertia_of
from testbed.errors import InputError
from testbed.estimation.motion import RUNAWAY
from testbed.prediction.grid import Gimbals, Grid
from testbed.prediction.held import held_inertia, held_momentum
from testbed.prediction.hooks import Hooks, Instant

_WILDEST = 1e6
"""N·m·s; no platform of this kind holds it, and squares of it are far from overflow."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Values:
    """Parameter sets, P of them.

    Attributes:
        theta: inertia parameters, shape (P, 6), kg·m².
        initial_rate: ω at each run's first sample, shape (R, P, 3), rad/s.
        effects: parameters of each effect, in the order of the hooks, shapes (P, K).
    """

    theta: Array
    initial_rate: Array
    effects: tuple[Array, ...]

    @property
    def sets(self) -> int:
        """P; an array with a single set stands for all."""
        return max(len(self.theta), len(self.initial_rate[0]), *map(len, self.effects), 1)


@dataclass(frozen=True, kw_only=True, eq=False)
class _Known:
    """What does not depend on the state: along the grid, shapes (R, P, T, ...)."""

    momentum_B: Array
    torque_B: Array
    inverse: Array


def node_rates(grid: Grid, hooks: Sequence[Hooks], values: Values) -> Array:
    """Return ω at the ends of the integration's steps, shape (R, P, M + 1, 3), rad/s.

    Args:
        grid: the runs.
        hooks: the effects in the model.
        values: parameter sets.

    Raises:
        InputError: the motion leaves the finite numbers.
    """
    known = _known(grid, hooks, values)
    motion = _Motion(grid, hooks, values, known)
    with np.errstate(over="ignore", invalid="ignore"):
        rates = motion.integrated()
    if not np.abs(rates).max() < _WILDEST:  # also true for NaN
        raise InputError(RUNAWAY)
    return rates


def _known(grid: Grid, hooks: Sequence[Hooks], values: Values) -> _Known:
    momentum_B, torque_B = grid.cluster_momentum_B, grid.applied_torque_B
    inertia = inertia_matrix(values.theta)[None, :, None]
    pairs = list(zip(hooks, values.effects, strict=True))
    gimbals = effective_gimbals(grid, hooks, values.effects)
    if gimbals is not None and grid.cluster is not None:
        momentum_B = held_momentum(gimbals, grid.cluster)
        inertia = inertia + held_inertia(gimbals, grid.cluster)
    for hook, value in pairs:
        momentum_B = hook.cluster_momentum(momentum_B, value, grid)
        torque_B = hook.applied_torque(torque_B, value, grid)
        inertia = inertia - np.broadcast_to(hook.hidden_inertia(value), (*value.shape[:1], 3, 3))[:, None]
    torque_B = torque_B[:, :, -grid.time.shape[1] :]  # what was before acts through the actuators' response only
    inverse = symmetric_inverse(inertia)
    along = np.broadcast_to(inverse, (*inverse.shape[:2], grid.time.shape[1], 3, 3))  # constant without gimbal angles
    return _Known(momentum_B=momentum_B, torque_B=torque_B, inverse=along)


def effective_gimbals(grid: Grid, hooks: Sequence[Hooks], effects: Sequence[Array]) -> Gimbals | None:
    """Return the units as they are, instead of as telemetry has them; None where there are none.

    Args:
        grid: the runs.
        hooks: the effects in the model.
        effects: their parameters, shapes (P, K).
    """
    gimbals = grid.gimbals
    if gimbals is not None and grid.cluster is not None:
        for hook, value in zip(hooks, effects, strict=True):
            gimbals = hook.gimbals(gimbals, value, grid, grid.cluster)
    return gimbals


def inertia_matrix(theta: Array) -> Array:
    """Return J of θ, shape (P, 3, 3), keeping complex values; as `inertia_of`."""
    if not np.iscomplexobj(theta):
        return inertia_of(theta)
    return inertia_of(theta.real) + 1j * inertia_of(theta.imag)


def symmetric_inverse(matrix: Array) -> Array:
    """Return the inverses of symmetric 3 × 3 matrices, shape (..., 3, 3), by cofactors; analytic in the entries."""
    a, b, c = matrix[..., 0, 0], matrix[..., 1, 1], matrix[..., 2, 2]
    d, e, f = matrix[..., 1, 2], matrix[..., 0, 2], matrix[..., 0, 1]
    xx, yy, zz = b * c - d * d, a * c - e * e, a * b - f * f
    yz, xz, xy = e * f - a * d, d * f - b * e, d * e - c * f
    determinant = a * xx + f * xy + e * xz
    rows = [np.stack(row, axis=-1) for row in ((xx, xy, xz), (xy, yy, yz), (xz, yz, zz))]
    return np.asarray(np.stack(rows, axis=-2) / determinant[..., None, None])


class _Motion:
    """The right-hand side and the classical fourth-order rule, on one array of all states."""

    def __init__(self, grid: Grid, hooks: Sequence[Hooks], values: Values, known: _Known) -> None:
        self._grid, self._known = grid, known
        self._pairs = list(zip(hooks, values.effects, strict=True))
        self._attitude = any(hook.needs_attitude for hook in hooks)
        edges = np.cumsum([3 + 4 * self._attitude, *(hook.states for hook in hooks)])
        self._own = [slice(first, last) for first, last in pairwise(edges.tolist())]
        # Of many hypotheses at once few act on the motion itself; the others cost nothing here.
        self._acting = [
            (hook, value, own)
            for (hook, value), own in zip(self._pairs, self._own, strict=True)
            if hook.states or type(hook).torque is not Hooks.torque
        ]
        self._start = self._initial(values)

    def integrated(self) -> Array:
        """Return ω at the nodes, shape (R, P, M + 1, 3)."""
        step = self._grid.step[:, None, None]
        state, rates = self._start, [self._body_rate(self._start, 0)]
        for index in range(0, self._grid.time.shape[1] - 2, 2):
            first = self._slope(state, index)
            second = self._slope(state + step / 2 * first, index + 1)
            third = self._slope(state + step / 2 * second, index + 1)
            fourth = self._slope(state + step * third, index + 2)
            state = state + step / 6 * (first + 2 * second + 2 * third + fourth)
            rates.append(self._body_rate(state, index + 2))
        return np.stack(rates, axis=2)

    def _initial(self, values: Values) -> Array:
        runs, sets = len(self._grid.runs), values.sets
        parts = [np.zeros((runs, sets, 3))]
        if self._attitude:
            parts.append(np.broadcast_to([1.0, 0.0, 0.0, 0.0], (runs, sets, 4)))
        for hook, value in self._pairs:
            parts.append(np.broadcast_to(hook.initial_state(value, values.initial_rate), (runs, sets, hook.states)))
        state = np.concatenate(parts, axis=-1)
        inertia = np.linalg.inv(self._known.inverse[:, :, 0])
        momentum_B = np.matvec(inertia, values.initial_rate) + self._known.momentum_B[:, :, 0] + self._hidden(state)
        return np.concatenate([np.broadcast_to(momentum_B, (runs, sets, 3)), state[..., 3:]], axis=-1)

    def _hidden(self, state: Array) -> Array:
        held = np.zeros(3)
        for hook, value, own in self._acting:
            if hook.states:
                held = held + hook.hidden_momentum(value, state[..., own])
        return held

    def _body_rate(self, state: Array, index: int) -> Array:
        inside_B = state[..., :3] - self._known.momentum_B[:, :, index] - self._hidden(state)
        return np.asarray(np.matvec(self._known.inverse[:, :, index], inside_B))

    def _slope(self, state: Array, index: int) -> Array:
        body_rate = self._body_rate(state, index)
        attitude = matrix_of_quaternion(state[..., 3:7]) if self._attitude else np.eye(3)
        torque_B = self._known.torque_B[:, :, index]
        rates = [np.zeros_like(body_rate)]
        if self._attitude:
            rates.append(quaternion_rate(state[..., 3:7], body_rate))
        for hook, value, own in self._acting:
            at = Instant(
                time=self._grid.time[:, index, None], body_rate=body_rate, attitude=attitude, state=state[..., own]
            )
            torque_B = torque_B + hook.torque(value, at)
            if hook.states:
                rates.append(np.broadcast_to(hook.state_rate(value, at), (*body_rate.shape[:-1], hook.states)))
        rates[0] = torque_B + cross(state[..., :3], body_rate)
        return np.concatenate(rates, axis=-1)


def cross(left: Array, right: Array) -> Array:
    """Return left × right, shape (..., 3); NumPy's own spends ten times as long on moving axes."""
    a, b, c = left[..., 0], left[..., 1], left[..., 2]
    x, y, z = right[..., 0], right[..., 1], right[..., 2]
    return np.stack((b * z - c * y, c * x - a * z, a * y - b * x), axis=-1)


def matrix_of_quaternion(quaternion: Array) -> Array:
    """Return the rotation matrix of scalar-first quaternions, shape (..., 3, 3), analytic in their entries."""
    w, x, y, z = (quaternion[..., index] for index in range(4))
    rows = (
        (w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)),
        (2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)),
        (2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z),
    )
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def quaternion_rate(quaternion: Array, body_rate: Array) -> Array:
    """Return q̇ = ½ q ⊗ (0, ω), shape (..., 4)."""
    scalar, vector = quaternion[..., :1], quaternion[..., 1:]
    turning = scalar * body_rate + cross(vector, body_rate)
    return 0.5 * np.concatenate((-(vector * body_rate).sum(axis=-1, keepdims=True), turning), axis=-1)
