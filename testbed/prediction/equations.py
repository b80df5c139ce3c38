"""The equations of motion of many runs under many parameter sets, and one step of their integration.

The state is the platform's total angular momentum L in body axes, as in `dynamics.gyrostat`, with
(J(d) - Ĵ) ω = L - h - ĥ, where the hat marks what does not turn with the body (a hinged or sloshing mass). No
measurement is differentiated.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from testbed.arrays import Array, Flags, Series
from testbed.dynamics.inertia import symmetric_inverse
from testbed.estimation.surroundings import Surroundings
from testbed.prediction import kernels
from testbed.prediction.algebra import applied
from testbed.prediction.hooks import Hooks, Instant
from testbed.prediction.tangents import BESIDE, slopes

_FREE, _UNCOUPLED = np.ones((1, 3)), np.zeros((1, 3, 3))
"""What `slopes` takes of a body that no bearing holds."""
COMPLEX_STEP = 1e-20
"""The derivative is the imaginary part over it: no difference is taken, so that it is exact to rounding.

Source: Squire and Trapp, "Using complex variables to estimate derivatives of real functions", SIAM Review (1998).
"""


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

    @property
    def arrays(self) -> list[Array]:
        """All of them, for comparing; not the surroundings."""
        held = [] if self.bearing is None else [self.bearing.live.astype(np.float64), self.bearing.coupling]
        stepped = [] if self.inertia_step is None else [self.inertia_step]
        own = [self.time, self.step, self.momentum_B, self.torque_B, self.inverse, self.first_NB]
        return [*own, *stepped, *held]

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


def gives_torque(hook: Hooks) -> bool:
    """Return whether an effect gives a torque that depends on the motion."""
    return type(hook).torque is not Hooks.torque


def acts_on_motion(hook: Hooks) -> bool:
    """Return whether an effect acts on the motion itself, and not by what is known along the grid."""
    return bool(hook.states) or gives_torque(hook)


class Equations:
    """The right-hand side and the classical fourth-order rule, on one array of all states.

    States stand in arrays of shape (R, W, P, S): W nodes of the grid, or beginnings of steps, side by side.
    """

    def __init__(
        self, hooks: Sequence[Hooks], effects: Sequence[Array], known: Known, *, attitude: bool = False
    ) -> None:
        """Take the effects in the model with their parameters, shapes (P, K); attitude where others ask for it."""
        self._known = known
        self._pairs = list(zip(hooks, effects, strict=True))
        self._attitude = attitude or any(hook.needs_attitude for hook in hooks)
        edges = np.cumsum([3 + 4 * self._attitude, *(hook.states for hook in hooks)])
        self._own = [slice(first, last) for first, last in pairwise(edges.tolist())]
        # Of many hypotheses together few act on the motion itself; the others cost nothing here.
        self._acting = {
            place: (hook, value, own)
            for place, ((hook, value), own) in enumerate(zip(self._pairs, self._own, strict=True))
            if acts_on_motion(hook)
        }
        self._hides = any(hook.states for hook, _, _ in self._acting.values())
        self._at = dict[tuple[int, int, int], Known]()

    def guessed(self, start: Array, rates: Array) -> Array:
        """Return states at all nodes of a motion that is known about, shape (R, M + 1, 1, S).

        The effects' own states stay as they begin.

        Args:
            start: real states at the first node, shape (R, 1, 1, S).
            rates: ω at all nodes, shape (R, M + 1, 3), rad/s.
        """
        states = np.repeat(start, rates.shape[1], axis=1)
        if self._attitude:
            states[:, :, 0, 3:7] = kernels.turned_along(rates, self._known.step)
        later = self.with_rates(states, rates[:, :, None], slice(0, states.shape[1]))
        return np.concatenate([start, later[:, 1:]], axis=1)

    @property
    def groups(self) -> list[slice]:
        """Which states are of a kind: momentum, attitude, then each effect's."""
        attitude = [slice(3, 7)] if self._attitude else []
        return [slice(0, 3), *attitude, *(own for own in self._own if own.start < own.stop)]

    def initial(self, initial_rate: Array, sets: int, turn: Array | None = None) -> Array:
        """Return the states at the first node of every run, shape (R, 1, P, S).

        Args:
            initial_rate: ω there, shape (R, P, 3), rad/s.
            sets: P; an array with a single set stands for all.
            turn: of each run's first attitude from what is known of it, shape (R, P, 3), rad; None for none.
        """
        runs = len(initial_rate)
        parts = [np.zeros((runs, 1, 3))]
        if self._attitude:
            parts.append(_small_turn(np.zeros((runs, 1, 3)) if turn is None else turn))
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
        begin, middle, end = (self.known_at(steps, later) for later in range(3))
        state, step = states.reshape(-1, *states.shape[2:]), begin.step[:, None, None]
        first = self._slope(state, begin)
        second = self._slope(state + step / 2 * first, middle)
        third = self._slope(state + step / 2 * second, middle)
        fourth = self._slope(state + step * third, end)
        after = state + step / 6 * (first + 2 * second + 2 * third + fourth)
        return after.reshape(*states.shape[:2], *after.shape[1:])

    @property
    def has_attitude(self) -> bool:
        """Whether the attitude is among the states."""
        return self._attitude

    @property
    def step(self) -> Series:
        """Of each run, shape (R,), s."""
        return self._known.step

    @property
    def live(self) -> Array:
        """One for axes about which a run turns, zero for those that a bearing holds, shape (R, 1, 1, 3) or less."""
        return np.ones(1) if self._known.bearing is None else self._known.bearing.live.astype(np.float64)

    def attitude(self, states: Array) -> Array:
        """Return R_RB of real states, shape (..., S): (..., 3, 3); the identity where no effect asks for it."""
        if not self._attitude:
            return np.eye(3)
        matrix = kernels.matrix_of_quaternion(states[..., 3:7].reshape(1, -1, 4))
        return matrix.reshape(*states.shape[:-1], 3, 3)

    def instant(self, at: int, body_rate: Array, attitude: Array, own_state: Array) -> Instant:
        """Return an instant of the grid for an effect with states of its own, shapes as in `Instant`."""
        return _instant(self._known, self._known.time[:, at, None], body_rate, attitude, own_state)

    def known_at(self, nodes: slice, later: int) -> Known:
        """Return what is known so many half steps after nodes; a motion is searched in the same blocks of them."""
        key = nodes.start, nodes.stop, later
        if key not in self._at:
            self._at[key] = self._known.at(_half_steps(nodes, later))
        return self._at[key]

    def slope_and_tangents(self, state: Array, known: Known) -> tuple[Array, Array]:
        """Return ω, shape (R W, 3), rad/s, and the slope with its derivatives, as `slopes` has them.

        Args:
            state: real states of one parameter set, shape (R W, 1, S).
            known: at these instants.
        """
        rate = self._body_rate(state, known)[:, 0]
        bearing = known.bearing
        found = slopes(
            state[:, 0],
            rate,
            self._whole_momentum(state, rate[:, None], known)[:, 0],
            known.torque_B[:, 0],
            known.inverse[:, 0],
            self._hidden_tangents(state),
            _FREE if bearing is None else bearing.live[:, 0].astype(np.float64),
            _UNCOUPLED if bearing is None else bearing.coupling[:, 0],
            self._of_effects(state, rate, known),
            self._attitude,
        )
        return rate, found

    def rate_and_tangents(self, state: Array, known: Known) -> tuple[Array, Array, Array]:
        """Return ω of real states, shape (R W, 3), rad/s, and its derivatives by state and by h."""
        inverse = np.broadcast_to(known.inverse[:, 0], (len(state), 3, 3))
        by_state = -inverse @ self._hidden_tangents(state)
        by_state[..., :3] += inverse
        return self._body_rate(state, known)[:, 0], by_state, -inverse

    def _hidden_tangents(self, state: Array) -> Array:
        """Return the derivatives of the momentum that the effects' states hold by all states, shape (R W, 3, S)."""
        tangents = np.zeros((len(state) if self._hides else 1, 3, state.shape[-1]))
        for hook, value, own in self._acting.values():
            if hook.states:
                disturbed = state[..., own] + 1j * COMPLEX_STEP * np.eye(hook.states)
                held = np.broadcast_to(hook.hidden_momentum(value, disturbed), (*disturbed.shape[:2], 3))
                tangents[..., own] = np.swapaxes(held.imag, -1, -2) / COMPLEX_STEP
        return tangents

    def _of_effects(self, state: Array, rate: Array, known: Known) -> Array:
        """Return the torques and slopes of the effects and their derivatives, by what each depends on, as `slopes`."""
        size = state.shape[-1]
        found = np.zeros((len(state) if self._acting else 1, size, size + BESIDE))
        by_state, by_rate, slope = found[..., :size], found[..., size : size + 3], found[..., size + 3]
        for hook, value, own in self._acting.values():
            turning, attitude, base = 3 * hook.needs_rate, 4 * hook.needs_attitude, np.eye(3)
            by_own = turning + attitude
            steps = 1j * COMPLEX_STEP * np.eye(max(by_own + hook.states, 1))
            rates = np.broadcast_to(rate[:, None], (len(state), len(steps), 3))
            if turning:
                rates = rates + steps[:, :3]
            if attitude:
                base = kernels.matrix_of_quaternion(state[..., 3:7] + steps[:, turning:by_own])
            at = _instant(known, known.time, rates, base, state[..., own] + steps[:, by_own:])
            shape = (len(state), len(steps), 3)
            parts = [(slice(0, 3), np.broadcast_to(hook.torque(value, at), shape))] if gives_torque(hook) else []
            if hook.states:
                parts.append((own, np.broadcast_to(hook.state_rate(value, at), (*shape[:2], hook.states))))
            for rows, values in parts:
                slope[:, rows] += values[:, 0].real
                if np.iscomplexobj(values):
                    by = np.swapaxes(values.imag, -1, -2) / COMPLEX_STEP
                    if turning:
                        by_rate[:, rows] += by[..., :3]
                    by_state[:, rows, 3 : 3 + attitude] += by[..., turning:by_own]
                    by_state[:, rows, own] += by[..., by_own:]
        return found

    def own_changes(
        self, effects: Sequence[Array], state: Array, body_rate: Array, known: Known
    ) -> Iterator[tuple[NDArray[np.intp], Array, Array | None]]:
        """Yield what complex steps of the effects' own parameters change where the motion is as it is.

        Args:
            effects: parameters with the steps, shapes (P, K).
            state: real, of one parameter set, shape (R W, 1, S).
            body_rate: ω that goes with it, shape (R W, 3), rad/s.
            known: real, of these instants.

        Yields:
            Of each effect that acts: which parameter sets step its own, Q of them; the change of the slope, shape
            (R W, Q, S), and of the momentum that the effect's states hold, shape (R W, Q, 3). Of one without states the
            change of the first three slopes alone, shape (R W, Q, 3), and None.
        """
        attitude = kernels.matrix_of_quaternion(state[..., 3:7]) if self._attitude else np.eye(3)
        for place, (hook, _, own) in self._acting.items():
            value = effects[place]
            stepped = np.flatnonzero((value.imag != 0.0).any(axis=1))
            if not len(stepped):
                continue
            chosen, sides = value[stepped], (len(state), len(stepped))
            at = _instant(
                known,
                known.time,
                np.broadcast_to(body_rate[:, None], (*sides, 3)),
                np.broadcast_to(attitude, (*sides, 3, 3)),
                np.broadcast_to(state[..., own], (*sides, hook.states)),
            )
            torque_B = hook.torque(chosen, at)
            if not hook.states and not np.iscomplexobj(torque_B):
                continue
            turning = np.broadcast_to(torque_B.imag, (*sides, 3))
            if known.bearing is not None:
                turning = known.bearing.live * turning
            if not hook.states:
                yield stepped, turning, None
                continue
            slope = np.zeros((*sides, state.shape[-1]))
            slope[..., :3], slope[..., own] = turning, hook.state_rate(chosen, at).imag
            held = np.broadcast_to(hook.hidden_momentum(chosen, at.state).imag, (*sides, 3))
            yield stepped, slope, held

    def _hidden(self, state: Array) -> Array:
        held = np.zeros(3)
        for hook, value, own in self._acting.values():
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
        for hook, value, own in self._acting.values():
            at = _instant(known, known.time, body_rate, attitude, state[..., own])
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


def _small_turn(turn: Array) -> Array:
    """Return the quaternion of a small turn, shape (..., 4); the vector of it, shape (..., 3), is twice its sine."""
    half = 0.5 * turn
    return np.concatenate([np.sqrt(1.0 - (half**2).sum(axis=-1, keepdims=True)), half], axis=-1)


def _instant(known: Known, time: Array, body_rate: Array, attitude: Array, own_state: Array) -> Instant:
    return Instant(
        time=time,
        body_rate=body_rate,
        attitude=attitude,
        state=own_state,
        first_NB=known.first_NB,
        surroundings=known.surroundings,
    )


def _inverted(known: Known) -> Array:
    """Return J(d) - Ĵ itself, of a platform on a bearing the block of its free axes."""
    if known.bearing is None:
        return symmetric_inverse(known.inverse)
    held = np.eye(3) * ~known.bearing.live[..., None]
    return symmetric_inverse(known.inverse + held) - held


def _half_steps(steps: slice, later: int) -> slice:
    """Return the grid's instants so many half steps after the beginnings of steps."""
    return slice(2 * steps.start + later, 2 * steps.stop + later, 2)
