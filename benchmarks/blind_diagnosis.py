"""A blind case diagnosed: the data folder in, diagnosis.json out. Nothing here knows of answers."""

from __future__ import annotations

import json
import time
from pathlib import Path
from typing import Any

from testbed.assembly.platform import nominal_platform
from testbed.diagnosis.findings import noise_notices
from testbed.diagnosis.location import located
from testbed.diagnosis.plausibility import require_explicable
from testbed.diagnosis.reading import data_set_of
from testbed.diagnosis.result import result_of
from testbed.diagnosis.workflow import diagnosed
from testbed.dynamics.inertia import theta_of
from testbed.effects.registry import EFFECTS, READING_EFFECTS
from testbed.errors import InputError
from testbed.files import whole_file
from testbed.records.reading import read_data_set
from testbed.scenario.reader import read_scenario

DIAGNOSIS, REFUSED, SECONDS = "diagnosis.json", "refused.txt", "seconds.txt"


def diagnosis_of(scenario_path: Path, data: Path) -> dict[str, Any]:
    """Return what `testbed diagnose` writes into diagnosis.json, without the page, the recording and the model.

    Args:
        scenario_path: of the nominal scenario.
        data: folder of records.

    Raises:
        InputError: the records cannot be used.
    """
    scenario = read_scenario(scenario_path)
    nominal = nominal_platform(scenario)
    records = data_set_of(read_data_set(data), scenario, nominal)
    *_, last = diagnosed(
        records.runs, records.heldout, EFFECTS, theta_of(nominal.inertia), reading_effects=READING_EFFECTS
    )
    require_explicable(last.runs, last.gap_before.fit, last.gap.fit)
    return result_of(last, located(last.runs, last.baseline), (*records.notices, *noise_notices(last)))


def diagnose_case(scenario: Path, data: Path, folder: Path) -> Path:
    """Diagnose a case where that is not done yet; a refusal is an answer too, and its message is kept.

    Args:
        scenario: the nominal one.
        data: folder of the case's records.
        folder: for diagnosis.json, or refused.txt, and for the seconds that it took.

    Returns:
        The folder.
    """
    if not any((folder / name).exists() for name in (DIAGNOSIS, REFUSED)):
        folder.mkdir(parents=True, exist_ok=True)
        started = time.perf_counter()
        name, text = _answer(scenario, data)
        _write(folder / SECONDS, f"{time.perf_counter() - started:.3f}\n")
        _write(folder / name, text)
    return folder


def _answer(scenario: Path, data: Path) -> tuple[str, str]:
    try:
        return DIAGNOSIS, json.dumps(diagnosis_of(scenario, data), indent=1) + "\n"
    except InputError as error:
        return REFUSED, f"{error}\n"


def _write(path: Path, text: str) -> None:
    with whole_file(path) as part:
        part.write_text(text, encoding="utf-8")
