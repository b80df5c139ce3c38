"""What the diagnosis compared first, kept beside diagnosis.json for the methods that it is held against.

Nothing here knows of answers, and no user's output holds it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import log
from typing import Any

from testbed.diagnosis.candidates import Screening
from testbed.diagnosis.data import Runs
from testbed.diagnosis.model import Fit
from testbed.diagnosis.noise_level import readings_of
from testbed.effects.contract import components_in
from testbed.effects.noise_effect import NoiseEffect
from testbed.prediction.grid import unit_count, wheel_count

CANDIDATES = "candidates.json"


def candidates_of(
    runs: Runs, baseline: Fit, screening: Screening | None, noise_effects: Mapping[str, NoiseEffect]
) -> dict[str, Any]:
    """Return every hypothesis with the χ² that it takes off the baseline, and the parameters that it needs.

    The gain is that of the refit where there was one, else the linearised one, which a refit hardly exceeds.

    Args:
        runs: with the noise that is stated.
        baseline: the nominal model fitted to them.
        screening: of the hypotheses against it; None where there were none.
        noise_effects: those on the scatter of the gyro's samples, by id.
    """
    hypotheses = [*_scatter(runs, baseline, noise_effects), *([] if screening is None else _predicted(screening))]
    tested = len(hypotheses)
    return {"samples": runs.samples, "tested": tested, "hypotheses": [each for each in hypotheses if each["rank"]]}


def _predicted(screening: Screening) -> Iterator[dict[str, Any]]:
    refitted = {candidate.placed.key: candidate.chi_square_reduction for candidate in screening.candidates}
    for signature in screening.signatures:
        placed = signature.placed
        yield {
            "effect": placed.effect.id,
            "component": placed.component,
            "rank": signature.rank,
            "gain": refitted.get(placed.key, signature.score),
            "refitted": placed.key in refitted,
        }


def _scatter(runs: Runs, baseline: Fit, effects: Mapping[str, NoiseEffect]) -> Iterator[dict[str, Any]]:
    """Yield the effects on the scatter; numbers of one run each are paid for, lest they win by how many they are."""
    readings = readings_of(runs, baseline)
    for effect in effects.values():
        for component in components_in(effect, unit_count(runs.grid), wheel_count(runs.grid)):
            finding = effect.found(component, readings)
            yield {
                "effect": effect.id,
                "component": component,
                "rank": len(effect.parameters),
                "gain": 0.0
                if finding is None
                else finding.chi_square_reduction - (finding.freedom - 1) * log(runs.samples),
                "refitted": True,
            }
