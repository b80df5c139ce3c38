"""Effects hidden together in rigs of one axis: python -m benchmarks.rigs [--sets N] [--seed S].

The concealing engine's rig (concealing/rig.py) turns about one axis against its wheel. Of dry friction, viscous
friction, a slow wheel, late telemetry (early, where the wheel is slow too: the two would cancel) and coloured gyro
noise each set hides one to five together, each of four times the size that is detectable alone. The diagnosis has the
whole library. What was made and diagnosed is kept in OUT.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path

import numpy as np
from scipy.stats import binomtest

from benchmarks.blind_diagnosis import diagnose_case
from benchmarks.misspecified import diagnosed_sets, wrong_names
from benchmarks.table import here_and_now
from concealing.power import detectable_norm
from concealing.rig import Rig, rig_record
from concealing.sealing import SEAL, write_sealed
from concealing.sizing import hypotheses
from support.rigs import rig_scenario_text
from testbed.arrays import Array
from testbed.scoring.case import Case
from testbed.scoring.judging import named

SEED, SETS = 7700, 120
SIZE = 4.0
"""Times what is detectable alone."""
WANTED = 0.95
"""Share of sets whose first name is of the class of an effect that is hidden."""
_RUNS, _MOTION = 5, {"seconds": 12.0, "rate": 20.0, "momentum": 0.004, "fastest": 1.0}
"""Number of runs, and what moves them: some tenths of a rad/s, two hundred times the gyro's noise."""
_FIT = 3
"""Runs that are fitted; the others are held out."""
_SMALL, _ROUNDS = 1e-3, 3
"""Share of the largest size where the search for the right one begins, and its rounds."""
_INERTIA_ERROR = 0.1
"""Largest share by which the nominal inertia, 0.05 kg·m², is wrong."""


@dataclass(frozen=True, kw_only=True)
class Kind:
    """An effect of the rig.

    Attributes:
        field: of `Rig`.
        shown: the field that changes the gyro as much: late telemetry alone changes nothing but the telemetry.
        largest: size; where one that shows enough is looked for begins well below.
        effect: its name in the testbed's library.
    """

    field: str
    shown: str
    largest: float
    effect: str


KINDS = {
    "dry friction": Kind(field="dry", shown="dry", largest=0.05, effect="dry_friction"),
    "viscous friction": Kind(field="viscous", shown="viscous", largest=0.1, effect="viscous_drag"),
    "slow wheel": Kind(field="lag", shown="lag", largest=0.5, effect="actuator_lag"),
    "late telemetry": Kind(field="late", shown="delay", largest=0.3, effect="telemetry_skew"),
    "coloured noise": Kind(field="correlation", shown="correlation", largest=0.9, effect="gyro_noise_color"),
}


def rig_set(seed: int, index: int) -> tuple[list[Rig], list[int], tuple[str, ...]]:
    """Return the rig of each run, the seeds of the runs, and what is hidden in all of them."""
    rng = np.random.default_rng([seed, index])
    bare = Rig(inertia=0.05 * (1.0 + rng.uniform(-_INERTIA_ERROR, _INERTIA_ERROR)), bias=float(rng.normal(0.0, 1e-3)))
    seeds = [int(each) for each in rng.integers(2**31, size=_RUNS)]
    count = 1 + index % len(KINDS)
    names = tuple(sorted(rng.choice(list(KINDS), count, replace=False).tolist()))
    sizes = {KINDS[name].field: _sized(bare, KINDS[name], seeds[:_FIT]) for name in names}
    if {"lag", "late"} <= set(sizes):  # as late as the wheel is slow, the telemetry would be right again
        sizes["late"] *= -1.0
    return [replace(bare, **sizes)] * _RUNS, seeds, names


def _sized(bare: Rig, kind: Kind, seeds: Sequence[int]) -> float:
    """Return the size at which an effect alone shows `SIZE` times what is detectable in the fitted runs."""
    target = SIZE * detectable_norm(1, hypotheses("applied_torque"))
    if kind.field == "correlation":  # twice the gain of log likelihood is N ρ² to first order
        return float(
            min(kind.largest, target / np.sqrt(len(seeds) * (round(_MOTION["seconds"] * _MOTION["rate"]) + 1)))
        )

    size = _SMALL * kind.largest
    for _ in range(_ROUNDS):  # what is small shows in proportion
        size *= target / _signal(bare, replace(bare, **{kind.shown: size}), seeds)
    return size


