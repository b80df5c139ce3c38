"""How motions change with parameters, to first order: equations of variation of the steps that found a motion.

A step of the classical rule is x + step/6 (k1 + 2 k2 + 2 k3 + k4). Whatever changes its four slopes, by f1 to f4 where
the states stay as they are, changes what the step reaches by W1 f1 + ... + W4 f4; the matrices W are the same for all
parameters. So the motion under a hundred parameters costs that of one, and a few multiplications for each.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from testbed.arrays import Array
from testbed.prediction.equations import Equations, Known, acts_on_motion, gives_torque
from testbed.prediction.hooks import Hooks, Instant
from testbed.prediction.kernels import Polynomials, as_large, carried, changed_by, driven, forced, forced_by_inertia
from testbed.prediction.tangents import BESIDE, tangents, weights

_INSTANTS = (0, 1, 1, 2)
"""When a step takes its slopes, in half steps from its beginning."""
_AT_ONCE = 10_000
"""States of one run and parameter set that are stepped together: beyond it arrays leave the processor's cache."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Linearised:
    """The steps along a motion of R runs, M steps each, and how they change; all real.

    Attributes:
        ahead: states after the steps, shape (R, M, 1, S).
        tangents: their derivatives by the states before, transposed, shape (R, M, S, S).
        states: where each slope is taken, shape (4, R, M, S).
        rates: ω there, shape (4, R, M, 3), rad/s.
        by_slope: derivatives of the states after by each slope, W, shape (4, R, M, S, S).
        by_momentum: by the momentum h that the units hold when it is taken, shape (4, R, M, S, 3).
    """

    ahead: Array
    tangents: Array
    states: Array
    rates: Array
    by_slope: Array
    by_momentum: Array


