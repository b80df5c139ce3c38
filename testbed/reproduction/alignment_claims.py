"""What the estimates of the actuators' alignments are held to."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from testbed.reproduction.alignments import Alignments
from testbed.reproduction.claims import Claim

LEAST_GAIN = 2.0
"""Median of the scatter without null motion over the scatter with it."""


def alignment_claims(found: Alignments) -> Iterator[Claim]:
    """Return what coverage and scatter with null motion are held to."""
    low, high = found.coverage_range
    coverage = found.null_motion.coverage
    yield Claim(
        subject="Alignments, coverage",
        what=f"95 % intervals that hold the truth, {len(found.names)} parameters, {found.runs} platforms",
        target=f"{low:.0%} to {high:.0%} each: what honest intervals keep to",
        measured=f"{coverage.min():.0%} to {coverage.max():.0%}, mean {coverage.mean():.1%}",
        met=bool(coverage.min() >= low and coverage.max() <= high),
        test="could fail",
    )
    yield Claim(
        subject="Alignments, scatter",
        what="scatter with pseudo-inverse steering over scatter with null motion, median",
        target=f"at least {LEAST_GAIN:.0f}",
        measured=f"{found.median_ratio:.1f} ({np.min(found.scatter_ratio):.1f} to {np.max(found.scatter_ratio):.1f})",
        met=found.median_ratio >= LEAST_GAIN,
        test="could fail; body rates, platforms and noise are the same for both",
    )
