"""The equations of motion of many runs under many parameter sets, and one step of their integration.

The state is the platform's total angular momentum L in body axes, as in `dynamics.gyrostat`, with
(J(d) - Ĵ) ω = L - h - ĥ, where the hat marks what does not turn with the body (a hinged or sloshing mass). No
measurement is differentiated.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from testbed.arrays import Array, Flags, Series
from testbed.estimation.surroundings import Surroundings
from testbed.prediction import kernels
from testbed.prediction.algebra import applied
from testbed.prediction.hooks import Hooks, Instant


@dataclass(frozen=True, kw_only=True, eq=False)
class Bearing:
    """What holds platforms about some body axes; arrays as those of `Known`.

    About these axes ω is zero, and the bearing gives whatever torque that takes: their momentum is no state, but
    follows, (J ω)_held + h_held, and turns about the others only where two of them are free.

    Attributes:
        live: about which axes each run turns, shape (R, 1, 1, 3).
        coupling: the rows of J(d) - Ĵ of held axes in the columns of free ones, shape (R, P, T, 3, 3), kg·m².
    """

    live: Flags
    coupling: Array


@dataclass(frozen=True, kw_only=True, eq=False)
class Known:
    """What does not depend on the state, along the grid or, of `at`, at some of its instants.

    Where a run, a parameter set or an instant makes no difference, arrays have but one of them.

    Attributes:
        time: shape (R, T), s.
        step: shape (R,), s.
        momentum_B: h of the units, shape (R, P, T, 3), N·m·s.
        torque_B: of the actuators, shape (R, P, T, 3), N·m.
        inverse: of the real part of J(d) - Ĵ, shape (R, P, T, 3, 3), 1/(kg·m²).
        inertia_step: its imaginary part, a complex step, shape (R, P, T, 3, 3), kg·m²; None where it has none.
        bearing: what holds the platforms about some axes; None of platforms that turn freely.
        first_NB: R_NB at each run's first sample, shape (R, 1, 3, 3).
        surroundings: of the first run; None where nothing acts from outside.
    """

    time: Array
    step: Series
    momentum_B: Array
    torque_B: Array
    inverse: Array
    inertia_step: Array | None
    bearing: Bearing | None = None
    first_NB: Array = field(default_factory=lambda: np.eye(3)[None, None])
    surroundings: Surroundings | None = None

    def at(self, instants: slice) -> Known:
        """Return the same with instants in the place of runs, W of them per run: shapes (R W, 1), (R W, P, ...)."""
        time = self.time[:, instants]
        return Known(
            time=time.reshape(-1, 1),
            step=np.repeat(self.step, time.shape[1]),
            momentum_B=self._by_instant(self.momentum_B, instants),
            torque_B=self._by_instant(self.torque_B, instants),
            inverse=self._by_instant(self.inverse, instants),
            inertia_step=None if self.inertia_step is None else self._by_instant(self.inertia_step, instants),
            bearing=None
            if self.bearing is None
            else Bearing(
                live=np.repeat(self.bearing.live[:, :, 0], time.shape[1], axis=0),
                coupling=self._by_instant(self.bearing.coupling, instants),
            ),
            first_NB=self.first_NB if len(self.first_NB) == 1 else np.repeat(self.first_NB, time.shape[1], axis=0),
            surroundings=self.surroundings,
        )

    def without_steps(self) -> Known:
        """Return the real parts of the first parameter set."""
        return Known(
            time=self.time,
            step=self.step,
            momentum_B=self.momentum_B[:, :1].real,
            torque_B=self.torque_B[:, :1].real,
            inverse=self.inverse[:, :1],
            inertia_step=None,
            bearing=self.bearing and Bearing(live=self.bearing.live, coupling=self.bearing.coupling[:, :1].real),
            first_NB=self.first_NB,
            surroundings=self.surroundings,
        )

    def _by_instant(self, values: Array, instants: slice) -> Array:
        """Return values of shape (R, P, T, ...) as (R W, P, ...), or (1, P, ...) where they are the same everywhere."""
        runs, length = self.time.shape
        alone = len(range(length)[instants]) == 1
        if values.shape[2] == 1 and (alone or values.shape[0] == 1):
            return values[:, :, 0]
        if alone:
            return values[:, :, instants.start]
        everywhere = np.broadcast_to(values, (runs, values.shape[1], length, *values.shape[3:]))
        turned = np.moveaxis(everywhere[:, :, instants], 2, 1)
        return turned.reshape(-1, *turned.shape[2:])


class Equations:
    """The right-hand side and the classical fourth-order rule, on one array of all states.

    States stand in arrays of shape (R, W, P, S): W nodes of the grid, or beginnings of steps, side by side.
    """

    def __init__(self, hooks: Sequence[Hooks], effects: Sequence[Array], known: Known) -> None:
        """Take the effects in the model with their parameters, shapes (P, K)."""
        self._known = known
        self._pairs = list(zip(hooks, effects, strict=True))
        self._attitude = any(hook.needs_attitude for hook in hooks)
        edges = np.cumsum([3 + 4 * self._attitude, *(hook.states for hook in hooks)])
        self._own = [slice(first, last) for first, last in pairwise(edges.tolist())]
        # Of many hypotheses together few act on the motion itself; the others cost nothing here.
        self._acting = [
            (hook, value, own)
            for (hook, value), own in zip(self._pairs, self._own, strict=True)
            if hook.states or type(hook).torque is not Hooks.torque
        ]
        self._hides = any(hook.states for hook, _, _ in self._acting)

    @property
    def groups(self) -> list[slice]:
        """Which states are of a kind: momentum, attitude, then each effect's."""
        attitude = [slice(3, 7)] if self._attitude else []
        return [slice(0, 3), *attitude, *(own for own in self._own if own.start < own.stop)]

    def initial(self, initial_rate: Array, sets: int) -> Array:
        """Return the states at the first node of every run, shape (R, 1, P, S).

        Args:
            initial_rate: ω there, shape (R, P, 3), rad/s.
            sets: P; an array with a single set stands for all.
        """
        runs = len(initial_rate)
        parts = [np.zeros((runs, 1, 3))]
        if self._attitude:
            parts.append(np.broadcast_to([1.0, 0.0, 0.0, 0.0], (runs, 1, 4)))
        for hook, value in self._pairs:
            parts.append(np.broadcast_to(hook.initial_state(value, initial_rate), (runs, sets, hook.states)))
        state = np.concatenate([np.broadcast_to(part, (runs, sets, part.shape[-1])) for part in parts], axis=-1)
        return self.with_rates(state[:, None], initial_rate[:, None], slice(0, 1))

    def with_rates(self, states: Array, body_rate: Array, nodes: slice) -> Array:
        """Return states at nodes, shape (R, W, P, S), with the momentum that goes with ω, shape (R, W, P, 3), rad/s."""
        flat, rates = (part.reshape(-1, *part.shape[2:]) for part in (states, body_rate))
        known = self._known.at(_half_steps(nodes, 0))
        held_B = np.matvec(_inverted(known), rates)
        if known.inertia_step is not None:
            held_B = held_B + 1j * np.matvec(known.inertia_step, rates.real)
        momentum_B = held_B + known.momentum_B + self._hidden(flat)
        whole = np.broadcast_to(momentum_B, (*flat.shape[:2], 3))
        return np.concatenate([whole, flat[..., 3:]], axis=-1).reshape(*states.shape[:2], *flat.shape[1:])

    def body_rates(self, states: Array, nodes: slice) -> Array:
        """Return ω of states at nodes, shape (R, W, P, 3), rad/s."""
        flat = states.reshape(-1, *states.shape[2:])
        rates = self._body_rate(flat, self._known.at(_half_steps(nodes, 0)))
        return rates.reshape(*states.shape[:2], *rates.shape[1:])

    def stepped(self, states: Array, steps: slice) -> Array:
        """Return the states at the ends of steps.

        Args:
            states: at their beginnings, shape (R, W, P, S).
            steps: W of them.
        """
        begin, middle, end = (self._known.at(_half_steps(steps, later)) for later in range(3))
        state, step = states.reshape(-1, *states.shape[2:]), begin.step[:, None, None]
        first = self._slope(state, begin)
        second = self._slope(state + step / 2 * first, middle)
        third = self._slope(state + step / 2 * second, middle)
        fourth = self._slope(state + step * third, end)
        after = state + step / 6 * (first + 2 * second + 2 * third + fourth)
        return after.reshape(*states.shape[:2], *after.shape[1:])

    def _hidden(self, state: Array) -> Array:
        held = np.zeros(3)
        for hook, value, own in self._acting:
            if hook.states:
                held = held + hook.hidden_momentum(value, state[..., own])
        return held

    def _body_rate(self, state: Array, known: Known) -> Array:
        held_B = known.momentum_B + self._hidden(state) if self._hides else known.momentum_B
        if known.inertia_step is None:
            return kernels.body_rate(state[..., :3], held_B, known.inverse)
        return kernels.stepped_body_rate(state[..., :3], held_B, known.inverse, known.inertia_step)

    def _slope(self, state: Array, known: Known) -> Array:
        body_rate = self._body_rate(state, known)
        attitude = kernels.matrix_of_quaternion(state[..., 3:7]) if self._attitude else np.eye(3)
        torque_B = known.torque_B
        rates = [kernels.quaternion_rate(state[..., 3:7], body_rate)] if self._attitude else []
        for hook, value, own in self._acting:
            at = Instant(
                time=known.time,
                body_rate=body_rate,
                attitude=attitude,
                state=state[..., own],
                first_NB=known.first_NB,
                surroundings=known.surroundings,
            )
            torque_B = torque_B + hook.torque(value, at)
            if hook.states:
                rates.append(np.broadcast_to(hook.state_rate(value, at), (*body_rate.shape[:-1], hook.states)))
        turning = kernels.turning(torque_B, self._whole_momentum(state, body_rate, known), body_rate)
        if known.bearing is not None:
            turning = np.where(known.bearing.live, turning, 0.0)
        return np.concatenate([turning, *rates], axis=-1) if rates else turning

    def _whole_momentum(self, state: Array, body_rate: Array, known: Known) -> Array:
        if known.bearing is None:
            return state[..., :3]
        held_B = applied(known.bearing.coupling, body_rate) + known.momentum_B + self._hidden(state)
        return np.where(known.bearing.live, state[..., :3], held_B)


def _inverted(known: Known) -> Array:
    """Return J(d) - Ĵ itself, of a platform on a bearing the block of its free axes."""
    if known.bearing is None:
        return np.asarray(np.linalg.inv(known.inverse), dtype=np.float64)
    held = np.eye(3) * ~known.bearing.live[..., None]
    return np.asarray(np.linalg.inv(known.inverse + held) - held, dtype=np.float64)


def _half_steps(steps: slice, later: int) -> slice:
    """Return the grid's instants so many half steps after the beginnings of steps."""
    return slice(2 * steps.start + later, 2 * steps.stop + later, 2)
