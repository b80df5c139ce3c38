"""Formulas against a residual that no effect of the library explains: linearised, refitted, compared like effects.

The response to a torque at every knot of every run turns each formula's values along the predicted motion into its
signature: two thousand of them cost no more than a few predictions. Those with the most evidence, their share of the
prior included, are refitted in the nonlinear prediction, as hypotheses of the library are.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property
from itertools import pairwise
from math import log

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import make_interp_spline

from testbed.arrays import Array
from testbed.diagnosis.candidates import Candidate, Screening, accepted, evidences
from testbed.diagnosis.data import Runs
from testbed.diagnosis.latent import (
    AT_ONCE,
    TorqueShape,
    evidence_of_any,
    on_enough_runs,
    shape_knots,
)
from testbed.diagnosis.model import Fit, Hypothesis
from testbed.diagnosis.screening import screened
from testbed.diagnosis.search import Search, log_odds_of_all, odds_together, with_effect, with_model
from testbed.diagnosis.settings import SETTINGS
from testbed.diagnosis.state import Diagnosis
from testbed.diagnosis.torque_space import Moved, TorqueSpace, normal, torque_space
from testbed.effects.body_torque import BodyTorque
from testbed.effects.formula import Formula
from testbed.formulas.grammar import MEMORIES, SCANNED, Class, patterns, shares
from testbed.formulas.law import Law, Memory, first_state_of, rate_of, value_of
from testbed.formulas.motion import Moment
from testbed.formulas.pattern import Pattern, Placement, axes_of, contains
from testbed.formulas.torque import Frame
from testbed.prediction.formula_hooks import applied_torque, laid_end_to_end
from testbed.prediction.grid import unit_count
from testbed.prediction.integration import node_rates
from testbed.rotation.kinematics import integrate_attitude
from testbed.rotation.quaternion import matrix_of

_NO_FORMULA = ("pulses", "oscillation of every run's own")
"""Kinds of torque shapes that no formula has: what comes at instants, or in every run at another phase."""
_FAR = 30.0
"""Of evidence, by which a formula may be behind the best one and still be refitted: five times what is
indistinguishable. A sine between two of the frequencies that are tried loses 5 % of its χ², 13 at 16 sigma."""


@dataclass(frozen=True, kw_only=True)
class _Tested:
    """A formula at its best start.

    Attributes:
        pattern: the formula.
        evidence: averaged over its starts, its share of the prior included.
        start: values of its constants, shape (constants,).
        starts: number of its start values.
        power: root mean square of each of its laws there, shape (laws,).
    """

    pattern: Pattern
    evidence: float
    start: Array
    starts: int
    power: Array


def may_follow_formulas(state: Diagnosis) -> bool:
    """Return whether formulas may explain what the effects in the model leave, or what they explain.

    Not over windows of torque that is known in part, where the residual is the loop's, nor beside healthy records.
    """
    belief = state.runs.belief
    asked = state.left_over or bool(state.steps)
    return asked and not state.runs.known_in_part and (belief is None or not belief.others)


def with_formulas(
    state: Diagnosis,
    search: Search,
    noise: Callable[[Diagnosis], Diagnosis],
    residual: Callable[[Diagnosis], Diagnosis],
) -> Diagnosis:
    """Return a diagnosis whose residual is more than noise with formulas for what no effect of the library explains.

    A formula explains what the effects in the model leave, or all of it in their place, whichever has the larger
    posterior odds. With it, the effects are tested again; up to three have a name together. Where effects of the
    library leave nothing, formulas take their place only if they are distinguished from these.

    Args:
        state: with its residual tested.
        search: forward and backward steps among the hypotheses of the library.
        noise: explains the noise anew with a model.
        residual: tests the residual of a model.

    Returns:
        The same diagnosis where no formula stands, with the formulas that its effects are not distinguished from.
    """
    bare = with_model(replace(state, steps=(), explained=0.0), state.baseline) if state.steps else state
    state, outdone = (state, False) if state.left_over else _with_rivals(state, bare, search)
    begun = state
    for _ in range(SETTINGS.most_effects):
        wanted = state.left_over or (outdone and state is begun)
        chosen = _best_addition(state, bare if state is begun else None, search) if wanted else None
        if chosen is None:
            break
        before, candidate, screening = chosen
        search = replace(search, testable=(*search.testable, candidate.placed), known={})
        larger = search.reconsidered(with_effect(before, candidate, screening))
        if larger.gap.fit > before.gap.fit:  # what fits worse is no explanation
            break
        grown = noise(larger)
        beside = search.screened(grown)
        further = accepted(beside)
        while further is not None and search.has_room(grown):
            grown = noise(search.reconsidered(with_effect(grown, further, beside)))
            beside = search.screened(grown)
            further = accepted(beside)
        state = residual(replace(grown, remaining=beside))
        explained = _explained(state, bare) if state.steps else 0.0
        left = evidence_of_any(state.shapes, beside.tested, beside.prior_odds.unmodelled)
        state = replace(state, explained=explained, unmodelled=explained + left)
    if not begun.left_over and state.explained < begun.explained + SETTINGS.indistinguishable:
        return begun
    # As for effects of the library: what has lower posterior odds than a torque that the grammar lacks is no name.
    lacking = [] if begun.steps else [shape for shape in begun.shapes if shape.kind in _NO_FORMULA]
    return begun if lacking and _odds_of(begun, lacking, search) > state.explained else state


def _with_rivals(state: Diagnosis, bare: Diagnosis, search: Search) -> tuple[Diagnosis, bool]:
    """Return a diagnosis with the formulas that may explain what its effects do, and whether one explains clearly more.

    Compared are the fitted runs alone, the formulas as they are linearised.
    """
    search.progress("formulas in place of effects")
    within = _in_noise_of(bare, state)
    effects, count = [step.candidate for step in state.steps], max(len(search.testable), 1)
    explained = odds_together((None, bare.model), (None, within.model), count, effects)
    every = _grammar(bare.runs)
    tested = _linearised(bare.runs, bare.model, every, shares(every))
    unmodelled = 2.0 * log(bare.runs.prior_odds.unmodelled / count)
    odds = {str(each.pattern): each.evidence + unmodelled for each in tested}
    rivals = [key for key in odds if odds[key] > explained - SETTINGS.indistinguishable]
    rivals.sort(key=lambda key: -odds[key])
    outdone = max(odds.values()) > explained + SETTINGS.indistinguishable
    return replace(state, rivals=tuple(rivals[: SETTINGS.most_refits])), outdone


def _explained(state: Diagnosis, bare: Diagnosis) -> float:
    """Return the odds of all effects in a model together against the nominal one, both in the noise of the latter."""
    return log_odds_of_all(_in_noise_of(bare, state), bare)


def _in_noise_of(bare: Diagnosis, state: Diagnosis) -> Diagnosis:
    """Return the model of a diagnosis in the noise of the nominal one."""
    return with_model(replace(bare, steps=state.steps), state.model)


def _odds_of(state: Diagnosis, shapes: Sequence[TorqueShape], search: Search) -> float:
    return evidence_of_any(shapes, max(len(search.testable), 1), state.runs.prior_odds.unmodelled)


def _best_addition(
    state: Diagnosis, bare: Diagnosis | None, search: Search
) -> tuple[Diagnosis, Candidate, Screening] | None:
    """Return the formula that explains the most, beside the effects in the model or in the place of the library's."""
    library = state.steps[0].screening if state.steps else state.remaining
    bases = [(state, state.remaining)] if search.has_room(state) and state.left_over else []
    if bare is not None and state.steps:
        bases.append((bare, search.screened(bare)))  # in the noise in which formulas are compared with it
    found = []
    for base, listed in bases:
        formulas = screened_formulas(base.runs, base.heldout, base.model, len(search.testable), search.progress)
        screening = _beside_library(formulas, listed, library)
        chosen = accepted(screening)
        if chosen is not None and isinstance(chosen.effect, Formula):
            found.append((base, chosen, screening))
    return max(found, key=lambda each: each[0].explained + each[2].odds(each[1]), default=None)


