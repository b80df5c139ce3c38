"""SINDy on the blind set: python -m benchmarks.blind_sindy OUT [COUNT], after `make blind`; which then scores it too.

With COUNT, on the first so many cases only, which are in random order; it is scored on those.

The nominal model is fitted to the fit runs of a case as the diagnosis fits it. What is left of the body rate, and what
each hypothesis would change it by, linearised, go to pysindy in an environment of its own under build/, which
differentiates both, multiplies by the inertia, and regresses the residual torque sparsely on the hypotheses' torques
(`foreign/sindy_terms.py`). The hypothesis whose terms stay and are the largest is what SINDy says first; none where no
term stays. Nothing here knows of answers. What is there already in OUT/sindy is kept.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np

from benchmarks.environments import environment
from testbed.assembly.platform import nominal_platform
from testbed.diagnosis.fitting import fitted
from testbed.diagnosis.reading import data_set_of
from testbed.diagnosis.screening import most_telling
from testbed.diagnosis.signatures import signatures
from testbed.diagnosis.testable import hypotheses
from testbed.dynamics.inertia import theta_of
from testbed.effects.registry import EFFECTS
from testbed.errors import InputError
from testbed.records.reading import read_data_set
from testbed.scenario.reader import read_scenario
from testbed.scoring.formats import place_key

SCENARIO = Path("scenarios/diagnose.toml")
SCRIPT = Path(__file__).with_name("foreign") / "sindy_terms.py"
REQUIREMENT = "pysindy==2.1.0"
LABELS = "sindy"
_TOGETHER = 20
"""Cases for which pysindy is started once."""
_JOBS = 2


def read_labels(out: Path) -> dict[str, str]:
    """Return what SINDy said first, by case; empty where it was not run."""
    return {path.stem: path.read_text(encoding="utf-8").strip() for path in sorted((out / LABELS).glob("case_*.txt"))}


def write_terms(data: Path, path: Path) -> None:
    """Write what is left of a case's body rates and what each hypothesis would make of them, for SINDy.

    Args:
        data: folder of the case's records.
        path: of an npz: `inertia` (3, 3), kg·m²; `terms`, the hypothesis of every column; of each run r `time_r` (N,),
            s, `residual_r` (N, 3), rad/s, and `columns_r` (N, 3, K), rad/s per unit of each parameter.

    Raises:
        InputError: the records cannot be used.
    """
    scenario = read_scenario(SCENARIO)
    nominal = nominal_platform(scenario)
    runs = data_set_of(read_data_set(data), scenario, nominal).runs
    fit = fitted(runs, [], theta_of(nominal.inertia), [])
    best = [each for each in most_telling(list(signatures(runs, fit, hypotheses(runs, EFFECTS)[0]))) if each.rank]
    terms = [signature.placed.key for signature in best for _ in range(signature.columns.shape[1])]
    columns = np.hstack([np.zeros((len(fit.residual), 0)), *(signature.columns for signature in best)])
    together = np.hstack([fit.residual[:, None], columns])
    arrays = {}
    for index, (whitened, sigma) in enumerate(zip(runs.by_run(together), runs.sigma, strict=True)):
        part = whitened * sigma[:, None]
        arrays |= {f"residual_{index}": part[..., 0], f"columns_{index}": part[..., 1:]}
        arrays[f"time_{index}"] = runs.grid.runs[index].gyro_time
    np.savez(path, inertia=nominal.inertia, terms=np.array(terms, dtype=str), **arrays)


def label_cases(python: Path, cases: tuple[Path, ...], labels: Path) -> int:
    """Ask SINDy of some cases, and keep what it said as LABELS/CASE.txt; return how many could be asked of."""
    with tempfile.TemporaryDirectory() as folder:
        for case in cases:
            try:
                write_terms(case, Path(folder) / f"{case.name}.npz")
            except InputError:
                continue  # refused by the diagnosis as well
        done = subprocess.run([str(python), str(SCRIPT), folder], check=True, capture_output=True, text=True)
    said = [line.split() for line in done.stdout.splitlines()]
    for name, label in said:
        (labels / f"{name}.txt").write_text(f"{place_key(label)}\n", encoding="utf-8")
    return len(said)


def main() -> None:
    out, count = Path(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else None
    python, labels = environment("sindy-venv", REQUIREMENT), out / LABELS
    labels.mkdir(exist_ok=True)
    left = [case for case in sorted((out / "data").iterdir())[:count] if not (labels / f"{case.name}.txt").exists()]
    shares = [tuple(left[first : first + _TOGETHER]) for first in range(0, len(left), _TOGETHER)]
    with ProcessPoolExecutor(_JOBS) as pool:
        asked = [pool.submit(label_cases, python, cases, labels) for cases in shares]
        print(f"{sum(future.result() for future in asked)} of {len(left)} cases asked of SINDy; kept in {labels}")


if __name__ == "__main__":
    main()
