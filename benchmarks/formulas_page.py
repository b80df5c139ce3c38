"""docs/formulas.md: how often hidden formulas are named rightly, as a page, from what was said of every set."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, TypeAlias

import numpy as np
from scipy.stats import binomtest

from benchmarks.formula_sets import NO_LAW, SIGMAS, HiddenFormula, Judged, Said, judged
from concealing.formula_effects import LAWS

Kept: TypeAlias = Mapping[str, Any]
"""What was kept of a set, as JSON."""
OURS = "testbed"
TITLES = {OURS: "testbed", "sindy": "SINDy", "operon": "symbolic regression"}
_WANTED = {
    ("in_class", 8.0): "≥ 85 %",
    ("in_class", 16.0): "≥ 95 %",
    ("exact", 16.0): "≥ 85 %",
}
_WORDS = {"in_class": "right class", "exact": "exact", "driver": "right driver"}
_HEAD = """# Hidden formulas

Written by `python -m benchmarks.formulas card --write`; do not edit.

    python -m benchmarks.formulas run           # makes and diagnoses the sets
    python -m benchmarks.formulas others        # runs the other methods
    python -m benchmarks.formulas card --write  # scores this page

The first two write into runs/ and can be interrupted: repeated, they go on. The third scores what has been done so far.

The concealing engine hides a torque that follows a random law, which no effect of the library has, in five runs of 5 s
at 16 Hz of the shipped platform. It writes laws down by exponents, without the testbed's grammar. A law is about a body
axis, or in any direction of the body or of space; the families come in turns, and one set of five has no effect. Every
set is diagnosed with the whole library, one run held out. *Right class*: the hidden formula, or the same law in any
direction of the body, is named first or cannot be distinguished from what is. *Exact*: it is named first.
*Right driver*: what is named first follows the same quantities, whatever its axis and its memory.
Laws with a memory, of gimbals, of actuators' torque and pulses are searched for, and not hidden here.