def _beside_library(formulas: Screening, listed: Screening | None, library: Screening | None) -> Screening:
    """Return formulas and the library's hypotheses together, which compete.

    Args:
        formulas: against a model.
        listed: hypotheses of the library against the same model; None where there are none.
        library: against the baseline: what the data show of each stays known.
    """
    others = [] if listed is None else [each for each in listed.candidates if not isinstance(each.effect, Formula)]
    both = sorted([*formulas.candidates, *others], key=lambda each: -each.log_bayes_factor)
    known = () if library is None else library.signatures
    shown = [each for each in known if not isinstance(each.placed.effect, Formula)]
    return replace(formulas, candidates=tuple(both), signatures=(*formulas.signatures, *shown))


def screened_formulas(
    runs: Runs, heldout: Runs | None, fit: Fit, library: int, progress: Callable[[str], None] = lambda _: None
) -> Screening:
    """Test every formula of the grammar, and refit those with the most evidence.

    Args:
        runs: that the model was fitted to.
        heldout: to verify on; None where there are none.
        fit: the present model.
        library: number of hypotheses of the library, of which each has the prior of a class of formulas.
        progress: called with what is being refitted.

    Returns:
        A screening like that of effects; evidence has the formula's share of the prior in it, p-values count all
        formulas. A formula that contains a better one, by a direction or a memory more, is no alternative to it.
    """
    progress("formulas")
    taken = {each.key for each in fit.placed}
    every = _grammar(runs)
    share = shares(every)
    tested = list(_linearised(runs, fit, every, share))
    best = sorted(_not_outdone(tested), key=lambda each: -each.evidence)
    moment = runs.mean_moment(fit.theta)
    effects = [
        Formula(each.pattern, typical_value=each.power, moment=moment, start=each.start, scan_count=each.starts)
        for each in best[: SETTINGS.most_refits]
        if each.evidence > best[0].evidence - _FAR
    ]
    placed = [Hypothesis(effect=each, component=each.components[0]) for each in effects]
    found = screened(runs, heldout, fit, [each for each in placed if each.key not in taken], progress)
    of = {str(pattern): log(of_class * runs.prior_odds.unmodelled) for pattern, of_class in share.items()}
    candidates = tuple(
        replace(
            each,
            log_bayes_factor=each.log_bayes_factor + 2.0 * of[each.component],
            size_penalty=each.size_penalty - 2.0 * of[each.component],
            p_value=min(1.0, each.p_value * len(tested) / max(found.tested, 1)),
        )
        for each in found.candidates
    )
    ordered = sorted(candidates, key=lambda each: -each.log_bayes_factor)
    kept = [
        each
        for place, each in enumerate(ordered)
        if not any(contains(_pattern(each), _pattern(better)) for better in ordered[:place])
    ]
    return replace(found, candidates=tuple(kept), tested=max(library, 1), linearised={})


