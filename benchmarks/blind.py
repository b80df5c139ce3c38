"""The blind set, diagnosed and scored: make blind, or python -m benchmarks.blind [--cases N] [--jobs 2] [--seed N].

800 cases by default, 200 of them without any effect, and 56 that MuJoCo flies; --cases N makes N, every stratum in its
share; --first N takes the first N of their random order, a fair sample. What is there already, made or diagnosed, is
kept: an interrupted run goes on where it was. Remove OUT/diagnoses to diagnose anew.

Three stages, one after the other: concealing writes OUT/data and OUT/answers; worker processes of their own
diagnose OUT/data into OUT/diagnoses, without the answers, which are locked meanwhile; the diagnoses and the
methods of `benchmarks.blind_baselines` are scored into OUT/score.json and OUT/blind.md, with --write into docs/ too.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import time
from collections.abc import Callable, Collection, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Any

from benchmarks.blind_baselines import comparisons, read_candidates
from benchmarks.blind_diagnosis import SECONDS
from benchmarks.blind_page import Making, content_of, page
from benchmarks.blind_sindy import read_labels
from benchmarks.blind_unlisted import kinds_of, read_bounds
from benchmarks.table import DOCS, here_and_now
from concealing.blind_set import Counts, make, orders
from concealing.order import Order, case_name
from concealing.sealing import SEAL
from testbed.cli.score import print_card
from testbed.scoring.card import score_card
from testbed.scoring.case import read_cases

SCENARIO = Path("scenarios/diagnose.toml")
ALL = sum(asdict(Counts()).values())
SEED = 5230
"""Of the set whose score card is kept: nobody had looked at it when it was diagnosed, unlike seeds 1, 2026 and 4102."""


def counts_of(cases: int) -> Counts:
    """Return how many cases of each stratum, in the shares of the whole set (largest remainders)."""
    exact = {name: count * cases / ALL for name, count in asdict(Counts()).items()}
    whole = {name: int(share) for name, share in exact.items()}
    left = cases - sum(whole.values())
    for name in sorted(exact, key=lambda each: whole[each] - exact[each])[:left]:
        whole[name] += 1
    return Counts(**whole)


def main() -> None:
    chosen = _arguments()
    out: Path = chosen.out
    wanted = orders(counts_of(chosen.cases), chosen.seed)[: chosen.first]
    data, answers, diagnoses = out / "data", out / "answers", out / "diagnoses"
    with locked(answers, 0o700):
        make_all(wanted, partial(timed_make, seed=chosen.seed, data=data, answers=answers), chosen.jobs)
    with locked(answers, 0o000):
        diagnose_all(SCENARIO, data, diagnoses, len(wanted), chosen.jobs)
    names = {case_name(order) for order in wanted}
    cases = [case for case in read_cases(diagnoses, answers) if case.name in names]
    card = score_card(cases)
    print_card(card)
    others = comparisons(cases, read_candidates(diagnoses, cases), read_labels(out))
    making = Making(
        command=_command(chosen),
        seed=chosen.seed,
        where=f"Scored {here_and_now()}",
        making_seconds=kept_seconds(answers, names),
        diagnosis_seconds=kept_seconds(diagnoses, names),
    )
    content = content_of(card, others, kinds_of(cases, read_bounds(out)), making)
    _write(content, out / "score.json", out / "blind.md")
    if chosen.write:
        _write(content, DOCS / "blind.json", DOCS / "blind.md")


def _command(chosen: argparse.Namespace) -> str:
    command = "make blind" if chosen.cases == ALL else f"make blind CASES={chosen.cases}"
    return command if chosen.first is None else f"{command} FIRST={chosen.first}"


def _write(content: dict[str, Any], numbers: Path, text: Path) -> None:
    numbers.write_text(json.dumps(content, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    text.write_text(page(content), encoding="utf-8")
    print(f"Written to {numbers} and {text}")


def kept_seconds(folder: Path, names: Collection[str]) -> tuple[float, ...]:
    """Return the seconds that are kept in the folders of some cases."""
    paths = [path for path in sorted(folder.glob(f"*/{SECONDS}")) if path.parent.name in names]
    return tuple(float(path.read_text(encoding="utf-8")) for path in paths)


@contextmanager
def locked(folder: Path, mode: int) -> Iterator[None]:
    """Give a folder permissions for as long as a block lasts; afterwards it can be read by its owner."""
    folder.mkdir(parents=True, exist_ok=True)
    folder.chmod(mode)
    try:
        yield
    finally:
        folder.chmod(0o700)


def make_all(wanted: Sequence[Order], make_one: Callable[[Order], None], jobs: int) -> None:
    """Make cases in processes of their own.

    Args:
        wanted: in the order of their names.
        make_one: makes a case where it is not whole yet.
        jobs: processes.
    """
    with ProcessPoolExecutor(jobs) as pool:
        made = [pool.submit(make_one, order) for order in wanted]
        for count, future in enumerate(made, start=1):
            future.result()
            print(f"\rmade {count} of {len(wanted)}", end="", flush=True)
    print()


def timed_make(
    order: Order, seed: int, data: Path, answers: Path, scenario: Path = SCENARIO, made_by: Callable[..., Path] = make
) -> None:
    """Make a case where it is not whole yet, and keep beside its answer how long that took."""
    name, started = case_name(order), time.perf_counter()
    if not (data / name / SEAL).exists():
        made_by(order, seed, scenario, data, answers)
        (answers / name / SECONDS).write_text(f"{time.perf_counter() - started:.3f}\n", encoding="utf-8")


def diagnose_all(scenario: Path, data: Path, diagnoses: Path, count: int, jobs: int) -> None:
    """Run workers until so many are done; each takes every jobs-th case, which is fair as their order is random."""
    places = (scenario, data, diagnoses)
    command = [sys.executable, "-m", "benchmarks.blind_diagnosis", *map(str, places), str(count)]
    quiet = os.environ | {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    workers = [subprocess.Popen([*command, str(first), str(jobs)], env=quiet) for first in range(jobs)]
    try:
        for worker in workers:
            worker.wait()
    finally:
        for worker in workers:
            worker.terminate()


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.blind", description=__doc__.splitlines()[0])
    parser.add_argument("--cases", type=int, default=ALL, help=f"default {ALL}")
    parser.add_argument("--first", type=int, help="only so many of them, of the random order that they have")
    parser.add_argument("--seed", type=int, default=SEED, help=f"default {SEED}")
    parser.add_argument("--jobs", type=int, default=2, help="processes, default 2")
    parser.add_argument("--write", action="store_true", help="write the score card into docs/blind.md and blind.json")
    parser.add_argument("--out", type=Path, help="default runs/blind-CASES-SEED")
    chosen = parser.parse_args()
    if chosen.out is None:
        chosen.out = Path("runs") / f"blind-{chosen.cases}-{chosen.seed}"
    return chosen


if __name__ == "__main__":
    main()
