"""The motion of many runs under many parameter sets, all steps of the integration together.

A step takes the states at one node to those at the next, x ↦ Φ(x). Stepping along the nodes is slow, a few numbers at
a time. Instead Newton's method finds the states at all nodes that follow one another: Φ of all of them, and its
tangent A, in a few large arrays; then the corrections, which the linear recursion δ ↦ A δ + (Φ - x) carries along.
The same tangent carries derivatives along, so that those with respect to parameters need Φ once more.

Source: Chartier and Philippe, "A parallel shooting technique for solving dissipative ODE's", Computing (1993).
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache, reduce

import numpy as np
from numpy.typing import NDArray
from typing_extensions import override

from testbed.arrays import Array
from testbed.dynamics.gyrostat import require_bounded
from testbed.dynamics.inertia import symmetric_inverse
from testbed.errors import InputError
from testbed.prediction.algebra import inertia_matrix
from testbed.prediction.environment import environment_hooks
from testbed.prediction.equations import Bearing, Equations, Known, acts_on_motion
from testbed.prediction.grid import Gimbals, Grid
from testbed.prediction.held import held_inertia, held_momentum
from testbed.prediction.hooks import Hooks, overrides
from testbed.prediction.kernels import carried
from testbed.prediction.variation import Motion, Speck, blocks_of, disturbed_rates, linearised, nearly_tangents

_ROUNDS = 16
"""Of Newton's method: from gyro samples it takes four or five; what it does not find is stepped along."""
_NEARLY = 8
"""Of these rounds after which new tangents are exact: until then those that take a quarter of the time lead as near.

Source: chosen; with these, the motions of an orbit with a mode of slosh or of an appendage took three to six."""
_FOUND = 1e-7
"""Share of the largest state by which a correction is the last but one: with tangents of the motion that it leads to,
the next is its square."""
_NEARER = 0.1
"""Share of the correction before beyond which the tangents are taken anew: with old ones corrections shrink by the
share by which the motion was off when they were taken, a hundredth or less."""
_WATCHED = 64
"""Steps after which a motion that is stepped along is looked at: one that ran away is not followed to its end."""
_MOTIONS = 4
"""That are kept: those of the present model, as all hypotheses have it, and of the parts of a grid in turn."""
GRIDS = 32
"""For which what no parameter changes is kept: parts of fitted and held-out runs, with the gyro's errors of some
models."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Values:
    """Parameter sets, P of them.

    Attributes:
        theta: inertia parameters, shape (P, 6), kg·m².
        initial_rate: ω at each run's first sample, shape (R, P, 3), rad/s.
        effects: parameters of each effect, in the order of the hooks, shapes (P, K).
        trim: constant torque of the actuators that their telemetry does not hold, body axes, shape (R, P, 3), N·m;
            None where there is none.
        first_turn: small turn by which each run's first attitude is off from what is known of it, body axes, shape
            (R, P, 3), rad; None where that is exact.
        specks: number of the last effects that are too small to move the body: their parameter sets may differ in more
            than complex steps, and share one motion all the same.
        as_trial: whether a motion that Newton's method does not find is an error, and not stepped along.
    """

    theta: Array
    initial_rate: Array
    effects: tuple[Array, ...]
    trim: Array | None = None
    first_turn: Array | None = None
    specks: int = 0
    as_trial: bool = False

    @property
    def sets(self) -> int:
        """P; an array with a single set stands for all."""
        return max(len(self.theta), *(len(each[0]) for each in self.by_run), *map(len, self.effects), 1)

    @property
    def by_run(self) -> tuple[Array, ...]:
        """What each run has of its own, shapes (R, P, 3): in the order of the columns of derivatives."""
        return tuple(each for each in (self.initial_rate, self.first_turn, self.trim) if each is not None)

    def of_runs(self, which: NDArray[np.intp]) -> Values:
        """Return the same of some runs."""
        trim, turn = (None if each is None else each[which] for each in (self.trim, self.first_turn))
        return replace(self, initial_rate=self.initial_rate[which], trim=trim, first_turn=turn)

    @property
    def own_size(self) -> int:
        """Number of parameters that each run has of its own."""
        return 3 * len(self.by_run)


def node_rates(grid: Grid, hooks: Sequence[Hooks], values: Values) -> Array:
    """Return ω at the ends of the integration's steps, shape (R, P, M + 1, 3), rad/s.

    Args:
        grid: the runs.
        hooks: the effects in the model.
        values: parameter sets.

    Raises:
        InputError: the motion leaves the finite numbers.
    """
    hooks, values = _with_outside(grid, hooks, values)
    one_motion = _is_one_motion(values)
    known = _known(grid, hooks, values, one_motion=one_motion)
    with np.errstate(over="ignore", invalid="ignore"):
        if one_motion:
            rates = _beside(_found(grid, hooks, values, known), hooks, values, known)
        else:
            equations = Equations(hooks, values.effects, known)
            states = _stepped_along(equations, _start(equations, values), grid)
            rates = equations.body_rates(states, slice(0, states.shape[1]))
    require_bounded(rates)
    return np.ascontiguousarray(np.swapaxes(rates, 1, 2))


def motion_of(grid: Grid, hooks: Sequence[Hooks], values: Values) -> Motion:
    """Return the motion of one parameter set; arguments and errors as `node_rates`."""
    hooks, values = _with_outside(grid, hooks, values)
    with np.errstate(over="ignore", invalid="ignore"):
        return _found(grid, hooks, values, _known(grid, hooks, values, one_motion=True))


def _with_outside(grid: Grid, hooks: Sequence[Hooks], values: Values) -> tuple[Sequence[Hooks], Values]:
    """Return the effects and their parameters with what acts on the runs from outside, if anything does."""
    outside = environment_hooks(grid)
    if outside is None:
        return hooks, values
    return [outside, *hooks], replace(values, effects=(values.theta, *values.effects))


def _stepped_along(equations: Equations, start: Array, grid: Grid) -> Array:
    """Return the states at all nodes, shape (R, M + 1, P, S), of any parameter sets, one step after the other."""
    states = [start]
    for step in range(grid.node_time.shape[1] - 1):
        if step % _WATCHED == 0:
            require_bounded(equations.body_rates(states[-1], slice(step, step + 1)))
        states.append(equations.stepped(states[-1], slice(step, step + 1)))
    return np.concatenate(states, axis=1)


def _beside(motion: Motion, hooks: Sequence[Hooks], values: Values, known: Known) -> Array:
    """Return ω at all nodes, shape (R, M + 1, P, 3), of parameter sets that lie complex steps beside a motion."""
    number = len(hooks) - values.specks
    pairs = zip(hooks[number:], values.effects[number:], strict=True)
    equations = Equations(hooks[:number], values.effects[:number], known, attitude=motion.equations.has_attitude)
    start = _start(equations, values)
    specks = [Speck(hook=hook, value=value) for hook, value in pairs]
    return disturbed_rates(motion, values.effects[:number], specks, known, start)


def _start(equations: Equations, values: Values) -> Array:
    """Return the states at the first node, shape (R, 1, P, S)."""
    return equations.initial(values.initial_rate, values.sets, values.first_turn)


def _is_one_motion(values: Values) -> bool:
    """Return whether the parameter sets differ by complex steps only, but for those of specks."""
    moving = values.effects[: len(values.effects) - values.specks]
    sets = (values.theta, *(np.swapaxes(each, 0, 1) for each in values.by_run), *moving)
    return all(bool((each.real == each[:1].real).all()) for each in sets)


@dataclass(frozen=True, eq=False)
class _MotionProblem:
    """A motion of one parameter set on a grid; two that are the same to the last bit are equal."""

    grid: Grid
    equations: Equations
    first: Array
    """States at the first node, shape (R, 1, 1, S)."""
    as_trial: bool
    key: tuple[object, ...]

    @override
    def __eq__(self, other: object) -> bool:
        return isinstance(other, _MotionProblem) and self.key == other.key

    @override
    def __hash__(self) -> int:
        return hash(self.key)


def _found(grid: Grid, hooks: Sequence[Hooks], values: Values, known: Known) -> Motion:
    """Return the motion of the first parameter set without the complex steps and the specks.

    Many derivatives in turn are taken of the same motion.
    """
    number = len(hooks) - values.specks
    effects = [value[:1].real for value in values.effects[:number]]
    attitude = any(hook.needs_attitude for hook in hooks)
    real = known.without_steps()
    equations = Equations(hooks[:number], effects, real, attitude=attitude)
    turn = None if values.first_turn is None else values.first_turn[:, :1].real
    first = equations.initial(values.initial_rate[:, :1].real, 1, turn)
    acting = [place for place, hook in enumerate(hooks[:number]) if acts_on_motion(hook)]
    alike = tuple((place, hooks[place] if vars(hooks[place]) else type(hooks[place])) for place in acting)
    numbers = tuple(each.tobytes() for each in (first, *(effects[place] for place in acting), *real.arrays))
    key = (grid, alike, attitude, known.surroundings, *numbers)
    return _motion(_MotionProblem(grid, equations, first, values.as_trial, key))


@lru_cache(maxsize=_MOTIONS)
def _motion(problem: _MotionProblem) -> Motion:
    """Return the motion; what Newton's method does not find is stepped along."""
    found = _by_newton(problem)
    if found is not None:
        return found
    if problem.as_trial:
        raise InputError("the motion runs away from the measured one")
    states = _stepped_along(problem.equations, problem.first, problem.grid)
    require_bounded(problem.equations.body_rates(states, slice(0, states.shape[1])))
    return Motion(equations=problem.equations, states=states, along=linearised(problem.equations, states[:, :-1]))


