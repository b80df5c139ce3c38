"""Oscillating effects hidden at a multiple of the size that a null set's report states for their own frequency.

`python -m benchmarks.own_frequency [--sets N] [--seed S] [--multiple 2]`. A set without effect is flown and diagnosed;
its diagnosis.json states, frequency by frequency, the smallest size of an appendage and of slosh that it would have
shown, about the axis that shows it least. Then the same flights are flown with new noise and one of the two in them: of
a frequency drawn evenly on a logarithmic scale over the stated ones, with a damping and a direction drawn as those of
the blind sets, of the multiple of the size that stands in that report. What is there already is kept.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import binomtest

from benchmarks.blind_diagnosis import DIAGNOSIS, diagnose_case
from benchmarks.table import here_and_now
from concealing.case import Case
from concealing.effect import HiddenEffect
from concealing.files import conceal
from concealing.library import LISTED
from concealing.nominal import DivergedError
from concealing.sealing import SEAL
from concealing.strata import bare_case
from support.diagnosed_records import SCENARIO
from testbed.effects.slosh import ARM
from testbed.scoring.case import Case as Scored
from testbed.scoring.case import read_cases
from testbed.scoring.judging import named

SEED, SETS, MULTIPLE, WANTED = 6600, 200, 2.0, 0.95
EFFECTS = {"flexible_appendage": ("inertia", "inertia_kg_m2"), "slosh": ("mass", "mass_kg")}
"""What of each is hidden, and as what the report states it."""
PER_REPORT = 8
"""Sets with an effect to one report of a set without."""
_DRAWS = 10
"""Effects drawn for a set until one flies: at some stated sizes more would swing than the platform holds."""


@dataclass(frozen=True, kw_only=True)
class Row:
    """How often one effect was found.

    Attributes:
        effect: its id.
        sets: with it.
        found: in which a named effect's class has it.
        first: in which the first name's has.
        low: of the share found, 95 % interval (Clopper and Pearson, 1934).
        high: of the same.
        missed: frequency, Hz, and name of what was said instead.
    """

    effect: str
    sets: int
    found: int
    first: int
    low: float
    high: float
    missed: tuple[tuple[float, str], ...]


def null_case(seed: int, report: int) -> Case:
    """Return a set without effect, of gimbals whose angles or momentum are recorded."""
    rng = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(report,)))
    return bare_case(rng, SCENARIO, "cmg", None)


def stated_sizes(report: Mapping[str, Any], effect: str) -> tuple[list[float], list[float]]:
    """Return frequencies, Hz, and the smallest sizes that a diagnosis.json states at them.

    Args:
        report: content of the file.
        effect: id.
    """
    (table,) = (each["by_frequency"] for each in report["detectable"] if each["effect"] == effect)
    shown = [each["smallest"] for each in table if each["smallest"]]
    name = EFFECTS[effect][1]
    return [each["frequency_hz"]["value"] for each in shown], [each[name]["value"] for each in shown]


def case_of(seed: int, index: int, attempt: int, report: Mapping[str, Any], multiple: float) -> Case:
    """Return the flights of a report's set with an effect and new noise.

    Args:
        seed: of all sets.
        index: of the set.
        attempt: at drawing an effect that flies.
        report: content of the diagnosis.json of the same flights without effect.
        multiple: of the size that stands in it for the effect's frequency.
    """
    rng = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(index // PER_REPORT, index, attempt)))
    effect = tuple(EFFECTS)[index % len(EFFECTS)]
    frequencies, sizes = stated_sizes(report, effect)
    place = rng.uniform(*np.log(np.array(frequencies)[[0, -1]]))
    size = multiple * float(np.exp(np.interp(place, np.log(frequencies), np.log(sizes))))
    parameters = {**LISTED[effect].draw(rng), "frequency": float(np.exp(place)), EFFECTS[effect][0]: size}
    if effect == "slosh":  # a mass is stated on the arm of the report
        arm = np.array([parameters[f"place_{axis}"] for axis in "xyz"])
        arm *= ARM / np.linalg.norm(arm)
        parameters |= {f"place_{axis}": float(value) for axis, value in zip("xyz", arm, strict=True)}
    hidden = HiddenEffect(effect=effect, component="platform", parameters=parameters)
    case = null_case(seed, index // PER_REPORT)
    return replace(case, seed=int(rng.integers(2**62)), effects=(hidden,), stratum="single")


def done(seed: int, report: int, sets: Sequence[int], multiple: float, out: Path) -> None:
    """Make and diagnose a set without effect, and those with one in its flights; what is done is kept."""
    name = f"case_{report + 1:04d}"
    bare = out / "bare"
    if not (bare / "data" / name / SEAL).exists():
        conceal(null_case(seed, report), bare / "data" / name, bare / "answers" / name)
    folder = diagnose_case(SCENARIO, bare / "data" / name, bare / "diagnoses" / name)
    stated = json.loads((folder / DIAGNOSIS).read_text(encoding="utf-8"))
    for index in sets:
        name = f"case_{index + 1:04d}"
        for attempt in range(_DRAWS):
            if (out / "data" / name / SEAL).exists():
                break
            try:
                conceal(case_of(seed, index, attempt, stated, multiple), out / "data" / name, out / "answers" / name)
            except DivergedError:
                continue
        diagnose_case(SCENARIO, out / "data" / name, out / "diagnoses" / name)


def row_of(effect: str, cases: Sequence[Scored]) -> Row:
    """Return how often an effect was found in the sets in which it is hidden."""
    own = [case for case in cases if case.answer.effects[0].effect == effect]
    classes = [[{step.effect, *(each.effect for each in step.alike)} for step in named(case)] for case in own]
    found = [any(effect in each for each in of_case) for of_case in classes]
    first = sum(bool(of_case) and effect in of_case[0] for of_case in classes)
    interval = binomtest(sum(found), len(own)).proportion_ci() if own else None
    missed = tuple(
        (case.answer.effects[0].parameters["frequency_hz"].value, ", ".join(step.key for step in named(case)))
        for case, shown in zip(own, found, strict=True)
        if not shown
    )
    return Row(
        effect=effect,
        sets=len(own),
        found=sum(found),
        first=first,
        low=0.0 if interval is None else float(interval.low),
        high=1.0 if interval is None else float(interval.high),
        missed=missed,
    )


def main() -> None:
    chosen = _arguments()
    out: Path = chosen.out or Path("runs") / f"own-frequency-{chosen.seed}"
    reports = [
        (first // PER_REPORT, range(first, min(first + PER_REPORT, chosen.sets)))
        for first in range(0, chosen.sets, PER_REPORT)
    ]
    with ProcessPoolExecutor(chosen.jobs) as pool:
        futures = [pool.submit(done, chosen.seed, *each, chosen.multiple, out) for each in reports]
        for count, future in enumerate(futures, start=1):
            future.result()
            print(f"\r{count} of {len(reports)} reports", end="", flush=True)
    print()
    cases = read_cases(out / "diagnoses", out / "answers")
    rows = [row_of(effect, cases) for effect in EFFECTS]
    found, sets = (sum(getattr(row, name) for row in rows) for name in ("found", "sets"))
    interval = binomtest(found, sets).proportion_ci()
    for row in rows:
        print(f"{row.effect}: found in {row.found} of {row.sets}, first in {row.first}")
        for frequency, words in row.missed:
            print(f"  missed at {frequency:.2f} Hz: {words or 'no name'}")
    print(
        f"at {chosen.multiple:g} times the size stated for its frequency, found in {found} of {sets}: "
        f"{found / sets:.1%} ({interval.low:.1%} to {interval.high:.1%}; wanted {WANTED:.0%})"
    )
    content = {
        "seed": chosen.seed,
        "multiple": chosen.multiple,
        "where": here_and_now(),
        "rows": list(map(asdict, rows)),
    }
    (out / "own_frequency.json").write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition(" A set")[0])
    parser.add_argument("--sets", type=int, default=SETS, help=f"with an effect, default {SETS}")
    parser.add_argument("--seed", type=int, default=SEED, help=f"default {SEED}")
    parser.add_argument("--multiple", type=float, default=MULTIPLE, help=f"of the stated size, default {MULTIPLE:g}")
    parser.add_argument("--jobs", type=int, default=2, help="processes, default 2")
    parser.add_argument("--out", type=Path, help="default runs/own-frequency-SEED")
    return parser.parse_args()


if __name__ == "__main__":
    main()
