"""Blind sets of several platforms: made, diagnosed and scored in stages, each platform in a folder of its own.

`make` writes OUT/PLATFORM/data and answers, `run` diagnoses the data into OUT/PLATFORM/diagnoses while the answers are
locked, `card` scores what has been diagnosed so far into OUT, with --write into docs/ too. What is there already is
kept: an interrupted `make` or `run` goes on where it was; --first N takes the first N of the random order, a fair
sample.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

from benchmarks.blind import diagnose_all, kept_seconds, locked, make_all, timed_make
from benchmarks.blind_page import Making, confusion, content_of, figures, opening
from benchmarks.misspecified import diagnosed_sets
from benchmarks.table import DOCS, here_and_now
from concealing.order import Order
from testbed.cli.score import print_card
from testbed.scoring.card import FIRST_WANTED, score_card
from testbed.scoring.case import Case


@dataclass(frozen=True, kw_only=True)
class PlatformSets:
    """Blind sets that are made, diagnosed and scored together.

    Attributes:
        module: whose `main` is called, as after `python -m`.
        page: name of the page and of its figures in docs/, without suffix.
        scenarios: nominal ones, by platform.
        orders: returns a platform's cases, of its name, their number and the seed.
        make: makes a case of a platform where it is not whole yet.
        seed: of a set that nobody has looked at.
        cases: of each platform.
        head: of the page.
        first_wanted: share of single effects whose class is wanted first, by the number of detectable sizes.
    """

    module: str
    page: str
    scenarios: Mapping[str, Path]
    orders: Callable[[str, int, int], list[Order]]
    make: Callable[..., Path]
    seed: int
    cases: int
    head: str
    first_wanted: Mapping[float, str] = field(default_factory=lambda: FIRST_WANTED)

    def text(self, contents: Mapping[str, Mapping[str, Any]], words: str = "") -> str:
        """Return the page.

        Args:
            contents: of score cards, by platform, that of both first.
            words: what is to be said before the figures.
        """
        lines = [words, ""] if words else []
        for name, content in contents.items():
            title = "Both platforms" if name == "both" else f"`{name}`"
            lines += [f"## {title}\n", *opening(content), "", *figures(content), "", *confusion(content), ""]
        return self.head + "\n".join(lines).rstrip() + "\n"


def main(sets: PlatformSets) -> None:
    """Do what the command line says."""
    chosen = _arguments(sets)
    if chosen.stage == "card":
        _card(sets, chosen)
        return
    for platform in chosen.platforms:
        (_made if chosen.stage == "make" else _run)(sets, platform, chosen)


def _made(sets: PlatformSets, platform: str, chosen: argparse.Namespace) -> None:
    """Make a platform's cases, and put its nominal scenario beside them."""
    folder, scenario = chosen.out / platform, sets.scenarios[platform]
    wanted = sets.orders(platform, chosen.cases, chosen.seed)[: chosen.first]
    one = partial(
        timed_make,
        seed=chosen.seed,
        data=folder / "data",
        answers=folder / "answers",
        scenario=scenario,
        made_by=sets.make,
    )
    with locked(folder / "answers", 0o700):
        (folder / "scenario.toml").write_text(scenario.read_text(encoding="utf-8"), encoding="utf-8")
        make_all(wanted, one, chosen.jobs)


def _run(sets: PlatformSets, platform: str, chosen: argparse.Namespace) -> None:
    """Diagnose a platform's cases, those that were made, without their answers."""
    folder = chosen.out / platform
    with locked(folder / "answers", 0o000):
        diagnose_all(sets.scenarios[platform], folder / "data", folder / "diagnoses", chosen.first, chosen.jobs)


def _card(sets: PlatformSets, chosen: argparse.Namespace) -> None:
    """Score what was diagnosed so far, all platforms together and each alone."""
    by_platform = {
        platform: [replace(case, name=f"{platform}/{case.name}") for case in diagnosed_sets(chosen.out / platform)]
        for platform in chosen.platforms
    }
    together = [case for cases in by_platform.values() for case in cases]
    scored = {"both": together, **by_platform}
    contents = {name: _content(sets, cases, chosen) for name, cases in scored.items() if cases}
    if together:
        print_card(score_card(together, sets.first_wanted))
    for folder in (chosen.out, DOCS) if chosen.write else (chosen.out,):
        _write(sets, contents, folder, chosen.words)


def _content(sets: PlatformSets, cases: Sequence[Case], chosen: argparse.Namespace) -> dict[str, Any]:
    names = {case.name for case in cases}
    making = Making(
        command=f"python -m {sets.module} make|run|card --cases {chosen.cases} --seed {chosen.seed}",
        seed=chosen.seed,
        where=f"Scored {here_and_now()}",
        making_seconds=_seconds(sets, chosen.out, "answers", names),
        diagnosis_seconds=_seconds(sets, chosen.out, "diagnoses", names),
    )
    return content_of(score_card(cases, sets.first_wanted), (), (), making)


def _seconds(sets: PlatformSets, out: Path, kept: str, names: set[str]) -> tuple[float, ...]:
    by_platform = {
        platform: {name.partition("/")[2] for name in names if name.startswith(f"{platform}/")}
        for platform in sets.scenarios
    }
    return tuple(each for platform, cases in by_platform.items() for each in kept_seconds(out / platform / kept, cases))


def _write(sets: PlatformSets, contents: Mapping[str, Mapping[str, Any]], folder: Path, words: str) -> None:
    numbers, text = folder / f"{sets.page}.json", folder / f"{sets.page}.md"
    numbers.write_text(json.dumps(contents, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    text.write_text(sets.text(contents, words), encoding="utf-8")
    print(f"Written to {numbers} and {text}")


def _arguments(sets: PlatformSets) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog=f"python -m {sets.module}", description="Makes, diagnoses and scores blind sets of several platforms."
    )
    parser.add_argument("stage", choices=("make", "run", "card"))
    parser.add_argument("--platforms", nargs="+", choices=tuple(sets.scenarios), default=list(sets.scenarios))
    parser.add_argument("--cases", type=int, default=sets.cases, help=f"of each platform, default {sets.cases}")
    parser.add_argument("--first", type=int, help="only so many of them, of the random order that they have")
    parser.add_argument("--seed", type=int, default=sets.seed, help=f"default {sets.seed}")
    parser.add_argument("--jobs", type=int, default=2, help="processes, default 2")
    parser.add_argument("--write", action="store_true", help="write the score card into docs/ too")
    parser.add_argument("--words", default="", help="to be said on the page, before the figures")
    parser.add_argument("--out", type=Path, help=f"default runs/{sets.page}-CASES-SEED")
    chosen = parser.parse_args()
    chosen.out = chosen.out or Path("runs") / f"{sets.page}-{chosen.cases}-{chosen.seed}"
    chosen.first = chosen.cases if chosen.first is None else chosen.first
    return chosen