def _by_newton(problem: _MotionProblem) -> Motion | None:
    grid, equations = problem.grid, problem.equations
    states = _guess(grid, equations, problem.first)
    tangents, ahead, before = nearly_tangents(equations, states), _in_blocks(equations, states[:, :-1]), np.inf
    for round_ in range(_ROUNDS):
        change = carried(tangents, np.zeros_like(states[:, 0]), ahead - states[:, 1:])
        states = states + change
        moved = max(_share(change[..., group], states[..., group]) for group in equations.groups)
        if not np.isfinite(moved):
            return None
        if moved <= _FOUND:
            along = linearised(equations, states[:, :-1])
            change = carried(along.tangents, np.zeros_like(states[:, 0]), along.ahead - states[:, 1:])
            return Motion(equations=equations, states=states + change, along=along)
        if moved > _NEARER * before:
            nearly = round_ < _NEARLY
            tangents = nearly_tangents(equations, states) if nearly else linearised(equations, states[:, :-1]).tangents
        ahead, before = _in_blocks(equations, states[:, :-1]), moved
    return None


def _share(change: Array, whole: Array) -> float:
    """Return the largest change as a share of the largest number; zero where there are but zeros."""
    return float(np.abs(change).max() / max(np.abs(whole).max(), np.finfo(float).tiny))


