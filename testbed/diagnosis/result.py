"""What diagnosis.json holds."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict
from math import isfinite
from typing import Any

import numpy as np

from testbed.diagnosis.detectable import INERTIA, Detectable, confounded, detectable_sizes, pairs_alike
from testbed.diagnosis.findings import (
    Addition,
    InertiaChange,
    additions,
    changed_inertia,
    inertia_change,
    nominal_gap,
    stds_of,
)
from testbed.diagnosis.location import ResidualSegment
from testbed.diagnosis.misfit import BANDWIDTH, Misfit, explained
from testbed.diagnosis.model import Fit, Hypothesis
from testbed.diagnosis.noise import NoiseHypothesis
from testbed.diagnosis.noise_by_record import noise_by_record
from testbed.diagnosis.run_agreement import Agreement
from testbed.diagnosis.state import Diagnosis, Gap
from testbed.dynamics.inertia import PARAMETER_NAMES
from testbed.effects.contract import Quantity
from testbed.estimation.noise_color import NoiseColor

SCHEMA = 1
"""Version of the format of diagnosis.json; it rises when a key changes its meaning or goes."""

Content = dict[str, Any]


def result_of(
    diagnosis: Diagnosis,
    places: Sequence[ResidualSegment],
    notices: Sequence[str],
    agreements: Sequence[Agreement] = (),
) -> Content:
    """Return what diagnosis.json says; numbers in SI, None where there is none.

    Args:
        diagnosis: complete or not.
        places: where the gap is.
        notices: what a reader has to know of the records.
        agreements: of the runs on what was added.
    """
    return {
        "schema": SCHEMA,
        "complete": diagnosis.complete,
        "verdict": diagnosis.verdict,
        "steps": [
            *_inertia_step(diagnosis),
            *(_step(addition) for addition in additions(diagnosis)),
        ],
        "gap": {"noise_floor": 1.0} | _gap("", "before", diagnosis.gap_before) | _gap("", "after", diagnosis.gap),
        "misfit": _misfits(diagnosis.gap_before, diagnosis.gap),
        "where": [asdict(place) for place in places],
        "probabilities": dict(diagnosis.probabilities),
        "untestable": list(untestable(diagnosis)),
        "detectable": [_detectable(each) for each in detectable_sizes(diagnosis)],
        "look_alikes": [
            {"pair": [_named(one), _named(other)], "distance": distance}
            for one, other, distance in pairs_alike(diagnosis)
        ],
        "run_by_run": [_agreement(each) for each in agreements],
        "differs": _differing(diagnosis),
        "inertia": _inertia(diagnosis),
        "noise": _noise(diagnosis),
        "latent_torque": _latent(diagnosis),
        "torque_left": None if diagnosis.shape_left is None else asdict(diagnosis.shape_left),
        "taken_back": [_named(each) for each in diagnosis.retracted],
        "runs": {
            "fit": diagnosis.runs.record_names,
            "heldout": [] if diagnosis.heldout is None else diagnosis.heldout.record_names,
        },
        "notices": list(notices),
    }


def _differing(diagnosis: Diagnosis) -> Content | None:
    found = diagnosis.differing
    if found is None:
        return None
    named = {"effect": "inertia", "component": "platform"} if found.placed is None else _named(found.placed)
    return named | {"record": found.record, "as_healthy": found.as_healthy}


def _noise(diagnosis: Diagnosis) -> Content:
    runs, level = diagnosis.runs, diagnosis.noise
    turns = runs.live.any(axis=0)
    squares = np.where(runs.live, (runs.sigma / runs.as_stated().sigma) ** 2, 0.0).sum(axis=0)
    ratio = np.sqrt(squares / np.where(turns, runs.live.sum(axis=0), np.nan))
    color = runs.color or NoiseColor(persistence=np.zeros(3), average=np.zeros(3))
    correlation, persistence = (np.where(turns, each, np.nan) for each in (color.correlation, color.persistence))
    return {
        "by_record": {name: _number(each) for name, each in noise_by_record(diagnosis).ratio.items()},
        "ratio_to_stated": [_number(each) for each in level.ratio.tolist()],
        "std": [_number(each) for each in level.std.tolist()],
        "level": [_number(each) for each in ratio.tolist()],
        "correlation": [_number(each) for each in correlation.tolist()],
        "persistence": [_number(each) for each in persistence.tolist()],
        "degrees_of_freedom": None if np.isinf(runs.noise_freedom) else runs.noise_freedom,
    }


def untestable(diagnosis: Diagnosis) -> Iterator[Content]:
    """Yield the effects that could not be tested for, or not at their typical size, with what it would take."""
    for each in diagnosis.untestable:
        place = {} if each.component is None else {"component": each.component}
        yield {"effect": each.effect} | place | {"needs": each.needs}
    for size in detectable_sizes(diagnosis):
        if not size.seen_when_typical:
            yield _named(size.placed) | {"needs": needs_of(size)}
    for placed, by in confounded(diagnosis):
        yield _named(placed) | {"needs": unconfounded_needs(by)}


def unconfounded_needs(by: Hypothesis) -> str:
    """Return what it would take to test for an effect that another one confounds."""
    return f"{by.component} without {by.effect.id}, whose signature there is the same"


def needs_of(size: Detectable) -> str:
    """Return what it would take to see an effect that is below what the data show."""
    if not size.smallest:
        return "another motion: in this one it has no signature, or that of an inertia"
    return f"a size of {size_words(size.smallest)}; typical is {size_words(size.typical)}"


def size_words(quantities: Sequence[Quantity]) -> str:
    """Return parameters in words, one number where all are alike."""
    distinct = dict.fromkeys(f"{each.value:.3g} {each.unit}".removesuffix(" 1") for each in quantities)
    return ", ".join(distinct)


def _step(addition: Addition) -> Content:
    return {
        **_named(addition),
        "parameters": _parameters(addition.quantities),
        "probability": _number(addition.probability),
        **_theta("j_", addition.fit),
        "indistinguishable_from": [_named(other) for other in addition.look_alikes],
        "doubts": list(addition.doubts),
        **_gap("gap_", "before", addition.before, heldout="heldout_gap_"),
        **_gap("gap_", "after", addition.after, heldout="heldout_gap_"),
        "misfit": _misfits(addition.before, addition.after),
    }


def _inertia_step(diagnosis: Diagnosis) -> Iterator[Content]:
    """Yield the inertia as a step of its own where it differs from the nominal one; it is in every model anyhow."""
    change = inertia_change(diagnosis)
    if not change.significant:
        return
    nominal = nominal_gap(diagnosis)
    yield {
        "effect": INERTIA,
        "component": "platform",
        "parameters": _parameters(_differences(change)),
        "probability": 1.0 - change.p_value,
        **_theta("j_", diagnosis.model),
        "indistinguishable_from": [],
        "doubts": [],
        **_gap("gap_", "before", nominal, heldout="heldout_gap_"),
        **_gap("gap_", "after", diagnosis.gap_before, heldout="heldout_gap_"),
        "misfit": _misfits(nominal, diagnosis.gap_before),
    }


def _differences(change: InertiaChange) -> Sequence[Quantity]:
    numbers = zip(PARAMETER_NAMES, change.difference, change.std, strict=True)
    return [
        Quantity(name=f"d{name}_kg_m2", unit="kg·m²", value=float(value), std=float(std))
        for name, value, std in numbers
        if np.isfinite(value)  # what the motion cannot show of the inertia is left out
    ]


def _inertia(diagnosis: Diagnosis) -> Content:
    return {
        "nominal_theta_kg_m2": diagnosis.nominal_theta.tolist(),
        "before": _theta("", diagnosis.baseline),
        "after": _theta("", diagnosis.model),
        "differs_p_value": inertia_change(diagnosis).p_value,
    } | _healthy_inertia(diagnosis)


def _healthy_inertia(diagnosis: Diagnosis) -> Content:
    change = changed_inertia(diagnosis)
    if change is None:
        return {}
    return {
        "healthy_theta_kg_m2": change.theta.tolist(),
        "differs_from_healthy_p_value": change.p_value,
    }


def _latent(diagnosis: Diagnosis) -> Content | None:
    latent = diagnosis.latent
    return None if latent is None else {"likelihood_ratio": latent.likelihood_ratio, "p_value": latent.p_value}


def _detectable(size: Detectable) -> Content:
    return {
        **_named(size.placed),
        "smallest": {each.name: {"value": _number(each.value), "unit": each.unit} for each in size.smallest},
        "typical": {each.name: {"value": _number(each.value), "unit": each.unit} for each in size.typical},
        "multiple_of_typical": _number(size.multiple),
        "by_frequency": [
            {
                "smallest": {each.name: {"value": _number(each.value), "unit": each.unit} for each in one.smallest},
                "multiple_of_typical": _number(one.multiple),
            }
            for one in size.by_frequency
        ],
    }


def _named(placed: Hypothesis | NoiseHypothesis | Addition) -> Content:
    return {"effect": placed.effect.id, "component": placed.component}


def _parameters(quantities: Sequence[Quantity]) -> Mapping[str, Content]:
    return {
        each.name: {"value": _number(each.value), "std": _number(each.std), "unit": each.unit} for each in quantities
    }


def _theta(prefix: str, fit: Fit) -> Content:
    return {
        f"{prefix}theta_kg_m2": [
            value if shown else None for value, shown in zip(fit.theta.tolist(), fit.shown[:6], strict=True)
        ],
        f"{prefix}std_kg_m2": [_number(std) for std in stds_of(fit)[:6].tolist()],
    }


def _gap(prefix: str, when: str, gap: Gap, *, heldout: str = "heldout_") -> Content:
    return {f"{prefix}{when}": _number(gap.fit), f"{heldout}{when}": _number(gap.heldout)}


def _misfits(before: Gap, after: Gap) -> Content:
    """Return what is more than noise, of fitted and held-out runs, before and after."""
    pairs = {"": (before.misfit, after.misfit), "heldout_": (before.heldout_misfit, after.heldout_misfit)}
    content: Content = {"bandwidth_hz": BANDWIDTH}
    for role, (one, other) in pairs.items():
        share = explained(one, other)
        content |= {f"{role}before": _misfit(one), f"{role}after": _misfit(other)}
        content |= {f"{role}explained": None if share is None else share.share}
        content |= {f"{role}explained_std": None if share is None else share.std}
    return content


def _misfit(misfit: Misfit | None) -> Content | None:
    if misfit is None:
        return None
    return {
        "sigma": misfit.sigma,
        "noise_limit_sigma": misfit.noise_limit,
        "p_value": misfit.p_value,
        "chi_square": misfit.chi_square,
        "expected": misfit.expected,
        "variance": misfit.variance,
        "gimbals_chi_square": misfit.gimbals,
    }


def _agreement(agreement: Agreement) -> Content:
    return {
        **_named(agreement.placed),
        "p_value": agreement.p_value,
        "runs": {name: _parameters(agreement.quantities(index)) for index, name in enumerate(agreement.runs)},
    }


def _number(value: float) -> float | None:
    """Return a number that JSON can hold."""
    return value if isfinite(value) else None
