"""How probable each explanation is, from its evidence."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from math import exp, inf, log
from types import MappingProxyType

from testbed.diagnosis.candidates import MOST_REFITS, Screening
from testbed.diagnosis.chance import NOTHING

NONE, UNKNOWN = "none", "unknown"
BETWEEN = "|"
"""Stands between the members of a class that the data do not tell apart."""


def probabilities_of(
    screening: Screening | None, unlisted: float = -inf, others: Mapping[str, float] = MappingProxyType({})
) -> Mapping[str, float]:
    """Return how probable it is that nothing is missing, of hypotheses with the most evidence, and of something else.

    Args:
        screening: of the hypotheses against a model.
        unlisted: evidence of a torque that no effect makes, against the same model.
        others: evidence of further hypotheses against the same model, by name.
    """
    if screening is None:
        return {}
    evidence = {candidate.key: candidate.evidence for candidate in screening.candidates} | dict(others)
    most = sorted(evidence, key=lambda key: -evidence[key])[:MOST_REFITS]
    odds = {key: evidence[key] - 2.0 * log(screening.tested) for key in most}
    return normalized(odds, unlisted, 1.0 - len(most) / (screening.tested + len(others)))


def normalized(odds: Mapping[str, float], unlisted: float = -inf, unseen: float = 0.0) -> Mapping[str, float]:
    """Return how probable hypotheses are, that nothing is missing, and that something else is.

    Proportional to exp(odds/2). Every hypothesis is as likely beforehand as any other, and all together a fifth as
    likely as nothing (so the probabilities of simulated sets come out right). What was not worth a closer look may be
    there and too small to be seen; it counts to what is unknown, as a torque does that no effect makes.

    Args:
        odds: twice the logarithm of how much likelier each is than nothing, by name.
        unlisted: evidence of a torque that no effect makes.
        unseen: share of the hypotheses of which nothing is known.
    """
    most = max(0.0, unlisted, *odds.values())
    weight = {key: exp(0.5 * (value - most)) for key, value in odds.items()}
    weight |= {NONE: NOTHING * exp(-0.5 * most), UNKNOWN: exp(0.5 * (unlisted - most)) + unseen * exp(-0.5 * most)}
    total = sum(weight.values())
    return {key: value / total for key, value in weight.items()}


def by_class(probabilities: Mapping[str, float], members: Collection[str]) -> Mapping[str, float]:
    """Return probabilities with those of the effect that was found, and of what is not told from it, as one class."""
    others = {key: value for key, value in probabilities.items() if key not in members}
    return {BETWEEN.join(members): sum(probabilities.get(key, 0.0) for key in members)} | others
