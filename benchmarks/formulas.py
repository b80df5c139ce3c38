"""Torques by random formulas, hidden by the concealing engine: python -m benchmarks.formulas STAGE --seed S.

`run` makes sets (`benchmarks.formula_sets`) and diagnoses each with the whole library; `others` asks two other methods
of them (`benchmarks.formula_baselines`); `card` scores what has been done so far, with --write into docs/. What is
there already in OUT is kept: an interrupted `run` or `others` goes on where it was. `listed` diagnoses sets that hide
effects of the library, and prints what has their name.
"""

from __future__ import annotations

import argparse
import json
import shutil
import tempfile
import time
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.formula_baselines import METHODS, said_of, write_set
from benchmarks.formula_sets import SCENARIO, HiddenFormula, Said, data_of, listed_set_of, set_of
from benchmarks.formulas_page import OURS, page, rows_of
from benchmarks.table import DOCS, here_and_now
from testbed.arrays import Theta
from testbed.assembly.platform import nominal_platform
from testbed.diagnosis.fitting import fitted
from testbed.diagnosis.method import diagnosed
from testbed.diagnosis.model import Hypothesis
from testbed.diagnosis.reading import DataSet
from testbed.diagnosis.state import Diagnosis
from testbed.dynamics.inertia import theta_of
from testbed.effects.formula import Formula
from testbed.effects.registry import EFFECTS, NOISE_EFFECTS
from testbed.errors import InputError
from testbed.files import whole_file, write_json
from testbed.scenario.reader import read_scenario

SEED, SETS = 73519, 100
"""Of sets that nobody has looked at."""
_TOGETHER = 10
"""Sets of which another method is asked at once: what is done is kept then."""
_INTERVAL = 1.96
"""Standard errors to either side of a 95 % interval."""


def done(seed: int, number: int, out: Path) -> None:
    """Make and diagnose a set where that is not done yet."""
    path = out / "sets" / f"set_{number:04d}.json"
    if path.exists():
        return
    case, hidden = set_of(seed, number)
    try:
        data = data_of(case)
        state, spent = _diagnosed(data)
    except InputError as error:  # it counts as a set of which nothing is said
        _keep(path, {"hidden": asdict(hidden), "said": {OURS: asdict(Said())}, "refused": str(error), "covered": []})
        return
    with whole_file(out / "seen" / f"{path.stem}.npz") as seen:
        write_set(seen, data.runs, fitted(data.runs, [], _nominal_theta(), []))
    _keep(path, _content(state, hidden) | spent)


def _diagnosed(data: DataSet) -> tuple[Diagnosis, Mapping[str, float]]:
    """Return the diagnosis of records, and the processor time, s, that it took, and without formulas."""
    begun, formulas = time.process_time(), list[float]()

    def noted(what: str) -> None:
        if what.startswith("formulas"):
            formulas.append(time.process_time() - begun)

    *_, state = diagnosed(data.runs, data.heldout, EFFECTS, _nominal_theta(), noted, NOISE_EFFECTS)
    whole = time.process_time() - begun
    return state, {"seconds": whole, "without_formulas": formulas[0] if formulas else whole}


def _nominal_theta() -> Theta:
    return theta_of(nominal_platform(read_scenario(SCENARIO)).inertia)


def _content(state: Diagnosis, hidden: HiddenFormula) -> dict[str, Any]:
    """Return what was said of a set, against what is hidden, as JSON."""
    first = next((step for step in state.steps if isinstance(step.effect, Formula)), None)
    alike = state.rivals if first is None else tuple(map(_text, first.look_alikes))
    said = Said(named=tuple(each.key for each in state.added), alike=alike)
    return {
        "hidden": asdict(hidden),
        "said": {OURS: asdict(said)},
        "verdict": state.verdict,
        "heldout": [state.gap_before.heldout, state.gap.heldout],
        "covered": list(_covered(state, hidden)),
    }


def _text(placed: Hypothesis) -> str:
    return placed.component if isinstance(placed.effect, Formula) else placed.key