def _signal(bare: Rig, other: Rig, seeds: Sequence[int]) -> float:
    """Return what an effect changes in the gyro's samples beside inertia and a constant by run, in sigma."""
    heavier = replace(bare, inertia=1.001 * bare.inertia)
    changed, inertia = ([_exact(rig, seed) - _exact(bare, seed) for seed in seeds] for rig in (other, heavier))
    centred = [np.concatenate([each - each.mean() for each in runs]) for runs in (changed, inertia)]
    rest = centred[0] - centred[1] * (centred[1] @ centred[0]) / (centred[1] @ centred[1])
    return float(np.linalg.norm(rest) / bare.noise)


@lru_cache(maxsize=100)
def _exact(rig: Rig, seed: int) -> Array:
    """Return what the gyro would show without noise, shape (N,), rad/s."""
    quiet = replace(rig, noise=1e-12, correlation=0.0)
    return rig_record(quiet, "exact", seed, **_MOTION).channels["body_rate"][:, 2]


def done(seed: int, index: int, out: Path) -> None:
    """Make and diagnose a set where that is not done yet."""
    case = f"case_{index + 1:04d}"
    data = out / "data" / case
    if not (data / SEAL).exists():
        rigs, seeds, names = rig_set(seed, index)
        records = [
            rig_record(rig, f"run_{run}", own, role="fit" if run <= _FIT else "heldout", **_MOTION)
            for run, (rig, own) in enumerate(zip(rigs, seeds, strict=True), start=1)
        ]
        answer = json.dumps(_answer(rigs[0], names), indent=1) + "\n"
        write_sealed(answer, records, data, out / "answers" / case)
    diagnose_case(out / "rig.toml", data, out / "diagnoses" / case)


def _answer(rig: Rig, names: Sequence[str]) -> Mapping[str, object]:
    effects = [
        {
            "effect": KINDS[name].effect,
            "component": "rig",
            "parameters": {KINDS[name].field: {"value": getattr(rig, KINDS[name].field)}},
        }
        for name in names
    ]
    return {"stratum": f"{len(names)} together", "effects": effects, "true_theta_kg_m2": [rig.inertia] * 3 + [0.0] * 3}


def lines(cases: Sequence[Case]) -> list[str]:
    """Return the table, a row for each number of effects hidden together and one for all."""
    rows = ["| hidden together | sets | class first | 95 % | all found | a wrong name | failed | wrong names |"]
    rows.append("|---|---|---|---|---|---|---|---|")
    for stratum in (*sorted({case.answer.stratum for case in cases}), "all"):
        chosen = [case for case in cases if stratum in (case.answer.stratum, "all")]
        first = sum(_is_first_right(case) for case in chosen)
        wrong = [list(wrong_names(case, _hidden(case))) for case in chosen]
        shares = binomtest(first, len(chosen)).proportion_ci()
        cells = (
            stratum,
            len(chosen),
            f"{first / len(chosen):.1%}",
            f"{shares.low:.1%} to {shares.high:.1%}",
            sum(_all_found(case) for case in chosen),
            sum(map(bool, wrong)),
            sum(case.diagnosis is None for case in chosen),
            ", ".join(f"`{each}`" for names in wrong for each in names) if stratum != "all" else "",
        )
        rows.append(f"| {' | '.join(map(str, cells))} |")
    return rows


def _hidden(case: Case) -> set[str]:
    return {hidden.effect for hidden in case.answer.effects}


def _is_first_right(case: Case) -> bool:
    return any(not {each.effect for each in first.alike}.isdisjoint(_hidden(case)) for first in named(case)[:1])


def _all_found(case: Case) -> bool:
    return _hidden(case) <= {each.effect for step in named(case) for each in step.alike}


def main() -> None:
    """Make, diagnose and score; print the table."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.rigs", description=__doc__.splitlines()[0])
    parser.add_argument("--sets", type=int, default=SETS, help=f"default {SETS}")
    parser.add_argument("--seed", type=int, default=SEED, help=f"default {SEED}")
    parser.add_argument("--jobs", type=int, default=2, help="processes, default 2")
    parser.add_argument("--out", type=Path, help="default runs/rigs-SEED")
    chosen = parser.parse_args()
    out: Path = chosen.out or Path("runs") / f"rigs-{chosen.seed}"
    out.mkdir(parents=True, exist_ok=True)
    (out / "rig.toml").write_text(rig_scenario_text(rate=_MOTION["rate"]), encoding="utf-8")
    with ProcessPoolExecutor(chosen.jobs) as pool:
        futures = [pool.submit(done, chosen.seed, index, out) for index in range(chosen.sets)]
        for count, future in enumerate(futures, start=1):
            future.result()
            print(f"\r{count} of {chosen.sets}", end="", flush=True)
    print(f"\n{here_and_now()}")
    print("\n".join(lines(diagnosed_sets(out))))


if __name__ == "__main__":
    main()
