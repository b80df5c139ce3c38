"""The gyro's outliers in the residual of a model: single samples that stand apart, which no fit is to see."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from testbed.arrays import Flags
from testbed.diagnosis.data import Runs
from testbed.diagnosis.model import Fit
from testbed.diagnosis.noise_level import readings_of
from testbed.diagnosis.settings import SETTINGS
from testbed.effects.gyro_saturation import flat_tops
from testbed.estimation.outliers import AT_ENDS, outliers
from testbed.estimation.telemetry import Telemetry


def without_spikes(runs: Runs, fit: Fit) -> tuple[tuple[Telemetry, ...], tuple[int, ...]]:
    """Return the runs' telemetry less the gyro's outliers, and their number by run.

    A clipped peak of few samples would count as outliers to a model without the limit; it stays.

    Args:
        runs: measured.
        fit: of any model to them; its residual is tested.
    """
    residuals = readings_of(runs, fit).residual
    clipped = flat_tops(runs.grid.runs)
    outlying = [
        np.any(outliers(residual, sigma) & ~at_limit, axis=1)
        for residual, sigma, at_limit in zip(residuals, runs.sigma, clipped, strict=True)
    ]
    outlying = _without_common_ends(outlying)
    if np.concatenate(outlying).mean() > SETTINGS.most_outliers:
        outlying = [np.zeros_like(each) for each in outlying]
    cleaned = tuple(run.with_gyro_rows(~gone) for run, gone in zip(runs.grid.runs, outlying, strict=True))
    return cleaned, tuple(int(gone.sum()) for gone in outlying)


def _without_common_ends(outlying: Sequence[Flags]) -> list[Flags]:
    """Return which samples are outliers, without those at the start of several runs, or at the end, if many have any.

    A spike comes at any time. What a model lacks, such as the low-pass of a gyro, shows in all runs as they start from
    rest, and a first sample has no neighbours before it that could tell the two apart.
    """
    kept = [each.copy() for each in outlying]
    for end in (slice(None, AT_ENDS), slice(-AT_ENDS, None)):
        at_end = [bool(each[end].any()) for each in kept]
        if sum(at_end) > 1 and np.mean(at_end) > SETTINGS.most_outliers:
            for each in kept:
                each[end] = False
    return kept
