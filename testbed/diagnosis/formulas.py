"""Formulas where no effect of the library explains a residual: screened, refitted, compared like effects.

Those with the most evidence in the linearisation, their share of the prior included, are refitted in the nonlinear
prediction, as hypotheses of the library are.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from math import log

import numpy as np

from testbed.diagnosis.candidates import Candidate, Screening, accepted
from testbed.diagnosis.data import Runs
from testbed.diagnosis.formula_responses import FormulaEvidence, formula_evidences
from testbed.diagnosis.model import Fit, Hypothesis
from testbed.diagnosis.own_sizes import with_own_sizes
from testbed.diagnosis.screening import refitted, screened
from testbed.diagnosis.search import Search, log_odds_of_all, odds_of_unmodelled, odds_together, with_effect, with_model
from testbed.diagnosis.settings import SETTINGS
from testbed.diagnosis.signatures import signatures
from testbed.diagnosis.state import Diagnosis
from testbed.diagnosis.torque_shapes import TorqueShape, evidence_of_any
from testbed.effects.contact import Contact
from testbed.effects.formula import Formula
from testbed.formulas.grammar import Class, patterns, shares
from testbed.formulas.law import Law
from testbed.formulas.pattern import Pattern, contains
from testbed.prediction.grid import unit_count

_NO_FORMULA = ("pulses", "oscillation of every run's own")
"""Kinds of torque shapes that no formula has: what comes at instants, or in every run at another phase."""
_FAR = 30.0
"""Of evidence, by which a formula may be behind the best one and still be refitted: five times what is
indistinguishable. A sine between two of the frequencies that are tried loses 5 % of its χ², 13 at 16 sigma."""


def may_follow_formulas(state: Diagnosis) -> bool:
    """Return whether formulas may explain what the effects in the model leave, or what they explain.

    Not over windows of torque that is known in part, where the residual is the loop's, nor beside healthy records that
    show the loop.
    """
    belief = state.runs.belief
    asked = state.left_over or bool(state.steps)
    return asked and not state.runs.known_in_part and (belief is None or not belief.of_loop)


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
    bare = with_model(replace(state, steps=(), explained=0.0, differing=None), state.baseline) if state.steps else state
    if state.unnamed and state.steps:  # beside another that stands out they have not been compared with anything
        state = replace(state, explained=_explained(state, bare))
    state, outdone = (state, False) if state.left_over else _with_rivals(state, bare, search)
    begun = state
    for _ in range(SETTINGS.most_effects):
        wanted = state.left_over or (outdone and state is begun)
        chosen = _best_addition(state, bare if state is begun else None, search) if wanted else None
        if chosen is None:
            break
        before, candidate, screening = chosen
        others = (each for each in search.testable if each.key != candidate.placed.key)
        search = replace(search, testable=(*others, candidate.placed), known={})
        larger = search.reconsidered(with_effect(before, candidate, screening))
        if larger.gap.fit > before.gap.fit:  # what fits worse is no explanation
            break
        grown = noise(larger)
        beside = search.screened(grown)
        grown, further = with_own_sizes(grown, beside)
        while further is not None and search.has_room(grown):
            grown = noise(search.reconsidered(with_effect(grown, further, beside)))
            beside = search.screened(grown)
            grown, further = with_own_sizes(grown, beside)
        state = residual(replace(grown, remaining=beside))
        explained = _explained(state, bare) if state.steps else 0.0
        left = odds_of_unmodelled(state, beside)
        state = replace(state, explained=explained, unmodelled=explained + left)
    known = begun.unnamed or begun.differing or not begun.left_over
    if known and state.explained < begun.explained + begun.differing_odds + SETTINGS.indistinguishable:
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
    tested = formula_evidences(bare.runs, bare.model, every, shares(every))
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
    beside = search.has_room(state) and state.left_over and (state.differing is None or not state.steps)
    bases = [(replace(state, differing=None), state.remaining)] if beside else []
    if bare is not None and state.steps:
        bases.append((bare, search.screened(bare)))  # in the noise in which formulas are compared with it
    found = []
    for base, listed in bases:
        least = state.explained + state.differing_odds - base.explained - _FAR if state.differing else -np.inf
        formulas = screened_formulas(base.runs, base.heldout, base.model, len(search.testable), search.progress, least)
        touch = _touch_of_pulse(base, formulas, search)
        screening = _beside_library(formulas, listed, library, touch)
        chosen = accepted(screening)
        if chosen is not None and (isinstance(chosen.effect, Formula) or chosen in touch.candidates):
            found.append((base, chosen, screening))
    return max(found, key=lambda each: each[0].explained + each[2].odds(each[1]), default=None)


def _touch_of_pulse(base: Diagnosis, formulas: Screening, search: Search) -> Screening:
    """Return a touch at the instant of the best formula, if that is a pulse: in a long record no jump shows it.

    The jumps that a touch is searched from are those of the momentum along the gyro's own integral, which wanders by as
    much as a small impulse within a minute; formulas are compared along the motion that the model predicts.

    Returns:
        A screening of the touch alone; without one of no pulse.
    """
    none = replace(formulas, signatures=(), candidates=(), tested=max(len(search.testable), 1))
    best = next(iter(formulas.candidates), None)
    known = next((each for each in search.testable if isinstance(each.effect, Contact)), None)
    if best is None or best.effect.recurs or known is None:
        return none
    instant = best.fit.effect_values[best.fit.own(best.placed)][_pattern(best).names.index("at")]
    touch = replace(known, effect=Contact((float(instant),)))
    shown = replace(none, signatures=tuple(signatures(base.runs, base.model, [touch])))
    candidate = refitted(base.runs, base.heldout, base.model, shown, touch)
    return none if candidate is None else replace(shown, candidates=(candidate,))


def _beside_library(
    formulas: Screening, listed: Screening | None, library: Screening | None, touch: Screening
) -> Screening:
    """Return formulas and the library's hypotheses together, which compete.

    Args:
        formulas: against a model.
        listed: hypotheses of the library against the same model; None where there are none.
        library: against the baseline: what the data show of each stays known.
        touch: at the instant of a pulse; it takes the place of the library's one if it explains more.
    """
    candidates = {each.placed.key: each for each in (() if listed is None else listed.candidates)}
    known = {each.placed.key: each for each in (() if library is None else library.signatures)}
    for each, signature in zip(touch.candidates, touch.signatures, strict=True):
        key, rival = each.placed.key, candidates.get(each.placed.key)
        if rival is None or each.log_bayes_factor > rival.log_bayes_factor:
            candidates[key], known[key] = each, signature
    others = [each for each in candidates.values() if not isinstance(each.effect, Formula)]
    both = sorted([*formulas.candidates, *others], key=lambda each: -each.log_bayes_factor)
    shown = [each for each in known.values() if not isinstance(each.placed.effect, Formula)]
    return replace(formulas, candidates=tuple(both), signatures=(*formulas.signatures, *shown))


def screened_formulas(
    runs: Runs,
    heldout: Runs | None,
    fit: Fit,
    library: int,
    progress: Callable[[str], None] = lambda _: None,
    least: float = -np.inf,
) -> Screening:
    """Test every formula of the grammar, and refit those with the most evidence.

    Args:
        runs: that the model was fitted to.
        heldout: to verify on; None where there are none.
        fit: the present model.
        library: number of hypotheses of the library, of which each has the prior of a class of formulas.
        progress: called with what is being refitted.
        least: evidence below which none is refitted.

    Returns:
        A screening like that of effects; evidence has the formula's share of the prior in it, p-values count all
        formulas. A formula that contains a better one, by a direction or a memory more, is no alternative to it.
    """
    progress("formulas")
    taken = {each.key for each in fit.placed}
    every = _grammar(runs)
    share = shares(every)
    tested = list(formula_evidences(runs, fit, every, share))
    best = sorted(_not_outdone(tested), key=lambda each: -each.evidence)
    moment = runs.mean_moment(fit.theta)
    effects = [
        Formula(each.pattern, typical_value=each.power, moment=moment, start=each.start, scan_count=each.starts)
        for each in best[: SETTINGS.most_refits]
        if each.evidence > max(best[0].evidence - _FAR, least)
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


def _not_outdone(tested: Sequence[FormulaEvidence]) -> Iterator[FormulaEvidence]:
    """Yield formulas, those with a memory where the data say more for them than for the same without."""
    evidence = {each.pattern: each.evidence for each in tested}
    for each in tested:
        bare = replace(each.pattern, laws=tuple(Law.of(*law.factors) for law in each.pattern.laws))
        if bare == each.pattern or each.evidence > evidence.get(bare, -np.inf):
            yield each
