"""The score card over many cases; every figure is defined in docs/scoring.md."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from itertools import chain
from types import MappingProxyType
from typing import Any

import scipy

from testbed.scoring.calibration import Bin, bins, calibration_error
from testbed.scoring.case import Case
from testbed.scoring.judging import (
    NONE,
    UNMODELLED,
    all_right,
    effect_right,
    exactly_right,
    inertia_covered,
    named,
    parameters_covered,
    recognised_as_unknown,
    reported_set,
    said,
    said_right,
    set_holds_truth,
)
from testbed.scoring.rows import CONFIDENCE, Row, mean, quantile, share

SCHEMA = 1
SURELY_SEEN = 2.0
"""Detectable sizes from which on an effect's parameters, the inertia and the held-out gap are scored."""
_WIDTH = float(scipy.stats.norm.isf(0.5 * (1.0 - CONFIDENCE)))


@dataclass(frozen=True, kw_only=True)
class ScoreCard:
    """What diagnoses are worth.

    Attributes:
        cases: that there are answers of.
        sealed: answers that were held against their hash.
        failures: why cases have no diagnosis, by case; they count as misses.
        rows: the figures.
        confusion: cases by what was hidden and what was said first, effects only.
        calibration: the reliability diagram.
    """

    cases: int
    sealed: int
    failures: Mapping[str, str]
    rows: tuple[Row, ...]
    confusion: Mapping[str, Mapping[str, int]]
    calibration: tuple[Bin, ...]


FIRST_WANTED: Mapping[float, str] = MappingProxyType({2.0: "≥ 95 %", 4.0: "≥ 99 %"})
"""Share of single effects whose class is wanted first, by the number of detectable sizes."""


def score_card(cases: Sequence[Case], first_wanted: Mapping[float, str] = FIRST_WANTED) -> ScoreCard:
    """Return the score card of cases.

    Args:
        cases: with their answers.
        first_wanted: as `FIRST_WANTED`.
    """
    return ScoreCard(
        cases=len(cases),
        sealed=sum(case.sealed for case in cases),
        failures={case.name: case.failure for case in cases if case.diagnosis is None},
        rows=tuple(
            row
            for row in chain(_null(cases), _single(cases, first_wanted), _flown(cases), _others(cases), _figures(cases))
            if row.of
        ),
        confusion=_confusion(cases),
        calibration=bins(cases),
    )


def card_content(card: ScoreCard) -> dict[str, Any]:
    """Return the score card as JSON holds it."""
    return {"schema": SCHEMA} | asdict(card)


def _null(cases: Sequence[Case]) -> Iterator[Row]:
    null = _of(cases, "null")
    part = "No effect"
    any_name = [case.diagnosis is None or bool(named(case)) for case in null]
    yield share(part, "a name is given", any_name, "≤ 5 %", "≤ 7 %")
    yield share(part, "none is reported", map(said_right, null))
    yield share(part, "noise stated too large: none is reported", map(said_right, _of(cases, "sigma_overstated")))
    yield share(part, "noise stated too small: gyro_noise first", map(said_right, _of(cases, "sigma_understated")))


def _single(cases: Sequence[Case], first_wanted: Mapping[float, str]) -> Iterator[Row]:
    single = _of(cases, "single")
    for times, group in grouped(single, "detectable_sizes"):
        part = f"One effect at {times:g} times"
        wanted = first_wanted.get(times, "")
        yield share(part, "effect class and component first", map(said_right, group), wanted)
        yield share(part, "the very effect first, no alias", map(exactly_right, group))
        yield share(part, "effect first, at any component", map(effect_right, group))
        yield share(part, "the set holds the truth", map(set_holds_truth, group), "≥ 95 %" if times == 1.0 else "")
        size = {1.0: "≤ 3", 2.0: "≤ 1.5"}.get(times, "")
        yield mean(part, "size of the set", _set_sizes(group), size)


def _set_sizes(cases: Sequence[Case]) -> Iterator[float]:
    return (float(len(reported_set(case.diagnosis))) for case in cases if case.diagnosis is not None)


