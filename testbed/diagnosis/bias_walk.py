"""A gyro's bias that walks at random, compared with effects that it may pass for."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from math import inf, log
from typing import Protocol

from testbed.diagnosis.noise import NoiseHypothesis
from testbed.diagnosis.search import Search, log_odds_of_all, odds_of_unmodelled, with_model
from testbed.diagnosis.settings import SETTINGS
from testbed.diagnosis.state import Diagnosis
from testbed.effects.formula import Formula


class _Explaining(Protocol):
    def __call__(self, state: Diagnosis, *, white: bool) -> Diagnosis: ...


def with_bias_walk(
    state: Diagnosis,
    search: Search,
    noise: _Explaining,
    residual: Callable[[Diagnosis], Diagnosis],
    unnamed: Diagnosis | None = None,
) -> Diagnosis:
    """Return the diagnosis with a bias that walks in the place of effects that are less probable than it.

    A walk passes for whatever is slow; of the nominal model it has to leave nothing but noise. Effects that leave more
    than noise, or are less probable than something unknown, are as improbable besides as such a residual, and a formula
    has to be distinguished from it. Where it explains nearly as much, the diagnosis says so.

    Args:
        state: with its residual tested.
        search: among the hypotheses of the library.
        noise: explains the noise anew with a model.
        residual: tests the residual of a model.
        unnamed: the diagnosis without formulas, if some are in it: it stands where a walk that is no clear name is not
            distinguished from these.

    Returns:
        The same diagnosis where no walk explains as much.
    """
    if not state.steps or state.runs.known_in_part:
        return state
    bare = replace(with_model(state, state.baseline), steps=(), differing=None, latent_before=None, explained=0.0)
    walking = noise(bare, white=True)
    walk, is_named = _walk_of(walking)
    ahead = -inf if walk is None else walk.odds + _doubt(state) - state.explained
    if walk is None or ahead + SETTINGS.indistinguishable <= 0.0:
        return state
    if not is_named:
        return unnamed if unnamed is not None and ahead > 0.0 else state
    screening = search.compared(walking)
    walking = residual(replace(walking, remaining=screening))
    if walking.left_over:
        return state
    if ahead <= 0.0:
        return replace(state, notices=tuple(dict.fromkeys((*state.notices, _words(walk)))))
    return replace(
        walking,
        unmodelled=odds_of_unmodelled(walking, screening),
        retracted=(*state.retracted, *(step.placed for step in state.steps)),
    )


def standing_beside_walk(
    standing: Diagnosis, search: Search, noise: _Explaining, residual: Callable[[Diagnosis], Diagnosis]
) -> Diagnosis | None:
    """Return the diagnosis with the effects that stand beside a gyro's bias that walks, and leave nothing but noise.

    None where no walk was found, or where more is left: without the walk in the noise, those that it passes for would
    be missed.

    Args:
        standing: with the effects that stand out of the noise of all so far.
        search: among the hypotheses of the library.
        noise: explains the noise anew with a model.
        residual: tests the residual of a model.
    """
    if not standing.walks:
        return None
    before = set[tuple[str, ...]]()
    while True:
        state = residual(noise(standing, white=True))
        if state.left_over or not state.steps:
            return None
        before.add(state.step_keys)
        standing = search.standing(state)
        if standing is state or standing.step_keys in before:
            break
    explained, screening = log_odds_of_all(state, with_model(state, state.baseline)), state.steps[0].screening
    return replace(state, explained=explained, unmodelled=explained + odds_of_unmodelled(state, screening))


def _walk_of(state: Diagnosis) -> tuple[NoiseHypothesis | None, bool]:
    """Return the hypothesis of a walk, None where it was not tested, and whether it has a name."""
    named = next((each for each in state.scatter if each.walks), None)
    if named is not None:
        return named, True
    return next((each for each in state.noise_candidates if each.walks), None), False


def _doubt(state: Diagnosis) -> float:
    """Return by how much effects have to be more probable than a walk, twice the logarithm."""
    doubted = state.left_over or state.unmodelled_is_more_probable
    of_residual = -2.0 * log(SETTINGS.unexplained_p_value) if doubted else 0.0
    formula = any(isinstance(each.effect, Formula) for each in state.steps)
    return of_residual + (SETTINGS.indistinguishable if formula else 0.0)


def _words(walk: NoiseHypothesis) -> str:
    size, error = walk.size
    return (
        f"a gyro's bias that walks at random, by {size:.2g} ± {error:.1g} rad/s/√s, explains these records nearly as "
        "well as what is named"
    )