The other methods see the same records, and are judged by the same rule. *SINDy* is an ensemble of sparse regressions
(pysindy) of the differentiated residual torque on what every law of the grammar without a memory would make; all terms
that stay count as its class. *Symbolic regression* (pyoperon) gets the smoothed unmodelled torque that the diagnosis
estimates, and the time, rates, attitude and gimbals; the formula that explains the most of its expressions is its name,
and those that explain as much within 2 % are its class.
"""


def rows_of(kept: Sequence[Kept]) -> dict[str, Any]:
    """Return all figures of sets, as JSON."""
    sets = [each for each in kept if each["hidden"]["sigma"] > 0.0]
    none = [each for each in kept if each["hidden"]["family"] == NO_LAW]
    families = [
        _row(f"{family} at {sigma:g} σ", method, what, own)
        for family in LAWS
        for sigma in SIGMAS
        if (own := _of(sets, sigma, family))
        for method in _asked(own)
        for what in ("in_class", "exact")
    ]
    sizes = [
        _row(f"{sigma:g} σ", method, what, own, _WANTED.get((what, sigma), "") if method == OURS else "")
        for sigma in SIGMAS
        if (own := _of(sets, sigma))
        for what in _WORDS
        for method in _asked(own)
    ]
    nulls = [
        _share(
            f"{TITLES[method]} names something",
            [_has_name(each, method) for each in none],
            "≤ 2 %" if method == OURS else "",
        )
        for method in _asked(none)
    ]
    return {
        "sizes": sizes,
        "families": families,
        "nulls": nulls,
        "intervals": [
            _share(f"{sigma:g} σ", [inside for each in _of(sets, sigma) for inside in each["covered"]], "92 to 98 %")
            for sigma in SIGMAS
        ],
        "medians": list(_medians(sets, none)),
    }


def page(content: Mapping[str, Any]) -> str:
    """Return the page of figures."""
    lines = [
        _HEAD,
        f"Seed {content['seed']}, the first {content['sets']} sets. Scored {content['where']}. Intervals are those of "
        "Clopper and Pearson, 95 %.\n",
        "| size | what | method | share | of | 95 % interval | wanted |",
        "|---|---|---|---|---|---|---|",
        *(_line(each, each["row"], _WORDS[each["what"]], TITLES[each["method"]]) for each in content["sizes"]),
        "\nBy family of the law:\n",
        "| hidden | " + " | ".join(f"{TITLES[each]}: class | exact" for each in TITLES) + " |",
        "|---|" + "---|---|" * len(TITLES),
        *_wall(content["families"]),
        "\n| | share | of | 95 % interval | wanted |",
        "|---|---|---|---|---|",
        *(_line(each, f"without an effect, {each['row']}") for each in content["nulls"]),
        *(_line(each, f"95 % intervals with the truth in them, {each['row']}") for each in content["intervals"]),
        "\n| | median | 90th percentile | of | wanted |",
        "|---|---|---|---|---|",
        *(
            f"| {each['row']} | {each['median']:.3g} | {each['high']:.3g} | {each['of']} | {each['wanted']} |"
            for each in content["medians"]
        ),
    ]
    return "\n".join(lines) + "\n"


def _of(sets: Sequence[Kept], sigma: float, family: str = "") -> list[Kept]:
    hidden = ((each, each["hidden"]) for each in sets)
    return [each for each, of in hidden if of["sigma"] == sigma and family in ("", of["family"])]


def _asked(sets: Sequence[Kept]) -> Iterator[str]:
    """Yield the methods that were asked of any of the sets."""
    yield from (method for method in TITLES if any(method in each["said"] for each in sets))


def _said(each: Kept, method: str) -> Said:
    content = each["said"][method]
    return Said(named=tuple(content["named"]), alike=tuple(content["alike"]))


def _has_name(each: Kept, method: str) -> bool | None:
    return bool(_said(each, method).named) if method in each["said"] else None


def _judged(each: Kept, method: str) -> Judged | None:
    hidden = each["hidden"]
    return (
        judged(_said(each, method), HiddenFormula(**hidden | {"values": tuple(hidden["values"])}))
        if method in each["said"]
        else None
    )


def _row(row: str, method: str, what: str, sets: Sequence[Kept], wanted: str = "") -> dict[str, Any]:
    right = [None if (one := _judged(each, method)) is None else bool(getattr(one, what)) for each in sets]
    return _share(row, right, wanted) | {"method": method, "what": what}


def _share(row: str, right: Sequence[bool | None], wanted: str = "") -> dict[str, Any]:
    """Return a share with its interval; sets of which a method was not asked do not count."""
    counted = [each for each in right if each is not None]
    facts = {"row": row, "hits": sum(counted), "of": len(counted), "wanted": wanted}
    if not counted:
        return facts | {"share": None, "low": None, "high": None}
    interval = binomtest(sum(counted), len(counted)).proportion_ci()
    return facts | {"share": sum(counted) / len(counted), "low": interval.low, "high": interval.high}


def _medians(sets: Sequence[Kept], none: Sequence[Kept]) -> Iterator[dict[str, Any]]:
    diagnosed = [each for each in sets if "refused" not in each]
    figures: list[tuple[str, str, Sequence[Kept], Callable[[Kept], float]]] = [
        *(
            (
                f"held-out misfit after naming, {sigma:g} σ, over the floor",
                "≤ 1.05",
                [each for each in _of(sets, sigma) if _said(each, OURS).named],
                lambda each: each["heldout"][1],
            )
            for sigma in SIGMAS
        ),
        ("formulas in the class, testbed", "", sets, lambda each: 1.0 + len(_said(each, OURS).alike)),
        *(
            (
                f"formulas in the class, {TITLES[method]}",
                "",
                [each for each in sets if method in each["said"] and _said(each, method).named],
                lambda each, method=method: 1.0 + len(_said(each, method).alike),
            )
            for method in TITLES
            if method != OURS
        ),
        (
            "processor time with formulas over that without, sets with an effect",
            "≤ 2",
            diagnosed,
            lambda each: each["seconds"] / each["without_formulas"],
        ),
        ("processor time of a diagnosis, s", "", [*diagnosed, *none], lambda each: each["seconds"]),
    ]
    for row, wanted, own, value in figures:
        if own:
            every = [value(each) for each in own]
            median, high = np.median(every), np.quantile(every, 0.9)
            yield {"row": row, "median": float(median), "high": float(high), "of": len(own), "wanted": wanted}


def _line(each: Mapping[str, Any], *words: str) -> str:
    shown = "-" if each["share"] is None else f"{each['share']:.0%}"
    interval = "" if each["share"] is None else f"{each['low']:.0%} to {each['high']:.0%}"
    return f"| {' | '.join(words)} | {shown} | {each['of']} | {interval} | {each['wanted']} |"


def _wall(families: Sequence[Mapping[str, Any]]) -> Iterator[str]:
    counts = {(each["row"], each["method"], each["what"]): f"{each['hits']} of {each['of']}" for each in families}
    for row in dict.fromkeys(each["row"] for each in families):
        cells = (counts.get((row, method, what), "-") for method in TITLES for what in ("in_class", "exact"))
        yield f"| {row} | {' | '.join(cells)} |"