def _covered(state: Diagnosis, hidden: HiddenFormula) -> Iterator[bool]:
    """Yield whether the 95 % interval of each value of the hidden formula, where that is named, has the truth in it."""
    for placed in state.model.placed:
        if isinstance(placed.effect, Formula) and placed.component == hidden.formula:
            own = state.model.own(placed)
            stds = np.sqrt(np.diag(state.model.covariance)[6:][own])
            off = np.abs(state.model.effect_values[own] - np.array(hidden.values))
            yield from (off <= _INTERVAL * stds).tolist()


def asked(method: str, out: Path) -> None:
    """Ask another method of the sets of which it was not asked yet."""
    kept = {path.stem: json.loads(path.read_text(encoding="utf-8")) for path in sorted((out / "sets").glob("*.json"))}
    left = [name for name, content in kept.items() if method not in content["said"] and "refused" not in content]
    for first in range(0, len(left), _TOGETHER):
        with tempfile.TemporaryDirectory() as folder:
            for name in left[first : first + _TOGETHER]:
                shutil.copy(out / "seen" / f"{name}.npz", folder)
            for name, said in said_of(Path(folder), method).items():
                kept[name]["said"][method] = asdict(said)
                _keep(out / "sets" / f"{name}.json", kept[name])


def _keep(path: Path, content: Mapping[str, Any]) -> None:
    """Write what was said of a set, whole or not at all."""
    with whole_file(path) as part:
        write_json(part, content)


def main() -> None:
    """Do what the command line says."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.formulas", description=__doc__.splitlines()[0])
    parser.add_argument("stage", choices=("run", "others", "card", "listed"))
    parser.add_argument("--sets", type=int, default=SETS, help=f"default {SETS}")
    parser.add_argument("--seed", type=int, default=SEED, help=f"default {SEED}")
    parser.add_argument("--jobs", type=int, default=2, help="processes, default 2")
    parser.add_argument("--write", action="store_true", help="write the score card into docs/ too")
    parser.add_argument("--out", type=Path, help="default runs/formulas-SEED")
    chosen = parser.parse_args()
    out: Path = chosen.out or Path("runs") / f"formulas-{chosen.seed}"
    if chosen.stage == "run":
        _run(chosen.seed, chosen.sets, chosen.jobs, out)
    elif chosen.stage == "listed":
        _listed(chosen.seed, chosen.sets)
    elif chosen.stage == "others":
        for method in METHODS:
            asked(method, out)
    else:
        _card(chosen.seed, chosen.sets, out, (out, DOCS) if chosen.write else (out,))


def _run(seed: int, sets: int, jobs: int, out: Path) -> None:
    for name in ("sets", "seen"):
        (out / name).mkdir(parents=True, exist_ok=True)
    with ProcessPoolExecutor(jobs) as pool:
        futures = [pool.submit(done, seed, number, out) for number in range(1, sets + 1)]
        try:
            for count, future in enumerate(futures, start=1):
                future.result()
                print(f"{count} of {sets}", flush=True)
        except BaseException:  # what is wrong with one set is wrong with the others
            pool.shutdown(wait=False, cancel_futures=True)
            raise


def _listed(seed: int, sets: int) -> None:
    """Print what is named where an effect of the library is hidden."""
    formulas = 0
    for number in range(1, sets + 1):
        case, effect = listed_set_of(seed, number)
        state, spent = _diagnosed(data_of(case))
        named = [each.key for each in state.added]
        formulas += any(isinstance(step.effect, Formula) for step in state.steps)
        print(f"{number}: {effect}: {state.verdict}, {named}, nearly as well {list(state.rivals)}, {spent}", flush=True)
    print(f"{formulas} of {sets} sets have a formula among their names")


def _card(seed: int, sets: int, out: Path, folders: Sequence[Path]) -> None:
    """Score what was done so far, in the order in which it is done."""
    paths = [out / "sets" / f"set_{number:04d}.json" for number in range(1, sets + 1)]
    kept = [json.loads(path.read_text(encoding="utf-8")) for path in paths if path.exists()]
    content = {"seed": seed, "sets": len(kept), "where": here_and_now(), **rows_of(kept)}
    for folder in folders:
        write_json(folder / "formulas.json", content)
        (folder / "formulas.md").write_text(page(content), encoding="utf-8")
    print(page(content))


if __name__ == "__main__":
    main()