def _grammar(runs: Runs) -> Mapping[Class, tuple[Pattern, ...]]:
    """Return the formulas of what the telemetry of runs shows."""
    return patterns(unit_count(runs.grid), torque=runs.grid.runs[0].applied_torque is not None)


def _pattern(candidate: Candidate) -> Pattern:
    assert isinstance(candidate.effect, Formula)
    return candidate.effect.pattern


def _not_outdone(tested: Sequence[_Tested]) -> Iterator[_Tested]:
    """Yield formulas, those with a memory where the data say more for them than for the same without."""
    evidence = {each.pattern: each.evidence for each in tested}
    for each in tested:
        bare = replace(each.pattern, laws=tuple(Law.of(*law.factors) for law in each.pattern.laws))
        if bare == each.pattern or each.evidence > evidence.get(bare, -np.inf):
            yield each


def _linearised(
    runs: Runs, fit: Fit, every: Mapping[Class, tuple[Pattern, ...]], share: Mapping[Pattern, float]
) -> Iterator[_Tested]:
    """Yield every formula with its evidence by the linearisation alone; of very many runs an even choice counts."""
    runs, fit = on_enough_runs(runs, fit)
    along, knots = Along.of(runs, fit), shape_knots(runs)
    space = torque_space(runs, fit, knots)
    typical = BodyTorque.parameters[0].typical_on(runs.mean_moment(fit.theta))
    alike: dict[tuple[Law, ...], list[Pattern]] = {}
    for pattern in (each for of_class in every.values() for each in of_class):
        alike.setdefault(pattern.laws, []).append(pattern)
    # Patterns by their number of amplitudes, whose evidence is worked out together.
    by_size: dict[int, list[tuple[Pattern, _Valued, Array, Array, Array]]] = {}
    for valued, columns in _columns(list(_valued(along, list(alike))), along, space, knots):
        normals = {frame: normal(own) for frame, own in columns.items()}
        for pattern in alike[valued.laws]:
            axes = _directions(len(valued.values), pattern.placement)
            information, slope = normals[pattern.frame]
            sizes = np.repeat(typical / valued.power, len(pattern.axes))
            tried = (pattern, valued, sizes, axes @ information @ axes.T, axes @ slope)
            by_size.setdefault(len(sizes), []).append(tried)
    found: dict[Pattern, list[tuple[float, _Valued]]] = {}
    for some in by_size.values():
        of, at, *numbers = zip(*some, strict=True)
        for pattern, valued, each in zip(of, at, evidences(*map(np.array, numbers)).tolist(), strict=True):
            found.setdefault(pattern, []).append((each, valued))
    for pattern, starts in found.items():
        evidence = np.array([each for each, _ in starts])
        best = starts[int(evidence.argmax())][1]
        mean = 2.0 * (float(np.logaddexp.reduce(0.5 * evidence)) - log(len(evidence)))
        yield _Tested(
            pattern=pattern,
            evidence=mean + 2.0 * log(share[pattern]),
            start=best.start,
            starts=len(starts),
            power=best.power,
        )


