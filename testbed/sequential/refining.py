"""A chosen flight's path made better: the leading effect as far as the limits let it be from its strongest rival."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from testbed.diagnosis.candidates import NONE
from testbed.diagnosis.model import Fit, Hypothesis, evaluated
from testbed.errors import InputError
from testbed.next_experiment.competing_hypotheses import CompetingHypothesis, HypothesisPairs, Pair
from testbed.next_experiment.criterion import Choice, DiscriminationCriterion, criterion_of
from testbed.next_experiment.flight import NextFlight
from testbed.next_experiment.refinement import refined
from testbed.sequential.evidence import Evidence
from testbed.sequential.expected_gain import EffectGoal
from testbed.sequential.robust import RobustSpace

_FAR = 1e6
"""σ: a distance that no flight reaches, so that the path is made better as long as that goes."""
_TIMES = 3
"""Refinements of a path at most, each of at most four linear programs; the second one starts with a new trust region.
From 12.4 σ² that a chosen flight adds for the encoder zero of cmg4 in zero_g.toml the first leads to 17.9."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Refinement:
    """How flights are made better.

    Attributes:
        criterion: distance of the leading effect from its strongest rival.
        progress: called with what is being done.
    """

    criterion: DiscriminationCriterion
    progress: Callable[[str], None]

    def __call__(self, flight: NextFlight) -> NextFlight:
        """Return a flight of the same release that is at least as good, within the limits."""
        distances = self.criterion.distances([flight])[0]
        choice = Choice(flight=flight, distances=distances, separable=np.ones(len(distances), dtype=bool))
        for _ in range(_TIMES):
            before, choice = choice, refined(self.criterion, choice, self.progress)
            if choice is before:
                break
        return choice.flight


def refinement_of(
    evidence: Evidence, goal: EffectGoal, space: RobustSpace, progress: Callable[[str], None]
) -> Refinement | None:
    """Return how flights are made better for the leading effect; None where there is none, or its motion runs away.

    Args:
        evidence: of the flights so far.
        goal: of the next one, with the hypotheses in question.
        space: platform and limits.
        progress: called with what is being done.
    """
    if goal.leading is None:
        return None
    leading, rival = goal.leading
    try:
        truth = CompetingHypothesis(key=leading.key, fits=(_fitted(evidence, leading),))
        other = evidence.fit if rival is None else _fitted(evidence, rival)
    except InputError:
        return None
    imitator = CompetingHypothesis(key=NONE if rival is None else rival.key, fits=(other,))
    pairs = HypothesisPairs(models=(truth, imitator), pairs=(Pair(truth=0, imitator=1, wanted=_FAR),))
    return Refinement(criterion=criterion_of(pairs, evidence.runs, space), progress=progress)


def _fitted(evidence: Evidence, placed: Hypothesis) -> Fit:
    """Return the model with an effect of the size that explains the most, linearised, inside its bounds."""
    signature = evidence.signatures[placed.key]
    size = np.clip(signature.start + signature.step, *placed.bounds)
    values = replace(evidence.fit.values, effects=(size[None],))
    return evaluated(evidence.runs, (placed,), values)
