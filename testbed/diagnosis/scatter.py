"""Effects on how the gyro's samples scatter: tested on what a model leaves, and taken into the believed noise."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from math import log

import numpy as np

from testbed.arrays import Array
from testbed.diagnosis.data import Runs
from testbed.diagnosis.model import Fit
from testbed.diagnosis.noise import readings_of
from testbed.diagnosis.signatures import FAMILY_WISE_ERROR
from testbed.effects.contract import Finding, ReadingEffect, Readings


@dataclass(frozen=True, kw_only=True, eq=False)
class Scatter:
    """An effect on the scatter of the gyro's samples that is there by more than chance.

    Attributes:
        effect: which.
        component: where.
        finding: its parameters, and how sure it is.
        bic: of the model with it less that of the one without; negative is better.
        p_value: of what was seen without it, times the number of hypotheses that were tested (Bonferroni).
    """

    effect: ReadingEffect
    component: str
    finding: Finding
    bic: float
    p_value: float

    @property
    def key(self) -> str:
        """Unique name, e.g. `gyro_noise:x`."""
        return f"{self.effect.id}:{self.component}"


def scatter_found(
    runs: Runs, fit: Fit, effects: Mapping[str, ReadingEffect], others: int, *, white: bool = False
) -> tuple[Scatter, ...]:
    """Return the effects on the scatter that are there, the clearest first, each told with those before it taken in.

    Args:
        runs: with the noise that is stated.
        fit: of the present model to them.
        effects: by id.
        others: number of further hypotheses by which the family-wise error is divided.
        white: whether the fit is known to leave nothing but noise.
    """
    found: list[Scatter] = []
    hypotheses = [(effect, component) for effect in effects.values() for component in effect.components]
    tested = others + len(hypotheses)
    readings = replace(readings_of(runs, fit), white=white)
    while hypotheses:
        believed = _without_what_is_told(readings, found)
        told = [
            _scatter(effect, component, effect.found(component, believed), runs.samples, tested)
            for effect, component in hypotheses
        ]
        present = [each for each in told if each is not None and each.p_value < FAMILY_WISE_ERROR and each.bic < 0.0]
        if not present:
            break
        found.append(min(present, key=lambda each: each.bic))
        taken = {each.key for each in found}
        hypotheses = [each for each in hypotheses if f"{each[0].id}:{each[1]}" not in taken]
    return tuple(found)


def widened(sigma: Array, found: Iterable[Scatter]) -> Array:
    """Return standard deviations with what was found, shape (R, 3), rad/s."""
    return np.asarray(np.sqrt(sigma**2 + sum((each.finding.variance for each in found), np.zeros(3))))


def _without_what_is_told(readings: Readings, found: Sequence[Scatter]) -> Readings:
    """Return readings less what was told sample by sample, and with a noise that has the rest of what was found."""
    residual = readings.residual
    for each in found:
        if each.finding.explained is not None:
            residual = [left - told for left, told in zip(residual, each.finding.explained, strict=True)]
    noisier = [each for each in found if each.finding.explained is None]
    return replace(readings, residual=residual, sigma=widened(readings.sigma, noisier))


def _scatter(
    effect: ReadingEffect, component: str, finding: Finding | None, samples: int, tested: int
) -> Scatter | None:
    if finding is None:
        return None
    return Scatter(
        effect=effect,
        component=component,
        finding=finding,
        bic=len(effect.parameters) * log(samples) - finding.gain,
        p_value=min(1.0, tested * finding.p_value),
    )
