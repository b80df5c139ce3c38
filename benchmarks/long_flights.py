"""Diagnoses of long flights with nothing hidden: python -m benchmarks.long_flights [SCENARIO] [--seconds S].

The shipped scenario is flown longer than its maneuver, its telemetry is slower than its controller, and nothing is
hidden: whatever is named is wrong. With --shapes only the test for torques of known shapes is timed, of the nominal
model.
"""

from __future__ import annotations

import argparse
import tempfile
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from benchmarks.blind_diagnosis import diagnosis_of
from benchmarks.paired import processor_seconds
from testbed.assembly.platform import nominal_platform, true_platform
from testbed.diagnosis.detectable import INERTIA
from testbed.diagnosis.fitting import fitted
from testbed.diagnosis.latent import on_all_runs
from testbed.diagnosis.misfit import misfit_of
from testbed.diagnosis.reading import data_set_of
from testbed.diagnosis.torque_shapes import torque_shapes
from testbed.dynamics.inertia import theta_of
from testbed.experiment.flying import fly_maneuver
from testbed.experiment.planning import plan_maneuver
from testbed.records.reading import read_data_set
from testbed.records.selection import telemetry_only
from testbed.records.writing import write_record
from testbed.scenario.reader import read_scenario
from testbed.scenario.scenario import Scenario
from testbed.scenario.shipped import shipped_scenario

SEED = 71001
"""Of the first flight; the next ones follow."""


def main() -> None:
    """Fly, diagnose, and print what was said and how long it took."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenario", nargs="?", default="cubesat_wheels")
    parser.add_argument("--seconds", type=float, default=75.0, help="of each flight")
    parser.add_argument("--rate", type=float, default=5.0, help="of the telemetry, Hz")
    parser.add_argument("--gyro-rate", type=float, help="Hz; that of the telemetry where it is not given")
    parser.add_argument("--flights", type=int, default=3)
    parser.add_argument("--shapes", action="store_true", help="time the test for torques of known shapes alone")
    chosen = parser.parse_args()
    path = shipped_scenario(chosen.scenario)
    scenario = _longer(read_scenario(path), chosen.seconds, chosen.rate, chosen.gyro_rate or chosen.rate)
    with tempfile.TemporaryDirectory() as folder:
        data = Path(folder) / "data"
        data.mkdir()
        _fly(scenario, data, chosen.flights)
        print(_shapes(scenario, data) if chosen.shapes else _diagnosis(path, data))


def _longer(scenario: Scenario, seconds: float, rate: float, gyro_rate: float) -> Scenario:
    simulation = scenario.simulation.model_copy(update={"duration_s": seconds, "telemetry_rate_hz": rate})
    gyro = scenario.gyro.model_copy(update={"sample_rate_hz": gyro_rate})
    return scenario.model_copy(update={"simulation": simulation, "gyro": gyro})


def _fly(scenario: Scenario, data: Path, flights: int) -> None:
    nominal = nominal_platform(scenario)
    maneuver = plan_maneuver(scenario, nominal).maneuver
    for number in range(flights):
        record = fly_maneuver(scenario, nominal, true_platform(scenario), maneuver, SEED + number).record
        named = replace(record, details=replace(record.details, name=f"run{number}"))
        write_record(telemetry_only(named), data / f"run{number}.parquet")


def _diagnosis(scenario: Path, data: Path) -> str:
    found: list[dict[str, Any]] = []
    seconds = processor_seconds(lambda: found.append(diagnosis_of(scenario, data)))
    named = ", ".join(
        f"{each['effect']}:{each['component']}" for each in found[0]["steps"] if each["effect"] != INERTIA
    )
    return f"{found[0]['verdict']}: {named or 'no name'}; {seconds:.0f} s"


def _shapes(scenario: Scenario, data: Path) -> str:
    nominal = nominal_platform(scenario)
    content = data_set_of(list(read_data_set(data)), scenario, nominal)
    fit = fitted(content.runs, [], theta_of(nominal.inertia), [])
    seconds = processor_seconds(partial(torque_shapes, *on_all_runs(content.runs, content.heldout, fit)))
    misfit = misfit_of(content.runs, fit)
    gap = f"chi square of the gyro's samples {misfit.chi_square:.0f} of {misfit.expected:.0f} expected"
    return f"{gap}; torques of known shapes {seconds:.1f} s"


if __name__ == "__main__":
    main()
