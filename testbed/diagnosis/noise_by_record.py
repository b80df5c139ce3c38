"""How noisy the gyro is in every record, and whether it is as noisy in all of them.

The noise is that of the residual's fastest changes, which no motion of the platform makes.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from math import log, sqrt

import numpy as np

from testbed.arrays import Indices
from testbed.diagnosis.data import Runs
from testbed.diagnosis.fitting import fitted_initial_rates
from testbed.diagnosis.model import Fit
from testbed.diagnosis.noise_level import readings_of
from testbed.diagnosis.p_values import p_value
from testbed.diagnosis.settings import SETTINGS
from testbed.diagnosis.state import Diagnosis
from testbed.effects.fast_changes import variance_ratio
from testbed.effects.noise_effect import Readings


@dataclass(frozen=True, kw_only=True)
class NoiseByRecord:
    """The gyro's noise in every record.

    Attributes:
        ratio: its standard deviation over the stated one, by the name of the record; without records too short to tell.
        p_value: of standard deviations that differ as much, if there is but one.
    """

    ratio: dict[str, float]
    p_value: float

    @property
    def differs(self) -> bool:
        """Whether records differ by more than chance, and by enough to matter."""
        far = max(self.ratio.values(), default=1.0) > SETTINGS.noise_differs * min(self.ratio.values(), default=1.0)
        return far and self.p_value < SETTINGS.disagreement_p_value


def noise_by_record(diagnosis: Diagnosis) -> NoiseByRecord:
    """Compare the noise of all records, fitted and held out, by Bartlett's test of equal variances.

    Source: Bartlett, "Properties of sufficiency and statistical tests", Proceedings of the Royal Society A (1937).
    """
    found = dict(_variances(diagnosis))
    ratio = {name: sqrt(variance) for name, (variance, _) in found.items()}
    if len(found) < 2:
        return NoiseByRecord(ratio=ratio, p_value=1.0)
    variance, freedom = np.array(list(found.values())).T
    pooled = float(freedom @ variance / freedom.sum())
    statistic = float(freedom.sum()) * log(pooled) - float(freedom @ np.log(variance))
    correction = 1.0 + (float((1.0 / freedom).sum()) - 1.0 / float(freedom.sum())) / (3.0 * (len(found) - 1))
    return NoiseByRecord(ratio=ratio, p_value=p_value(statistic / correction, len(found) - 1, np.inf))


def _variances(diagnosis: Diagnosis) -> Iterator[tuple[str, tuple[float, float]]]:
    """Yield every record's variance over the stated one, and its degrees of freedom."""
    model, heldout = diagnosis.model, diagnosis.heldout
    yield from _of(diagnosis.runs, model)
    if heldout is not None:
        yield from _of(heldout, fitted_initial_rates(heldout, model))


def _of(runs: Runs, fit: Fit) -> Iterator[tuple[str, tuple[float, float]]]:
    readings, record_of = replace(readings_of(runs, fit), sigma=runs.as_stated().sigma), runs.record_of
    for index, name in enumerate(runs.record_names):
        found = variance_ratio(_only(readings, np.flatnonzero(record_of == index)), np.ones(3, dtype=bool))
        if min(found) > 0.0:
            yield name, found


def _only(readings: Readings, chosen: Indices) -> Readings:
    """Return the readings of some runs."""
    return replace(
        readings,
        measured=[readings.measured[run] for run in chosen],
        residual=[readings.residual[run] for run in chosen],
        runs=[readings.runs[run] for run in chosen],
        sigma=readings.sigma[chosen],
        live=np.broadcast_to(readings.live, readings.sigma.shape)[chosen],
    )
