"""Rows of a score card: shares with Clopper-Pearson intervals, quantiles and means with theirs."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
import scipy

CONFIDENCE = 0.95


@dataclass(frozen=True, kw_only=True)
class Row:
    """One figure.

    Attributes:
        part: of the score card.
        what: is counted or measured.
        value: share, quantile or mean; None where there is nothing to take it of.
        low: end of its 95 % interval; None where there are too few cases for one.
        high: the other end.
        of: cases, or numbers, that it is taken of.
        hits: those that count; None unless it is a share.
        upper_limit: one-sided 95 % limit of a share.
        wanted: what it is held against, in words.
        limit_wanted: what its one-sided limit is held against; empty where it is not.
    """

    part: str
    what: str
    value: float | None
    low: float | None
    high: float | None
    of: int
    hits: int | None = None
    upper_limit: float | None = None
    wanted: str = ""
    limit_wanted: str = ""


def share(part: str, what: str, outcomes: Iterable[bool], wanted: str = "", limit_wanted: str = "") -> Row:
    """Return how many outcomes are true, with the exact binomial interval."""
    every = list(outcomes)
    hits, of = sum(every), len(every)
    if not of:
        return Row(part=part, what=what, value=None, low=None, high=None, of=0, hits=0, wanted=wanted)
    ends = scipy.stats.binomtest(hits, of).proportion_ci(CONFIDENCE, method="exact")
    limit = scipy.stats.binomtest(hits, of, alternative="less").proportion_ci(CONFIDENCE, method="exact").high
    return Row(
        part=part,
        what=what,
        value=hits / of,
        low=float(ends.low),
        high=float(ends.high),
        of=of,
        hits=hits,
        upper_limit=float(limit),
        wanted=wanted,
        limit_wanted=limit_wanted,
    )


def quantile(part: str, what: str, values: Iterable[float], at: float, wanted: str = "") -> Row:
    """Return a quantile, with the interval that its order statistics give."""
    every = np.array([*values])
    if not len(every):
        return Row(part=part, what=what, value=None, low=None, high=None, of=0, wanted=wanted)
    value = float(np.quantile(every, at))
    ends = scipy.stats.quantile_test(every, q=value, p=at).confidence_interval(CONFIDENCE)
    return Row(
        part=part, what=what, value=value, low=_finite(ends.low), high=_finite(ends.high), of=len(every), wanted=wanted
    )


def mean(part: str, what: str, values: Iterable[float], wanted: str = "") -> Row:
    """Return a mean, with a bootstrap interval."""
    every = np.array([*values], dtype=float)
    if not len(every):
        return Row(part=part, what=what, value=None, low=None, high=None, of=0, wanted=wanted)
    low, high = None, None
    if np.ptp(every) > 0.0:
        ends = scipy.stats.bootstrap(
            (every,), np.mean, confidence_level=CONFIDENCE, method="percentile", rng=0
        ).confidence_interval
        low, high = float(ends.low), float(ends.high)
    return Row(part=part, what=what, value=float(every.mean()), low=low, high=high, of=len(every), wanted=wanted)


def _finite(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None