def _guess(grid: Grid, equations: Equations, start: Array) -> Array:
    """Return states at all nodes as the gyro has the motion."""
    return equations.guessed(start, grid.measured_rate)


def _in_blocks(equations: Equations, states: Array) -> Array:
    """Return the states after all steps, so many together as is fast."""
    runs, steps, sets, _ = states.shape
    blocks = blocks_of(steps, runs * sets)
    return np.concatenate([equations.stepped(states[:, block], block) for block in blocks], axis=1)


def torque_of_actuators(grid: Grid, hooks: Sequence[Hooks], values: Values) -> Array:
    """Return what the actuators give along the grid with effects of one parameter set, shape (R, T, 3), N·m."""
    torque_B = _known(grid, hooks, replace(values, trim=None), one_motion=True).torque_B
    return np.asarray(torque_B[:, 0].real)


def _known(grid: Grid, hooks: Sequence[Hooks], values: Values, *, one_motion: bool) -> Known:
    momentum_B, asked_B = grid.cluster_momentum_B, grid.applied_torque_B
    inertia = [inertia_matrix(values.theta)[None, :, None]]
    pairs = list(zip(hooks, values.effects, strict=True))
    if grid.gimbals is not None:
        of_gimbals_B, held = _held_by_gimbals(grid, grid.gimbals, pairs)
        momentum_B = of_gimbals_B + momentum_B if grid.wheels.axis_B.size else of_gimbals_B
        inertia.append(held)
    for hook, value in pairs:
        asked_B = hook.asked_torque(asked_B, value, grid)
    for hook, value in pairs:
        asked_B = hook.actuator_response(asked_B, value, grid)
    torque_B = asked_B[:, :, -grid.time.shape[1] :]
    if values.trim is not None:
        torque_B = torque_B + values.trim[:, :, None]
    for hook, value in pairs:
        momentum_B = hook.cluster_momentum(momentum_B, value, grid)
        torque_B = hook.applied_torque(torque_B, value, grid)
        if overrides(hook, "hidden_inertia"):
            inertia.append(-np.broadcast_to(hook.hidden_inertia(value), (*value.shape[:1], 3, 3))[None, :, None])
        if overrides(hook, "added_inertia"):
            inertia.append(np.broadcast_to(hook.added_inertia(value, grid), (*value.shape[:1], 3, 3))[None, :, None])
    known = Known(
        time=grid.time,
        step=grid.step,
        momentum_B=momentum_B,
        torque_B=torque_B,
        inverse=symmetric_inverse(_sum(part.real[:, :1] if one_motion else part.real for part in inertia)),
        inertia_step=_sum(part.imag for part in inertia) if any(map(np.iscomplexobj, inertia)) else None,
    )
    if grid.runs[0].surroundings is not None:
        known = replace(known, first_NB=_first_attitudes(grid), surroundings=grid.runs[0].surroundings)
    return known if grid.turns_freely else _on_bearing(known, grid, _sum(inertia))