def blocks_of(steps: int, width: int) -> list[slice]:
    """Return which steps are taken together, each of so many runs and parameter sets."""
    length = max(1, _AT_ONCE // width)
    return [slice(first, min(first + length, steps)) for first in range(0, steps, length)]


def linearised(equations: Equations, states: Array) -> Linearised:
    """Return the steps from real states of one parameter set, shape (R, M, 1, S), and how they change."""
    runs, steps, _, size = states.shape
    parts = [_linearised(equations, states[:, block], block) for block in blocks_of(steps, runs * (size + 3))]
    return Linearised(
        ahead=np.concatenate([part.ahead for part in parts], axis=1),
        tangents=np.concatenate([part.tangents for part in parts], axis=1),
        states=np.concatenate([part.states for part in parts], axis=2),
        rates=np.concatenate([part.rates for part in parts], axis=2),
        by_slope=np.concatenate([part.by_slope for part in parts], axis=2),
        by_momentum=np.concatenate([part.by_momentum for part in parts], axis=2),
    )


def nearly_tangents(equations: Equations, states: Array) -> Array:
    """Return nearly the tangents of the steps between real states at all nodes, shape (R, M + 1, 1, S), alike.

    The classical rule makes 1 + F + F²/2 + F³/6 + F⁴/24 of slopes whose derivatives by the states, times the step, are
    F all along it; here they are the mean of those at its ends. That takes a quarter of the time, and is near enough
    for Newton's method.
    """
    runs, nodes, _, size = states.shape
    blocks = blocks_of(nodes, runs * (size + 3))
    flat = (states[:, block].reshape(-1, 1, size) for block in blocks)
    found = [
        equations.slope_and_tangents(state, equations.known_at(block, 0))[1]
        for state, block in zip(flat, blocks, strict=True)
    ]
    by_state = np.concatenate([each.reshape(runs, -1, size, size + BESIDE) for each in found], axis=1)[..., :size]
    mean = 0.5 * equations.step[:, None, None, None] * (by_state[:, :-1] + by_state[:, 1:])
    nearly = whole = np.eye(size)
    for power in (4.0, 3.0, 2.0, 1.0):
        nearly = whole + mean @ nearly / power
    return np.swapaxes(nearly, -1, -2)


@dataclass(frozen=True, kw_only=True, eq=False)
class Motion:
    """A motion of one parameter set that was found.

    Attributes:
        equations: real.
        states: at all nodes, shape (R, M + 1, 1, S).
        along: its steps.
    """

    equations: Equations
    states: Array
    along: Linearised

    @cached_property
    def stage_attitudes(self) -> Array:
        """R_RB there, shape (4, R, M, 3, 3); the identity where no effect asks for it."""
        return np.broadcast_to(self.equations.attitude(self.along.states), (*self.along.states.shape[:3], 3, 3))

    @property
    def rate_by_state(self) -> Array:
        """Derivatives of ω at the nodes by the states, shape (R, M + 1, 3, S)."""
        return self._at_nodes[1]

    @property
    def rates(self) -> Array:
        """ω at the nodes, shape (R, M + 1, 3), rad/s."""
        return self._at_nodes[0]

    @property
    def rate_by_momentum(self) -> Array:
        """Derivatives of ω at the nodes by the momentum that is held, shape (R, M + 1, 3, 3)."""
        return self._at_nodes[2]

    @cached_property
    def _at_nodes(self) -> tuple[Array, Array, Array]:
        runs, nodes, _, size = self.states.shape
        at_nodes = self.equations.known_at(slice(0, nodes), 0)
        rates, by_state, by_momentum = self.equations.rate_and_tangents(self.states.reshape(-1, 1, size), at_nodes)
        return (
            rates.reshape(runs, nodes, 3),
            by_state.reshape(runs, nodes, 3, size),
            by_momentum.reshape(runs, nodes, 3, 3),
        )

    @cached_property
    def by_torque(self) -> Array:
        """Derivatives of the states after each step by a torque on the body in each slope, shape (4, R, M, S, 3)."""
        return self.along.by_slope[..., :3] * self.equations.live


def _linearised(equations: Equations, states: Array, steps: slice) -> Linearised:
    runs, length, _, size = states.shape
    known = [equations.known_at(steps, later) for later in range(3)]
    state, step = states.reshape(-1, 1, size), known[0].step
    taken, rates, slopes = list[Array](), list[Array](), np.empty((4, len(state), size, size + BESIDE))
    for stage, (share, instant) in enumerate(zip((0.0, 0.5, 0.5, 1.0), _INSTANTS, strict=True)):
        ahead = slopes[stage - 1, :, None, :, -1] if stage else 0.0
        taken.append(state + share * step[:, None, None] * ahead)
        rate, slopes[stage] = equations.slope_and_tangents(taken[-1], known[instant])
        rates.append(rate)
    by_slope = weights(slopes, step)
    first, second, third, fourth = slopes[..., -1]
    after = state[:, 0] + step[:, None] / 6.0 * (first + 2.0 * second + 2.0 * third + fourth)
    return Linearised(
        ahead=after.reshape(runs, length, 1, size),
        tangents=tangents(slopes, by_slope).reshape(runs, length, size, size),
        states=np.stack(taken).reshape(4, runs, length, size),
        rates=np.stack(rates).reshape(4, runs, length, 3),
        by_slope=by_slope[..., :size].reshape(4, runs, length, size, size),
        by_momentum=by_slope[..., size:].reshape(4, runs, length, size, 3),
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class Speck:
    """An effect too small to move the body, with its parameters, shape (P, K), whose real parts may differ by set."""

    hook: Hooks
    value: Array


def disturbed_rates(
    motion: Motion, effects: Sequence[Array], specks: Sequence[Speck], known: Known, start: Array
) -> Array:
    """Return ω at the nodes under parameter sets that lie complex steps away, shape (R, M + 1, P, 3), rad/s.

    Args:
        motion: without the steps and the specks.
        effects: parameters of its effects with the steps, shapes (P, K).
        specks: effects beside these.
        known: with the steps.
        start: at the first node, shape (R, 1, P, S).
    """
    runs, nodes, _, size = motion.states.shape
    rates, by_node = motion.rates, motion.rate_by_momentum
    carrying = (start, *effects, *(speck.value for speck in specks), known.momentum_B, known.torque_B)
    if known.inertia_step is None and not any(map(np.iscomplexobj, carrying)):
        return rates[:, :, None]
    turned = np.zeros((runs, nodes, start.shape[2], 3))
    _force(turned, known, by_node[None], None, rates[None], (0,))
    flat, at_nodes = motion.states.reshape(-1, 1, size), motion.equations.known_at(slice(0, nodes), 0)
    for stepped, _, held in motion.equations.own_changes(effects, flat, rates.reshape(-1, 3), at_nodes):
        if held is not None:
            changed_by(turned, by_node, held, stepped)
    added, begun = _added(motion, effects, known, start.shape[2]), start.imag[:, 0].copy()
    for speck in specks:
        _drive(speck, motion, rates, begun, added, turned, by_node)
    changes = carried(motion.along.tangents, begun, added)
    turned += changes @ np.swapaxes(motion.rate_by_state, -1, -2)
    return np.asarray(rates[:, :, None] + 1j * turned)


def _added(motion: Motion, effects: Sequence[Array], known: Known, sets: int) -> Array:
    """Return what steps add to the changes of the states, shape (R, M, P, S)."""
    along = motion.along
    _, runs, length, size = along.states.shape
    added, steps = np.zeros((runs, length, sets, size)), slice(0, length)
    of_slopes = zip(_INSTANTS, along.states, along.rates, along.by_slope, along.by_momentum, strict=True)
    for instant, states, rates, by_slope, by_momentum in of_slopes:
        flat, at = states.reshape(-1, 1, size), motion.equations.known_at(steps, instant)
        for stepped, slope, held in motion.equations.own_changes(effects, flat, rates.reshape(-1, 3), at):
            changed_by(added, by_slope, slope, stepped)
            if held is not None:
                changed_by(added, by_momentum, held, stepped)
    _force(added, known, along.by_momentum, motion.by_torque, along.rates, _INSTANTS)
    return added


def _drive(
    speck: Speck, motion: Motion, rates: Array, begun: Array, added: Array, turned: Array, by_node: Array
) -> None:
    """Add what a speck does: its states follow the motion, which they do not change but to first order.

    Args:
        speck: an effect.
        motion: what it follows.
        rates: ω at the nodes, shape (R, M + 1, 3), rad/s.
        begun: changes of the states at the first node, shape (R, P, S).
        added: to the changes of the states by every step, shape (R, M, P, S).
        turned: changes of ω at the nodes, shape (R, M + 1, P, 3), rad/s.
        by_node: derivatives of ω at the nodes by the momentum that is held, shape (R, M + 1, 3, 3).
    """
    hook, value = speck.hook, speck.value
    if not acts_on_motion(hook):
        return
    sides, step = (len(rates), len(value)), motion.equations.step[:, None, None]
    along = motion.along
    stages = (4, *along.rates.shape[1:3], len(value))
    body_rates = np.broadcast_to(along.rates[..., None, :], (*stages, 3))
    attitudes = np.broadcast_to(motion.stage_attitudes[..., None, :, :], (*stages, 3, 3))
    state = np.asarray(hook.initial_state(value, np.broadcast_to(rates[:, :1], (*sides, 3))))
    state = np.broadcast_to(state, (*sides, hook.states)).astype(np.complex128)
    if hook.states:
        begun[..., :3] += _imaginary(hook.hidden_momentum(value, state), sides)
    if hook.quadratic:
        along_it = (along.rates, motion.equations.step)
        changes = driven(*_polynomials(hook, value), state, along_it, along.by_momentum, by_node)
        added += changes[:, :-1, :, :-3]
        turned += changes[..., -3:]
        return
    for index in range(added.shape[1]):
        reached, slopes = state, list[Array]()
        for stage, (share, instant) in enumerate(zip((0.0, 0.5, 0.5, 1.0), _INSTANTS, strict=True)):
            if stage and hook.states:
                reached = state + share * step * slopes[-1]
            at = motion.equations.instant(
                2 * index + instant,
                body_rates[stage, :, index],
                attitudes[stage, :, index],
                reached,
            )
            if gives_torque(hook):
                torque_B = _imaginary(hook.torque(value, at), sides)
                added[:, index] += torque_B @ np.swapaxes(motion.by_torque[stage][:, index], -1, -2)
            if hook.states:
                held = _imaginary(hook.hidden_momentum(value, reached), sides)
                added[:, index] += held @ np.swapaxes(along.by_momentum[stage][:, index], -1, -2)
                if not stage:
                    turned[:, index] += held @ np.swapaxes(by_node[:, index], -1, -2)
                slopes.append(np.asarray(hook.state_rate(value, at)))
        if hook.states:
            state = state + step / 6.0 * (slopes[0] + 2.0 * slopes[1] + 2.0 * slopes[2] + slopes[3])
    if hook.states:
        held = _imaginary(hook.hidden_momentum(value, state), sides)
        turned[:, -1] += held @ np.swapaxes(by_node[:, -1], -1, -2)


_ROUNDING = 1e-12
"""Share of the largest number of a polynomial's probes below which a coefficient is what rounding left of none."""


def _polynomials(hook: Hooks, value: Array) -> tuple[Polynomials, Polynomials]:
    """Return the rate of a quadratic effect's states, and the momentum that they hold, of parameters (P, K).

    Of numbers z, the states and ω, the values at 0, ±z_i and z_i + z_j tell all coefficients.
    """
    count = hook.states + 3
    units = np.eye(count)
    first, second = np.triu_indices(count, 1)
    probes = np.concatenate([np.zeros((1, count)), units, -units, units[first] + units[second]])
    every = np.broadcast_to(probes[:, None], (len(probes), len(value), count))
    at = Instant(
        time=np.zeros((len(probes), 1)),
        body_rate=every[..., hook.states :],
        attitude=np.eye(3),
        state=every[..., : hook.states].astype(np.complex128),
    )
    pairs = np.concatenate(
        [
            [(0, 0)],
            np.stack([np.zeros(count, dtype=np.intp), np.arange(1, count + 1)], axis=1),
            np.stack([np.arange(1, count + 1)] * 2, axis=1),
            np.stack([first, second], axis=1) + 1,
        ]
    )
    found = []
    for values in (hook.state_rate(value, at), hook.hidden_momentum(value, at.state)):
        none, plus, minus, both = np.split(values, np.cumsum([1, count, count]))
        mixed = both - plus[first] - plus[second] + none
        factors = np.concatenate([none, 0.5 * (plus - minus), 0.5 * (plus + minus) - none, mixed])
        parts = ((factors.real, values.real), (factors.imag, values.imag))
        real, imaginary = (np.where(np.abs(one) > _ROUNDING * np.abs(of).max(), one, 0.0) for one, of in parts)
        factors = real + 1j * imaginary
        pair, polynomial = np.nonzero((factors != 0.0).any(axis=1))
        terms = np.column_stack([polynomial, pairs[pair]])
        found.append(Polynomials(terms=terms, factors=factors[pair, :, polynomial].T))
    return found[0], found[1]


def _imaginary(vectors: Array, sides: tuple[int, int]) -> Array:
    return as_large(vectors, (*sides, 3)).imag


def _force(
    added: Array, known: Known, by_momentum: Array, by_torque: Array | None, rates: Array, instants: tuple[int, ...]
) -> None:
    """Add what steps of the momentum, the torque and the inertia do, to changes of shape (R, W, P, S)."""
    if np.iscomplexobj(known.momentum_B):
        forced(added, by_momentum, known.momentum_B.imag, instants)
    if by_torque is not None and np.iscomplexobj(known.torque_B):
        forced(added, by_torque, known.torque_B.imag, instants)
    if known.inertia_step is not None:
        forced_by_inertia(added, by_momentum, rates, known.inertia_step, instants)
