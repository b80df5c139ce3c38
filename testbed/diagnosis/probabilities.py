"""How probable each explanation is, from the Bayesian information criterion."""

from __future__ import annotations

from collections.abc import Mapping
from math import exp, inf

from testbed.diagnosis.screening import Screening

NONE, UNKNOWN = "none", "unknown"
BETWEEN = "|"
"""Stands between the members of a class that the data do not tell apart."""


def probabilities_of(screening: Screening | None, unlisted: float = -inf) -> Mapping[str, float]:
    """Return how probable it is that nothing is missing, of every refitted hypothesis, and of a torque of no effect.

    Proportional to exp(-BIC/2); every hypothesis that was tested is as likely beforehand as any other, all of them
    together as likely as that nothing is missing.

    Args:
        screening: of the hypotheses against a model.
        unlisted: evidence of a torque that no effect makes, against the same model.
    """
    if screening is None:
        return {}
    criterion = {candidate.placed.key: screening.criterion(candidate) for candidate in screening.candidates}
    criterion |= {NONE: 0.0, UNKNOWN: -unlisted}
    least = min(criterion.values())
    weight = {key: exp(-0.5 * (value - least)) for key, value in criterion.items()}
    total = sum(weight.values())
    return {key: value / total for key, value in weight.items()}


def by_class(probabilities: Mapping[str, float], screening: Screening | None) -> Mapping[str, float]:
    """Return probabilities with those of the chosen effect, and of what is not told from it, as one class."""
    if screening is None or screening.chosen is None:
        return probabilities
    members = [candidate.placed.key for candidate in screening.close]
    others = {key: value for key, value in probabilities.items() if key not in members}
    return {BETWEEN.join(members): sum(probabilities[key] for key in members)} | others