def _first_attitudes(grid: Grid) -> Array:
    """Return R_NB at each run's first sample, shape (R, 1, 3, 3)."""
    pairs = [(run.surroundings, run.gyro_time[:1]) for run in grid.runs]
    return np.stack([around.attitude(time) for around, time in pairs if around is not None])


def _on_bearing(known: Known, grid: Grid, inertia: Array) -> Known:
    """Return the same of platforms that a bearing holds about some axes: only the others' block of J is inverted."""
    live = grid.live[:, None, None, :]
    block = live[..., :, None] & live[..., None, :]
    held = np.eye(3) * ~live[..., None]
    whole = inertia.real[:, : known.inverse.shape[1]]
    return replace(
        known,
        inverse=np.where(block, symmetric_inverse(np.where(block, whole, held)), 0.0),
        bearing=Bearing(live=live, coupling=np.where(~live[..., :, None] & live[..., None, :], inertia, 0.0)),
    )


def _sum(parts: Iterable[Array]) -> Array:
    """Return the sum of arrays of shapes (R, P, T, 3, 3) that broadcast."""
    return reduce(np.add, parts)


def _held_by_gimbals(grid: Grid, gimbals: Gimbals, pairs: Sequence[tuple[Hooks, Array]]) -> tuple[Array, Array]:
    """Return h, shape (R, P, T, 3), N·m·s, and J(d) - J(0), shape (R, P, T, 3, 3), kg·m², with effects (P, K)."""
    acting = [(hook, value) for hook, value in pairs if overrides(hook, "gimbals")]
    if not acting:
        return _held_as_recorded(gimbals)
    hooks, effects = zip(*acting, strict=True)
    distinct, place = distinct_sets(effects)
    changed = effective_gimbals(grid, hooks, distinct)
    assert changed is not None

    def of_all_sets(held: Array) -> Array:
        return held[:, place] if 1 < len(distinct[0]) == held.shape[1] else held

    momentum_B, inertia = _held(changed)
    return of_all_sets(momentum_B), of_all_sets(inertia)


def distinct_sets(effects: Sequence[Array]) -> tuple[list[Array], NDArray[np.intp]]:
    """Return the parameter sets of effects that differ, shapes (D, K), and which of them each of P sets is, shape (P,).

    Most sets are a step in what does not change these effects.

    Args:
        effects: parameters of some effects, shapes (P, K); an array with a single set stands for all.
    """
    sizes = np.cumsum([value.shape[1] for value in effects])[:-1]
    sets = max(map(len, effects))
    rows = np.concatenate([np.broadcast_to(value, (sets, value.shape[1])) for value in effects], axis=1)
    distinct, place = np.unique(rows, axis=0, return_inverse=True)
    return np.split(distinct, sizes, axis=1), place.ravel()


def _held(gimbals: Gimbals) -> tuple[Array, Array]:
    return held_momentum(gimbals), held_inertia(gimbals)


@lru_cache(maxsize=GRIDS)
def _held_as_recorded(gimbals: Gimbals) -> tuple[Array, Array]:
    """Return what the units of a grid hold by telemetry: no parameter changes it."""
    return _held(gimbals)


def effective_gimbals(grid: Grid, hooks: Sequence[Hooks], effects: Sequence[Array]) -> Gimbals | None:
    """Return the units as they are, instead of as telemetry has them; None where there are none.

    Args:
        grid: the runs.
        hooks: the effects in the model.
        effects: their parameters, shapes (P, K).
    """
    gimbals = grid.gimbals
    if gimbals is not None:
        for hook, value in zip(hooks, effects, strict=True):
            gimbals = hook.gimbals(gimbals, value, grid)
    return gimbals
