"""The blind set, diagnosed and scored: make blind, or python -m benchmarks.blind [--cases N] [--jobs 2] [--seed 1].

800 cases by default, 200 of them without any effect; --cases N makes N, every stratum in its share. What is there
already, made or diagnosed, is kept: an interrupted run goes on where it was. Remove OUT/diagnoses to diagnose anew.

Three stages, one after the other: tests/concealing writes OUT/data and OUT/answers; worker processes of their own
diagnose OUT/data into OUT/diagnoses, told nothing of the answers, which are locked meanwhile; `testbed score` compares.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path

from benchmarks.blind_diagnosis import SECONDS
from testbed.cli.score import print_card, write_card
from testbed.scoring.card import score_card
from testbed.scoring.case import read_cases
from tests.concealing.blind_set import Counts, Order, make, orders

SCENARIO = Path("scenarios/diagnose.toml")
ALL = sum(asdict(Counts()).values())


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
    wanted = orders(counts_of(chosen.cases), chosen.seed)
    data, answers, diagnoses = out / "data", out / "answers", out / "diagnoses"
    with locked(answers, 0o700):
        _make(wanted, chosen.seed, data, answers, chosen.jobs)
    with locked(answers, 0o000):
        _diagnose(data, diagnoses, chosen.jobs)
    card = score_card(read_cases(diagnoses, answers))
    print_card(card)
    seconds = sorted(float(path.read_text(encoding="utf-8")) for path in diagnoses.glob(f"*/{SECONDS}"))
    print(f"\nA diagnosis took {seconds[len(seconds) // 2]:.1f} s in the median, {seconds[-1]:.1f} s at most")
    write_card(card, out / "score.json")
    print(f"Written to {out / 'score.json'}; seed {chosen.seed}, {len(wanted)} cases")


@contextmanager
def locked(folder: Path, mode: int) -> Iterator[None]:
    """Give a folder permissions for as long as a block lasts; afterwards it can be read by its owner."""
    folder.mkdir(parents=True, exist_ok=True)
    folder.chmod(mode)
    try:
        yield
    finally:
        folder.chmod(0o700)


def _make(wanted: list[Order], seed: int, data: Path, answers: Path, jobs: int) -> None:
    with ProcessPoolExecutor(jobs) as pool:
        made = [pool.submit(make, order, seed, SCENARIO, data, answers) for order in wanted]
        for count, future in enumerate(made, start=1):
            future.result()
            print(f"\rmade {count} of {len(wanted)}", end="", flush=True)
    print()


def _diagnose(data: Path, diagnoses: Path, jobs: int) -> None:
    """Run workers until all are done; each takes every jobs-th case, which is fair as their order is random."""
    command = [sys.executable, "-m", "benchmarks.blind_diagnosis", str(SCENARIO), str(data), str(diagnoses)]
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
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=2, help="processes, default 2")
    parser.add_argument("--out", type=Path, help="default runs/blind-CASES-SEED")
    chosen = parser.parse_args()
    if chosen.out is None:
        chosen.out = Path("runs") / f"blind-{chosen.cases}-{chosen.seed}"
    return chosen


if __name__ == "__main__":
    main()
