"""The methods that the diagnosis is held against, on the same blind cases.

Two of them know what the diagnosis compared (`benchmarks.blind_candidates`) and choose in another way; SINDy has a
command of its own (`benchmarks.blind_sindy`); the oracle knows the answer and only tests whether it is significant.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain
from math import log
from pathlib import Path
from typing import Any

from scipy.stats import chi2

from benchmarks.blind_candidates import CANDIDATES
from testbed.scoring.card import grouped
from testbed.scoring.case import Case
from testbed.scoring.formats import Named
from testbed.scoring.judging import NONE, UNMODELLED, exactly_right, label_right, named, truths
from testbed.scoring.rows import Row, share

OURS, REDUCTION, BIC, SINDY, ORACLE = "this diagnosis", "largest reduction", "best BIC", "SINDy", "oracle"
FAMILY_WISE_ERROR = 0.05

Labels = Mapping[str, str]
"""What a method says first of each case, by name; cases that it has nothing on are missing."""
Candidates = Mapping[str, Any]


@dataclass(frozen=True, kw_only=True)
class Comparison:
    """The same figure of all methods.

    Attributes:
        part: of the score card.
        what: is counted.
        rows: by method; those that it does not apply to are left out.
    """

    part: str
    what: str
    rows: Mapping[str, Row]


def read_candidates(diagnoses: Path, cases: Sequence[Case]) -> dict[str, Candidates]:
    """Return what was compared in each case that was diagnosed, by name."""
    paths = {case.name: diagnoses / case.name / CANDIDATES for case in cases}
    return {name: json.loads(path.read_text(encoding="utf-8")) for name, path in paths.items() if path.exists()}


def largest_reduction(candidates: Candidates) -> str:
    """Return the hypothesis that takes most off χ², however many parameters it needs; none where none takes any."""
    return _best(candidates, lambda each: each["gain"])


def best_criterion(candidates: Candidates) -> str:
    """Return the hypothesis with the best BIC, without any test; none where all are worse than none."""
    return _best(candidates, lambda each: each["gain"] - each["rank"] * log(candidates["samples"]))


def significant(candidates: Candidates, wanted: Named) -> bool:
    """Return whether a likelihood-ratio test of one hypothesis finds it, at the family-wise error of all of them."""
    return any(
        candidates["tested"] * chi2.sf(each["gain"], each["rank"]) < FAMILY_WISE_ERROR
        for each in candidates["hypotheses"]
        if Named(effect=each["effect"], component=each["component"]).kind == wanted.kind
    )


def _best(candidates: Candidates, worth: Callable[[Mapping[str, Any]], float]) -> str:
    best = max(candidates["hypotheses"], key=worth, default=None)
    if best is None or worth(best) <= 0.0:
        return NONE
    return Named(effect=best["effect"], component=best["component"]).key


def comparisons(cases: Sequence[Case], candidates: Mapping[str, Candidates], sindy: Labels) -> tuple[Comparison, ...]:
    """Return all methods side by side, stratum by stratum.

    Args:
        cases: with their diagnoses and answers.
        candidates: of the cases that were diagnosed.
        sindy: what it said; empty where it was not run.
    """
    methods: dict[str, Labels] = {
        REDUCTION: {name: largest_reduction(each) for name, each in candidates.items()},
        BIC: {name: best_criterion(each) for name, each in candidates.items()},
    } | ({SINDY: sindy} if sindy else {})
    none = "nothing is named"
    groups = chain(
        [("No effect", none, _of(cases, "null"))],
        [("Flown in MuJoCo, no effect", none, [case for case in _of(cases, "flown") if not truths(case)])],
        _sizes("One effect", _of(cases, "single")),
        _sizes("Flown in MuJoCo", [case for case in _of(cases, "flown") if truths(case)]),
        [("Two effects", "one of them first", _of(cases, "pair"))],
        (
            (f"Unmodelled torque at {size:g} sigma", none, few)
            for size, few in grouped(_of(cases, UNMODELLED), "wanted_sigma")
        ),
    )
    return tuple(_compared(part, what, few, methods, candidates) for part, what, few in groups if few)


def _sizes(part: str, cases: Sequence[Case]) -> Iterator[tuple[str, str, list[Case]]]:
    for times, few in grouped(cases, "detectable_sizes"):
        yield f"{part} at {times:g} times", "the very effect first", few


def _compared(
    part: str, what: str, cases: Sequence[Case], methods: Mapping[str, Labels], candidates: Mapping[str, Candidates]
) -> Comparison:
    nothing = what == "nothing is named"
    ours = [case.diagnosis is not None and not named(case) for case in cases] if nothing else map(exactly_right, cases)
    rows = {OURS: share(part, what, ours)}
    for method, labels in methods.items():
        asked = [case for case in cases if method != SINDY or case.name in labels]
        labelled = ((case, labels.get(case.name)) for case in asked)
        right = (
            label is not None and (label == NONE if nothing else label_right(case, label)) for case, label in labelled
        )
        rows[method] = share(part, what, right)
    if all(len(truths(case)) == 1 for case in cases):
        rows[ORACLE] = share(part, what, (_seen_by_oracle(case, candidates) for case in cases))
    return Comparison(part=part, what=what, rows=rows)


def _seen_by_oracle(case: Case, candidates: Mapping[str, Candidates]) -> bool:
    return case.name in candidates and significant(candidates[case.name], truths(case)[0])


def _of(cases: Sequence[Case], stratum: str) -> list[Case]:
    return [case for case in cases if case.answer.stratum == stratum]
