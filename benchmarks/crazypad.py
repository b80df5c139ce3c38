"""What the diagnosis names in the flights of a quadcopter with known defects, its healthy flights being the reference.

Run with `python -m benchmarks.crazypad`, or with names of the folders in data/crazypad that are to be diagnosed. The
healthy records that are fitted are the reference; those held out are diagnosed like the defective ones, so that
nothing should be new in them.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.linalg import eigvalsh

from testbed.dynamics.inertia import inertia_of
from testbed.library.diagnoses import DiagnosisResult, diagnose
from testbed.library.records import Records
from testbed.records.reading import read_data_set
from testbed.records.record import Record
from testbed.scenario.reader import read_body_scenario
from testbed.scenario.shipped import shipped_scenario

DATA = Path(__file__).resolve().parents[1] / "data" / "crazypad"
HEALTHY = "normal"
TRUE = {
    HEALTHY: "nothing is new",
    "propeller_3_cut_3_mm": "actuator_weak:3",
    "tape_on_propeller_3": "an effect of actuator 3",
    "weight_between_motors_3_4": "thrust_offset, towards +y",
}
"""What is known of each folder."""


def main() -> None:
    """Print a row for each folder."""
    for name in sys.argv[1:] or TRUE:
        result = diagnosed(name)
        print(f"{name}: {result.verdict}; known: {TRUE[name]}")
        for line in lines_of(result):
            print(f"    {line}", flush=True)


def diagnosed(name: str) -> DiagnosisResult:
    """Return the diagnosis of a folder against the healthy flights that are fitted.

    Args:
        name: of a folder in data/crazypad.
    """
    healthy = [record for record in read_data_set(DATA / HEALTHY) if record.details.role == "fit"]
    scenario = read_body_scenario(shipped_scenario("crazypad"))
    return diagnose(scenario, Records(suspect_records(name)), reference=Records(tuple(healthy)), propose=False)


def suspect_records(name: str) -> tuple[Record, ...]:
    """Return the records of a folder; of the healthy one those that are held out, dealt to both roles anew."""
    records = read_data_set(DATA / name)
    if name != HEALTHY:
        return records
    held_out = [record for record in records if record.details.role == "heldout"]
    return tuple(replace(record, details=replace(record.details, role=None)) for record in held_out)


def lines_of(result: DiagnosisResult) -> Iterator[str]:
    """Yield names with their classes, the inertia's ratios to the nominal one, and probabilities."""
    for step in result.steps:
        alike = ", ".join(f"{each.effect.id}:{each.component}" for each in step.look_alikes)
        yield f"{step!r}{f', indistinguishable from {alike}' if alike else ''}"
    state = result.state
    ratios = eigvalsh(inertia_of(state.model.theta), inertia_of(state.nominal_theta))
    yield f"inertia over nominal {np.array2string(ratios, precision=2)}"
    likely = sorted(result.probabilities.items(), key=lambda item: -item[1])[:3]
    yield "; ".join(f"{explanation} {probability:.3f}" for explanation, probability in likely)


if __name__ == "__main__":
    main()
