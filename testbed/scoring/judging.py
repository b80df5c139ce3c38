"""One case judged: what was said first, whether that is right, which set was reported. Terms as in docs/scoring.md."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import permutations
from math import exp

import numpy as np

from testbed.scoring.case import Case
from testbed.scoring.formats import DiagnosisFile, Hidden, Number, Step, place_key

NONE, UNKNOWN, MISSING = "none", "unknown", "missing"
UNMODELLED = "unlisted"
"""Stratum of effects that no library lists."""
INERTIA = "inertia"
"""Re-estimated in every model: a step, never a verdict."""
CLOSE = exp(-3.0)
"""Ratio of probabilities above which two are indistinguishable: a difference of 6 in the information criterion."""
INERTIA_ALIASES = frozenset(
    {"inertia:platform", "gyro_scale:x", "gyro_scale:y", "gyro_scale:z", "gyro_misalignment:gyro_cross_axis"}
)
"""What no residual tells apart where the total momentum is zero."""
FORMULA = "formula"
"""Of a torque that no library lists, by the law that it follows: it says that something unknown is there, and what."""
_AXIS = ("axis_x", "axis_y", "axis_z")
AT_REST = 0.05
"""rad/s: body rate at release below which the total momentum counts as zero; errors of release stay below."""


def truths(case: Case) -> tuple[Hidden, ...]:
    """Return the hidden effects that have a name."""
    listed = () if case.answer.stratum == UNMODELLED else case.answer.effects
    return tuple(hidden for hidden in listed if hidden.effect != INERTIA)


def named(case: Case) -> tuple[Step, ...]:
    """Return the effects that were named, in their order."""
    steps = () if case.diagnosis is None else case.diagnosis.steps
    return tuple(step for step in steps if step.effect != INERTIA)


def said(case: Case) -> tuple[str, float | None]:
    """Return what was said first, and how probable it was said to be: a key, none, unknown or missing."""
    if case.diagnosis is None:
        return MISSING, None
    first = named(case)[:1]
    if first:
        return first[0].key, first[0].probability
    label = UNKNOWN if case.diagnosis.verdict == "unexplained" else NONE
    return label, case.diagnosis.probabilities.get(label)


def said_right(case: Case) -> bool:
    """Return whether what was said first is right: the hidden effect is the one named, or in its equivalence class."""
    first = named(case)[:1]
    labels = [each.key for step in first for each in step.alike] or [said(case)[0]]
    return any(label_right(case, label) for label in labels) or _alias_reported(case)


def exactly_right(case: Case) -> bool:
    """Return whether what was said first is the very effect that is hidden; another member of its class is a miss."""
    return label_right(case, said(case)[0]) or _alias_reported(case)


def label_right(case: Case, label: str) -> bool:
    """Return whether a key, none or unknown is right; equivalence classes are not known here."""
    if case.answer.stratum == UNMODELLED:
        return label == UNKNOWN or label.startswith(f"{FORMULA}:")
    if not truths(case):
        return label == NONE
    return label in {hidden.key for hidden in truths(case)}


def effect_right(case: Case) -> bool:
    """Return whether the effect that was named first is right, wherever it was said to sit."""
    effects = {step.effect for step in named(case)[:1]}
    return bool(effects & {hidden.effect for hidden in truths(case)}) or _alias_reported(case)


def all_right(case: Case) -> bool:
    """Return whether just those effects were named that are there, each itself or by its equivalence class."""
    keys, steps = [hidden.key for hidden in truths(case)], named(case)
    if case.diagnosis is None or len(steps) != len(keys):
        return False
    classes = [{each.key for each in step.alike} for step in steps]
    return any(all(key in those for key, those in zip(order, classes, strict=True)) for order in permutations(keys))


def recognised_as_unknown(case: Case) -> bool:
    """Return whether it was said that no effect of the library explains it: a gap is left, or a formula is named."""
    if case.diagnosis is None:
        return False
    return case.diagnosis.verdict == "unexplained" or any(step.effect == FORMULA for step in named(case))


def reported_set(diagnosis: DiagnosisFile) -> frozenset[str]:
    """Return the first named effect, its equivalence class, and what is nearly as probable."""
    first = next((step for step in diagnosis.steps if step.effect != INERTIA), None)
    probable = {
        key: probability
        for key, probability in diagnosis.probabilities.items()
        if key not in (NONE, UNKNOWN) and probability is not None
    }
    known = None if first is None else first.probability
    reference = max(probable.values(), default=0.0) if known is None else known
    near = frozenset(
        place_key(part)
        for key, probability in probable.items()
        if probability >= CLOSE * reference
        for part in key.split("|")
    )
    return near | (frozenset() if first is None else frozenset(each.key for each in first.alike))


def set_holds_truth(case: Case) -> bool:
    """Return whether the reported set holds an effect that is there; a key without a component stands for all."""
    if case.diagnosis is None:
        return False
    reported = reported_set(case.diagnosis)
    return any(hidden.key in reported or hidden.effect in reported for hidden in truths(case)) or _alias_reported(case)


def parameters_covered(case: Case, width: float) -> Iterator[bool]:
    """Yield for every parameter of an effect that was rightly named whether its interval holds the true value.

    Args:
        case: to judge.
        width: of half an interval, in standard errors.
    """
    steps = {step.kind: step for step in named(case)}
    for hidden in truths(case):
        found = steps[hidden.kind].parameters if hidden.kind in steps else {}
        sign = _axis_sign(hidden.parameters, found)
        for name, true in hidden.parameters.items():
            guess = found.get(name)
            if true.value is not None and guess is not None and guess.value is not None and guess.std is not None:
                value = sign * true.value if name in _AXIS else true.value
                yield abs(guess.value - value) <= width * guess.std


def _axis_sign(true: Mapping[str, Number], found: Mapping[str, Number]) -> float:
    """Return -1 where an axis is reported with the opposite sign: both signs are the same axis of a hinge."""
    pairs = ((true[name].value, found[name].value) for name in _AXIS if name in true and name in found)
    return -1.0 if sum(one * other for one, other in pairs if one is not None and other is not None) < 0.0 else 1.0


def inertia_covered(case: Case, width: float, *, with_effects: bool) -> tuple[bool, ...]:
    """Return for every inertia parameter whether its interval holds the true one; none where it is not reported.

    Args:
        case: to judge.
        width: of half an interval, in standard errors.
        with_effects: of the model with the effects, or of the one without any.
    """
    theta, std = _theta(case.diagnosis, with_effects=with_effects)
    estimates = zip(theta, std, case.answer.true_theta_kg_m2, strict=False)
    return tuple(
        value is not None and error is not None and abs(value - true) <= width * error
        for value, error, true in estimates
    )


def _theta(
    diagnosis: DiagnosisFile | None, *, with_effects: bool
) -> tuple[tuple[float | None, ...], tuple[float | None, ...]]:
    if diagnosis is None:
        return (), ()
    reported = diagnosis.inertia.after if with_effects else diagnosis.inertia.before
    if reported is not None:
        return reported.theta_kg_m2, reported.std_kg_m2
    if with_effects and diagnosis.steps:
        return diagnosis.steps[-1].j_theta_kg_m2, diagnosis.steps[-1].j_std_kg_m2
    return (), ()


def _alias_reported(case: Case) -> bool:
    """Return whether the effect is an alias of the inertia, and a step of that class lists it."""
    exact = {hidden.kind for hidden in truths(case)} & INERTIA_ALIASES
    if not exact or case.diagnosis is None or not _at_rest(case):
        return False
    classes = [step.alike for step in case.diagnosis.steps if step.kind in INERTIA_ALIASES]
    return any(each.kind in exact for alike in classes for each in alike)


def _at_rest(case: Case) -> bool:
    rates = np.array(case.answer.initial_rates_rad_s)
    return len(rates) > 0 and bool(np.linalg.norm(rates, axis=1).max() < AT_REST)
