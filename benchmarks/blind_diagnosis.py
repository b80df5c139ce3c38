"""Blind cases diagnosed: data folders in, diagnosis.json out. Nothing here knows of answers.

python -m benchmarks.blind_diagnosis SCENARIO DATA DIAGNOSES COUNT FIRST EVERY: of so many folders every so many, from
the first.
"""

from __future__ import annotations

import json
import sys
import time
import traceback
from pathlib import Path
from typing import Any

from benchmarks.blind_candidates import CANDIDATES, candidates_of
from testbed.diagnosis.detectable import first_screening
from testbed.effects.registry import NOISE_EFFECTS
from testbed.errors import InputError
from testbed.files import whole_file
from testbed.library.diagnoses import diagnose
from testbed.library.records import read_records
from testbed.library.scenarios import read_scenario

DIAGNOSIS, REFUSED, CRASHED, SECONDS = "diagnosis.json", "refused.txt", "crashed.txt", "seconds.txt"


def diagnosis_of(scenario_path: Path, data: Path) -> dict[str, Any]:
    """Return what `testbed diagnose` writes into diagnosis.json, without the page, the recording and the model.

    Args:
        scenario_path: of the nominal scenario.
        data: folder of records.

    Raises:
        InputError: the records cannot be used.
    """
    return diagnosis_and_candidates(scenario_path, data)[0]


def diagnosis_and_candidates(scenario_path: Path, data: Path) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return the diagnosis, and what its first screening compared; arguments and errors as `diagnosis_of`."""
    result = diagnose(read_scenario(scenario_path), read_records(data), propose=False)
    state, runs = result.state, result.prepared.data.runs
    return result.result, candidates_of(runs, state.baseline, first_screening(state), NOISE_EFFECTS)


def diagnose_case(scenario: Path, data: Path, folder: Path) -> Path:
    """Diagnose a case where that is not done yet; a refusal is an answer too, and its message is kept.

    What went wrong in another way is kept as well, and tried again the next time.

    Args:
        scenario: the nominal one.
        data: folder of the case's records.
        folder: for diagnosis.json with candidates.json, refused.txt or crashed.txt, and for the seconds that it took.

    Returns:
        The folder.
    """
    if not any((folder / name).exists() for name in (DIAGNOSIS, REFUSED)):
        folder.mkdir(parents=True, exist_ok=True)
        started = time.perf_counter()
        texts = _answer(scenario, data)
        _write(folder / SECONDS, f"{time.perf_counter() - started:.3f}\n")
        for name, text in texts.items():
            _write(folder / name, text)
    return folder


def _answer(scenario: Path, data: Path) -> dict[str, str]:
    """Return the files to write, that which says that a case is done at the end."""
    try:
        diagnosis, candidates = diagnosis_and_candidates(scenario, data)
    except InputError as error:
        return {REFUSED: f"{error}\n"}
    except Exception:  # one case must not end the others; it counts as a miss
        return {CRASHED: traceback.format_exc()}
    return {CANDIDATES: json.dumps(candidates) + "\n", DIAGNOSIS: json.dumps(diagnosis, indent=1) + "\n"}


def _write(path: Path, text: str) -> None:
    with whole_file(path) as part:
        part.write_text(text, encoding="utf-8")


def main() -> None:
    scenario, data, diagnoses = (Path(each) for each in sys.argv[1:4])
    count, first, every = map(int, sys.argv[4:7])
    for case in sorted(data.iterdir())[first:count:every]:
        folder = diagnose_case(scenario, case, diagnoses / case.name)
        done = next(name for name in (DIAGNOSIS, REFUSED, CRASHED) if (folder / name).exists())
        print(f"{case.name} {done} {(folder / SECONDS).read_text(encoding='utf-8').strip()} s", flush=True)


if __name__ == "__main__":
    main()