@cache
def _directions(laws: int, placement: Placement) -> Array:
    """Return what amplitudes of some laws are along the three axes of each, shape (D, 3 * laws)."""
    return np.asarray(np.kron(np.eye(laws), axes_of(placement)))


@dataclass(frozen=True, kw_only=True, eq=False)
class _Valued:
    """Laws with values for their constants.

    Attributes:
        laws: of a formula.
        start: values of their constants, shape (constants,).
        values: at the nodes, shape (laws, R, N).
    """

    laws: tuple[Law, ...]
    start: Array
    values: Array

    @cached_property
    def power(self) -> Array:
        """Root mean square of each law in the run where it is largest, shape (laws,)."""
        mean = (self.values**2).mean(axis=-1).max(axis=-1)
        return np.asarray(np.sqrt(np.maximum(mean, np.finfo(float).tiny)))


def _valued(along: Along, every: Sequence[tuple[Law, ...]]) -> Iterator[_Valued]:
    """Yield laws at each of their start values; those with the same memory are integrated together."""
    for laws in every:
        if not laws[0].names:
            yield _Valued(laws=laws, start=np.zeros(0), values=along.products(laws, {}))
        elif laws[0].names == ("f",):
            for frequency in _frequencies(along):
                values = along.products(laws, {"f": np.asarray(frequency)})
                yield _Valued(laws=laws, start=np.array([frequency]), values=values)
        elif laws[0].names == ("at", "width"):
            for start in _pulses(along):
                values = along.products(laws, {"at": np.asarray(start[0]), "width": np.asarray(start[1])})
                yield _Valued(laws=laws, start=np.array(start), values=values)
    for memory, name in MEMORIES.items():
        own = [laws for laws in every if laws[0].memory == memory]
        products = along.products([laws[0] for laws in own], {})
        for constant in SCANNED[name]:
            kept = _remembered(memory, products, along.time, np.asarray(constant))
            yield from (
                _Valued(laws=laws, start=np.array([constant]), values=values[None])
                for laws, values in zip(own, kept, strict=True)
            )


def _columns(
    every: Sequence[_Valued], along: Along, space: TorqueSpace, knots: int
) -> Iterator[tuple[_Valued, Mapping[Frame, list[Moved]]]]:
    """Yield what unit torques by laws do to every run, laws * 3 of them, by frame; many are worked out at once."""
    for first in range(0, len(every), AT_ONCE):
        some = every[first : first + AT_ONCE]
        values = np.concatenate([each.values for each in some])
        edges = 3 * np.cumsum([0, *(len(each.values) for each in some)])
        frames: tuple[Frame, Frame] = ("B", "N")
        of_runs = {frame: space.along(along.torques(values, frame, knots)) for frame in frames}
        for each, ends in zip(some, pairwise(edges), strict=True):
            yield each, {frame: [own.rows(slice(*ends)) for own in of_runs[frame]] for frame in frames}


