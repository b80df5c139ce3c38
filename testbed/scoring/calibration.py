"""Calibration: whether diagnoses with a stated probability p are right in a share p of the cases."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy

from testbed.arrays import Array, Indices
from testbed.scoring.case import Case
from testbed.scoring.judging import said, said_right
from testbed.scoring.rows import CONFIDENCE, Row

_BINS = 10


@dataclass(frozen=True, kw_only=True)
class Bin:
    """Cases in which the first thing said had a probability between two edges.

    Attributes:
        low: edge.
        high: edge.
        of: cases.
        probability: their mean.
        right: share of them in which it was right.
    """

    low: float
    high: float
    of: int
    probability: float
    right: float


def bins(cases: Sequence[Case]) -> tuple[Bin, ...]:
    """Return the reliability diagram: ten bins of equal width, those that are empty left out."""
    probability, right = _stated(cases)
    index = _bin_of(probability)
    return tuple(
        Bin(
            low=number / _BINS,
            high=(number + 1) / _BINS,
            of=int(np.sum(index == number)),
            probability=float(probability[index == number].mean()),
            right=float(right[index == number].mean()),
        )
        for number in np.unique(index).tolist()
    )


def calibration_error(part: str, what: str, cases: Sequence[Case], wanted: str) -> Row:
    """Return the expected calibration error: mean over all cases of their bin's |share right - mean probability|."""
    probability, right = _stated(cases)
    row = Row(part=part, what=what, value=None, low=None, high=None, of=len(probability), wanted=wanted)
    if len(probability) < 2:  # nothing to resample
        return row
    drawn = scipy.stats.bootstrap(
        (probability, right), _error, paired=True, vectorized=False, n_resamples=999, method="percentile",
        confidence_level=CONFIDENCE, rng=0,
    )  # fmt: skip
    ends = drawn.confidence_interval
    return Row(
        part=part,
        what=what,
        value=_error(probability, right),
        low=float(ends.low),
        high=float(ends.high),
        of=len(probability),
        wanted=wanted,
    )


def _stated(cases: Sequence[Case]) -> tuple[Array, Array]:
    """Return the probability of what was said first, and whether it was right, each of shape (cases that have one,)."""
    stated = [(probability, said_right(case)) for case in cases if (probability := said(case)[1]) is not None]
    return np.array([each[0] for each in stated], dtype=float), np.array([each[1] for each in stated], dtype=float)


def _error(probability: Array, right: Array) -> float:
    index = _bin_of(probability)
    off = np.bincount(index, weights=right - probability, minlength=_BINS)
    return float(np.abs(off).sum() / len(probability))


def _bin_of(probability: Array) -> Indices:
    return np.asarray(np.minimum((probability * _BINS).astype(int), _BINS - 1))
