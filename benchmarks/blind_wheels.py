"""The blind sets of craft with wheels: python -m benchmarks.blind_wheels make|run|card --seed S --cases N.

Two sets of N cases, three in ten without an effect: `cubesat_wheels`, which flies freely, and `air_bearing`, which
stands on a ball joint; --platforms takes one of them. `make` writes OUT/PLATFORM/data and answers, `run` diagnoses the
data into OUT/PLATFORM/diagnoses while the answers are locked, `card` scores what has been diagnosed so far into
OUT/card.json and blind-wheels.md, with --write into docs/ too. What is there already is kept: an interrupted `make` or
`run` goes on where it was; --first N takes the first N of the random order, a fair sample.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from benchmarks.blind import diagnose_all, kept_seconds, locked, make_all, timed_make
from benchmarks.blind_page import Making, confusion, content_of, figures, opening
from benchmarks.misspecified import diagnosed_sets
from benchmarks.table import DOCS, here_and_now
from concealing.wheel_set import make_wheels, wheel_orders
from testbed.cli.score import print_card
from testbed.scoring.card import score_card
from testbed.scoring.case import Case

PLATFORMS = ("cubesat_wheels", "air_bearing")
SEED, CASES = 7717, 100
"""Of a set that nobody has looked at, and cases of each platform."""
_HEAD = """# The blind set of craft with wheels

Written by `python -m benchmarks.blind_wheels card --write`; do not edit. Each figure is explained in
[scoring.md](scoring.md).

    python -m benchmarks.blind_wheels make          # 100 cases of each platform into runs/, with their sealed answers
    python -m benchmarks.blind_wheels run           # diagnoses them; both can be interrupted, and go on where they were
    python -m benchmarks.blind_wheels card --write  # scores what has been diagnosed so far into this page

The concealing engine flies a CubeSat with four wheels, `cubesat_wheels`, freely, and a table on a ball bearing under
gravity, `air_bearing`, by equations, formulas and a reader of its own: no MJCF, no code of the testbed but the records'
writer. Wheel speeds follow a plan of the nominal platform, open-loop. An effect is hidden at two or four times its
smallest detectable size; three cases in ten have none. What can be hidden: the effects of the published table that sit
in no gimbal, dry friction, coloured noise, late telemetry; a wheel's inertia, axis and tachometer, the friction of its
bearing, its motor's torque and lag, its imbalance; and on the bearing the centre of mass and the air. Appendages and
loose masses are not: these slow turns hardly excite them.

"""


def scenario_of(platform: str) -> Path:
    return Path("scenarios") / f"{platform}.toml"


def made(platform: str, chosen: argparse.Namespace) -> None:
    """Make a platform's cases."""
    folder = chosen.out / platform
    wanted = wheel_orders(scenario_of(platform), chosen.cases, chosen.seed)[: chosen.first]
    one = partial(
        timed_make,
        seed=chosen.seed,
        data=folder / "data",
        answers=folder / "answers",
        scenario=scenario_of(platform),
        made_by=make_wheels,
    )
    with locked(folder / "answers", 0o700):
        make_all(wanted, one, chosen.jobs)


def run(platform: str, chosen: argparse.Namespace) -> None:
    """Diagnose a platform's cases, those that were made, without their answers."""
    folder = chosen.out / platform
    with locked(folder / "answers", 0o000):
        diagnose_all(scenario_of(platform), folder / "data", folder / "diagnoses", chosen.first, chosen.jobs)


def card(chosen: argparse.Namespace) -> None:
    """Score what was diagnosed so far, both platforms together and each alone."""
    by_platform = {
        platform: [replace(case, name=f"{platform}/{case.name}") for case in diagnosed_sets(chosen.out / platform)]
        for platform in chosen.platforms
    }
    together = [case for cases in by_platform.values() for case in cases]
    scored = {"both": together, **by_platform}
    contents = {name: _content(cases, chosen) for name, cases in scored.items() if cases}
    if together:
        print_card(score_card(together))
    for folder in (chosen.out, DOCS) if chosen.write else (chosen.out,):
        _write(contents, folder, chosen.words)


def _content(cases: Sequence[Case], chosen: argparse.Namespace) -> dict[str, Any]:
    names = {case.name for case in cases}
    making = Making(
        command=f"python -m benchmarks.blind_wheels make|run|card --cases {chosen.cases} --seed {chosen.seed}",
        seed=chosen.seed,
        where=f"Scored {here_and_now()}",
        making_seconds=_seconds(chosen.out, "answers", names),
        diagnosis_seconds=_seconds(chosen.out, "diagnoses", names),
    )
    return content_of(score_card(cases), (), (), making)


def _seconds(out: Path, kept: str, names: set[str]) -> tuple[float, ...]:
    by_platform = {
        platform: {name.partition("/")[2] for name in names if name.startswith(f"{platform}/")}
        for platform in PLATFORMS
    }
    return tuple(each for platform, cases in by_platform.items() for each in kept_seconds(out / platform / kept, cases))


def _write(contents: Mapping[str, Mapping[str, Any]], folder: Path, words: str) -> None:
    numbers, text = folder / "blind-wheels.json", folder / "blind-wheels.md"
    numbers.write_text(json.dumps(contents, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    text.write_text(page(contents, words), encoding="utf-8")
    print(f"Written to {numbers} and {text}")


def page(contents: Mapping[str, Mapping[str, Any]], words: str = "") -> str:
    """Return the page.

    Args:
        contents: of score cards, by platform, that of both first.
        words: what is to be said before the figures.
    """
    lines = [words, ""] if words else []
    for name, content in contents.items():
        title = "Both platforms" if name == "both" else f"`{name}`"
        lines += [f"## {title}\n", *opening(content), "", *figures(content), "", *confusion(content), ""]
    return _HEAD + "\n".join(lines).rstrip() + "\n"


def main() -> None:
    chosen = _arguments()
    if chosen.stage == "card":
        card(chosen)
        return
    for platform in chosen.platforms:
        (made if chosen.stage == "make" else run)(platform, chosen)


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.blind_wheels", description=__doc__.splitlines()[0])
    parser.add_argument("stage", choices=("make", "run", "card"))
    parser.add_argument("--platforms", nargs="+", choices=PLATFORMS, default=list(PLATFORMS))
    parser.add_argument("--cases", type=int, default=CASES, help=f"of each platform, default {CASES}")
    parser.add_argument("--first", type=int, help="only so many of them, of the random order that they have")
    parser.add_argument("--seed", type=int, default=SEED, help=f"default {SEED}")
    parser.add_argument("--jobs", type=int, default=2, help="processes, default 2")
    parser.add_argument("--write", action="store_true", help="write the score card into docs/ too")
    parser.add_argument("--words", default="", help="to be said on the page, before the figures")
    parser.add_argument("--out", type=Path, help="default runs/blind-wheels-CASES-SEED")
    chosen = parser.parse_args()
    chosen.out = chosen.out or Path("runs") / f"blind-wheels-{chosen.cases}-{chosen.seed}"
    chosen.first = chosen.cases if chosen.first is None else chosen.first
    return chosen


if __name__ == "__main__":
    main()