def _frequencies(along: Along) -> Array:
    """Return those of oscillations, as those of torque shapes with a frequency."""
    longest = float(along.time.max())
    slowest = SETTINGS.resolved_periods / longest
    return np.arange(slowest, SETTINGS.fastest_oscillation_hz, SETTINGS.frequency_resolution / longest)


def _pulses(along: Along) -> Iterator[tuple[float, float]]:
    """Yield instants and widths of pulses in single runs, the instants as far apart as a pulse is wide."""
    for width in SCANNED["width"]:
        for elapsed in along.moment.elapsed:
            yield from ((float(instant), width) for instant in np.arange(elapsed[0], elapsed[-1], width))


@dataclass(frozen=True, kw_only=True, eq=False)
class Along:
    """What formulas read along the predicted motion of all runs, at the nodes of the grid.

    Attributes:
        time: since the first sample, shape (R, N), s.
        moment: at all nodes, arrays of shape (R, N, ...).
    """

    time: Array
    moment: Moment

    @staticmethod
    def of(runs: Runs, fit: Fit) -> Along:
        """Return the motion that a model predicts."""
        grid = runs.grid
        rates = node_rates(grid, [each.hooks for each in fit.placed], fit.values)[:, 0]
        time = grid.node_time - grid.node_time[:, :1]
        attitude = np.stack([matrix_of(integrate_attitude(own, rate)) for own, rate in zip(time, rates, strict=True)])
        torque_B = applied_torque(grid)[:, 0, ::2]
        elapsed = time + laid_end_to_end(grid)[:, None]
        moment = Moment(time=time, body_rate=rates, attitude=attitude, elapsed=elapsed, applied_torque=torque_B)
        if grid.gimbals is not None:
            angle, rate = (
                np.broadcast_to(each[:, 0, ::2], (*time.shape, each.shape[-1]))
                for each in (grid.gimbals.angle, grid.gimbals.rate)
            )
            moment = replace(moment, gimbal_angle=angle, gimbal_rate=rate)
        return Along(time=time, moment=moment)

    def products(self, laws: Sequence[Law], constants: Mapping[str, Array]) -> Array:
        """Return the laws' products at the nodes, shape (laws, R, N)."""
        return np.stack([np.broadcast_to(law.product(self.moment, constants), self.time.shape) for law in laws])

    def torques(self, values: Array, frame: str, knots: int) -> Array:
        """Return unit torques by laws along three axes at the knots of every run, shape (R, knots, 3, laws * 3)."""
        at = np.linspace(0.0, self.time.shape[1] - 1, knots)
        before = np.minimum(at.astype(int), self.time.shape[1] - 2)
        share = (at - before)[:, None, None]

        def along(nodes: NDArray[np.intp]) -> Array:  # (laws, R, knots, axis, component)
            axes = np.eye(3) if frame == "B" else self.moment.attitude[:, nodes]  # of N: rows of R_AB are the axes in B
            return np.asarray(values[:, :, nodes, None, None] * axes)

        at_knots: Array = (1.0 - share) * along(before) + share * along(before + 1)
        return np.moveaxis(at_knots, (0, 3), (3, 4)).reshape(len(self.time), knots, 3, len(values) * 3)


def _remembered(memory: Memory, product: Array, time: Array, constant: Array) -> Array:
    """Return what a memory makes of products that are known at nodes, both of shape (laws, R, N)."""
    count = product.shape[-1]
    half = make_interp_spline(np.arange(count), product, k=3, axis=-1)(np.arange(count - 1) + 0.5)
    step = (time[:, 1] - time[:, 0])[None, :, None]
    state = first_state_of(memory, product[..., 0])
    values = [value_of(memory, product[..., 0], state)]
    for node in range(count - 1):
        first = rate_of(memory, product[..., node], state, constant)
        second = rate_of(memory, half[..., node], state + 0.5 * step * first, constant)
        third = rate_of(memory, half[..., node], state + 0.5 * step * second, constant)
        fourth = rate_of(memory, product[..., node + 1], state + step * third, constant)
        state = state + step / 6.0 * (first + 2.0 * second + 2.0 * third + fourth)
        values.append(value_of(memory, product[..., node + 1], state))
    return np.stack(values, axis=-1)
