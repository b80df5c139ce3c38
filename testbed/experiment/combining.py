"""The estimates of several runs as one, and whether they may be taken together at all."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from scipy.linalg import block_diag

from testbed.arrays import Covariance
from testbed.estimation.agreement import runs_agreement
from testbed.estimation.combine import CombinedEstimate, combined
from testbed.experiment.checking import Compared, agreement_of, with_spread
from testbed.experiment.experiment import CombinedEstimation, Estimation


def combine_estimations(estimations: Mapping[str, Estimation]) -> CombinedEstimation:
    """Average each estimator over the runs in which it gave an estimate, eq. (33).

    Where runs differ by more than chance, their spread is in the covariance of the average (Birge's ratio); so is the
    difference of two estimators that should agree and do not.

    Args:
        estimations: by run.
    """
    names = {name: None for estimation in estimations.values() for name in estimation.by_name}
    each = {name: [run.by_name[name] for run in estimations.values() if name in run.by_name] for name in names}
    agreement = {name: runs_agreement(runs) for name, runs in each.items() if len(runs) > 1}
    by_name = {name: combined(runs) for name, runs in each.items()}
    compared = _compared(estimations)
    wider = {
        name: _spread(average, agreement[name].excess) if name in agreement else average
        for name, average in by_name.items()
    }
    return CombinedEstimation(
        by_name=with_spread(wider, compared),
        runs=len(estimations),
        runs_agreement=agreement,
        compared=compared,
        pivot=next(iter(estimations.values())).pivot,
    )


def _spread(average: CombinedEstimate, excess: float) -> CombinedEstimate:
    return replace(average, spread=excess * average.covariance, offset_spread=excess * average.offset_covariance)


def _compared(estimations: Mapping[str, Estimation]) -> Compared | None:
    """Compare the averages of the two estimators that were compared in the most runs, over just these runs."""
    pairs = [pair for pair in map(_pair_of, estimations.values()) if pair is not None]
    if not pairs:
        return None
    pair = max(dict.fromkeys(pairs), key=pairs.count)
    runs = [run for run in estimations.values() if _pair_of(run) == pair]
    averages = tuple(combined([run.by_name[name] for run in runs]) for name in pair)
    size = sum(len(average.joint) for average in averages)
    covariance = sum((_covariance(run, pair, averages) for run in runs), start=np.zeros((size, size)))
    return Compared(
        efficient=pair[0],
        robust=pair[1],
        covariance=covariance,
        agreement=agreement_of(averages[0], averages[1], covariance),
    )


def _pair_of(run: Estimation) -> tuple[str, str] | None:
    compared = None if run.checks is None else run.checks.compared
    return None if compared is None else (compared.efficient, compared.robust)


def _covariance(run: Estimation, pair: tuple[str, str], averages: Sequence[CombinedEstimate]) -> Covariance:
    """Return what a run puts on the covariance of both averages together, shape (12, 12) or (18, 18)."""
    assert run.checks is not None
    assert run.checks.compared is not None
    gains = [
        average.joint_covariance @ np.linalg.inv(run.by_name[name].joint_covariance)
        for name, average in zip(pair, averages, strict=True)
    ]
    gain = block_diag(*gains)
    return np.asarray(gain @ run.checks.compared.covariance @ gain.T)