def _flown(cases: Sequence[Case]) -> Iterator[Row]:
    flown = _of(cases, "flown")
    part = "Flown in MuJoCo"
    without = [case for case in flown if not case.answer.effects]
    yield share(part, "no effect: a name is given", (case.diagnosis is None or bool(named(case)) for case in without))
    for times, group in grouped([case for case in flown if case.answer.effects], "detectable_sizes"):
        yield share(part, f"effect class and component first at {times:g} times", map(said_right, group))


def _others(cases: Sequence[Case]) -> Iterator[Row]:
    pairs = _of(cases, "pair")
    yield share("Two effects", "exactly the pair", map(all_right, pairs), "≥ 80 %")
    yield share("Two effects", "one of them first", map(said_right, pairs))
    for sigma, group in grouped(_of(cases, UNMODELLED), "wanted_sigma"):
        part = f"Unmodelled torque at {sigma:g} sigma"
        wanted = {8.0: "≥ 85 %", 16.0: "≥ 97 %"}.get(sigma, "")
        yield share(part, "unexplained is reported", map(recognised_as_unknown, group), wanted)
        yield share(part, "no name is given", (case.diagnosis is not None and not named(case) for case in group))
        for effect in sorted({case.answer.effects[0].effect for case in group}):
            own = [case for case in group if case.answer.effects[0].effect == effect]
            sine = "≥ 60 %" if (effect, sigma) == ("sine_torque", 8.0) else ""
            yield share(part, f"{effect}: unexplained is reported", map(recognised_as_unknown, own), sine)


def _figures(cases: Sequence[Case]) -> Iterator[Row]:
    seen = _surely_seen(cases)
    right = [case for case in seen if said_right(case)]
    intervals = "95 % intervals that hold the truth"
    wanted = "92 to 98 %"
    yield share(intervals, "parameters of effects named", _all(right, lambda c: parameters_covered(c, _WIDTH)), wanted)
    for what, added, wish in (("with what was named", True, wanted), ("without any effect", False, "")):
        covered = _all(seen, lambda case, added=added: inertia_covered(case, _WIDTH, with_effects=added))  # type: ignore[misc]
        yield share(intervals, f"inertia {what}", covered, wish)
    gaps = [gap for case in right if case.diagnosis and (gap := case.diagnosis.gap.heldout_after) is not None]
    yield quantile("Held-out gap after naming", "median", gaps, 0.5, "≤ 1.05")
    yield quantile("Held-out gap after naming", "90th percentile", gaps, 0.9, "≤ 1.10")
    yield calibration_error("Probabilities", "expected calibration error", cases, "≤ 0.05")
    yield share("Cases", "no diagnosis", (case.diagnosis is None for case in cases))


def _surely_seen(cases: Sequence[Case]) -> list[Case]:
    """Return the cases of one effect that surely shows, whatever flew them."""
    return [
        case
        for case in cases
        if case.answer.stratum in ("single", "flown") and _note(case, "detectable_sizes") >= SURELY_SEEN
    ]


def _all(cases: Sequence[Case], flags: Callable[[Case], Any]) -> Iterator[bool]:
    return chain.from_iterable(flags(case) for case in cases)


def _of(cases: Sequence[Case], stratum: str) -> list[Case]:
    return [case for case in cases if case.answer.stratum == stratum]


def _note(case: Case, name: str) -> float:
    return float(case.answer.notes.get(name, 0.0))


def grouped(cases: Sequence[Case], note: str) -> Iterator[tuple[float, list[Case]]]:
    """Yield the cases of every size, the smallest first; `note` is where an answer states it."""
    for size in sorted({_note(case, note) for case in cases}):
        yield size, [case for case in cases if _note(case, note) == size]


def _confusion(cases: Sequence[Case]) -> Mapping[str, Mapping[str, int]]:
    """Return cases by hidden effect and by what was said first; pairs are left out, they hold two."""
    table: dict[str, Counter[str]] = {}
    for case in cases:
        if len(case.answer.effects) < 2:
            hidden = case.answer.effects[0].effect if case.answer.effects else NONE
            label = said(case)[0]
            table.setdefault(hidden, Counter())[label.partition(":")[0]] += 1
    return {hidden: dict(counts.most_common()) for hidden, counts in sorted(table.items())}
