"""How long a diagnosis takes: python -m benchmarks.diagnosis.

Five flights of six CMGs with all their telemetry and a late gyro in them: at 16 Hz, and at 100 Hz for 5 s each; three
flights of a CubeSat with four wheels; and a real quadcopter's. Then one screening against the number of samples and of
hypotheses. Processor time of one process; set OMP_NUM_THREADS=1. Outputs are left aside, and so is what importing and
loading machine code takes: a small diagnosis, not timed, comes first.
"""

from __future__ import annotations

import tempfile
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from benchmarks.blind_diagnosis import diagnosis_of
from benchmarks.paired import processor_seconds
from concealing.case import Case, Telemetry
from concealing.effect import GYRO, HiddenEffect
from concealing.files import conceal
from concealing.strata import bare_case
from concealing.wheel_case import WheelCase, WheelRun
from concealing.wheel_set import conceal_wheels
from testbed.assembly.platform import nominal_platform
from testbed.diagnosis.fitting import fitted
from testbed.diagnosis.model import Hypothesis
from testbed.diagnosis.reading import DataSet, data_set_of
from testbed.diagnosis.screening import screened
from testbed.diagnosis.testable import hypotheses
from testbed.dynamics.inertia import theta_of
from testbed.effects.registry import EFFECTS
from testbed.records.reading import read_data_set
from testbed.scenario.reader import read_scenario

SCENARIO = Path("scenarios/diagnose.toml")
RUNS = 5
LATE = HiddenEffect(effect="gyro_latency", component=GYRO, parameters={"delay": 2e-3})
WANTED = {16.0: 3.0, 100.0: 5.0}
"""Seconds that a diagnosis may take, by the gyro's rate in Hz."""
SMALL = (16.0, 2.5)
"""Rate, Hz, and duration, s, of the flights that are diagnosed first."""
CUBESAT = Path("scenarios/cubesat_wheels.toml")
CUBESAT_SECONDS, CUBESAT_WANTED = (40.0, 50.0, 60.0), 15.0
"""How long its flights are, and how long a diagnosis of them may take, s."""
QUADCOPTER, QUADCOPTER_DATA = Path("scenarios/crazyflie.toml"), Path("data/crazyflie")
QUADCOPTER_WANTED = 45.0
"""s."""
DURATIONS = (1.25, 2.5, 5.0)
SHARES = (0.25, 0.5, 1.0)


def five_flights(rate: float, duration: float) -> Case:
    """Return five flights, each with a maneuver of its own.

    Args:
        rate: of the gyro, Hz.
        duration: of each flight, s.
    """
    case = bare_case(np.random.default_rng(1), SCENARIO, "cmg", LATE.effect)
    flights = [replace(case.runs[0], duration=duration, maneuver=index) for index in range(RUNS)]
    telemetry = Telemetry(gyro_rate=rate, encoder_noise=1e-4, encoder_step=0.0)
    return replace(case, runs=tuple(flights), telemetry=telemetry, feedback=True, effects=(LATE,))


def cubesat_flights() -> WheelCase:
    """Return flights of a CubeSat whose gyro is late, each with a motion of its own."""
    flights = [WheelRun(duration=seconds, motion=index) for index, seconds in enumerate(CUBESAT_SECONDS)]
    return WheelCase(scenario=CUBESAT, seed=1, runs=tuple(flights), effects=(LATE,))


def screening_seconds(data: DataSet, theta: np.ndarray, share: float) -> tuple[int, int, float]:
    """Return the samples, the hypotheses, and the seconds of one screening with a share of all hypotheses."""
    testable, _ = hypotheses(data.runs, EFFECTS)
    chosen: list[Hypothesis] = testable[:: round(1.0 / share)]
    fit = fitted(data.runs, [], theta, [])
    return len(fit.residual), len(chosen), processor_seconds(lambda: screened(data.runs, data.heldout, fit, chosen))


def main() -> None:
    """Print seconds of whole diagnoses, then of screenings."""
    scenario = read_scenario(SCENARIO)
    nominal = nominal_platform(scenario)
    with tempfile.TemporaryDirectory() as folder:
        conceal(five_flights(*SMALL), Path(folder) / "small", Path(folder) / "small answers")
        diagnosis_of(SCENARIO, Path(folder) / "small")
        for rate, wanted in WANTED.items():
            data = Path(folder) / f"{rate:.0f}"
            conceal(five_flights(rate, 5.0), data, Path(folder) / "answers")
            taken = processor_seconds(partial(diagnosis_of, SCENARIO, data))
            print(f"{RUNS} runs of 5 s at {rate:3.0f} Hz: {taken:5.1f} s (wanted: under {wanted:.0f} s)", flush=True)
        data = Path(folder) / "cubesat"
        conceal_wheels(cubesat_flights(), data, Path(folder) / "answers of the cubesat")
        taken = processor_seconds(partial(diagnosis_of, CUBESAT, data))
        print(f"{len(CUBESAT_SECONDS)} runs of a CubeSat: {taken:5.1f} s (wanted: under {CUBESAT_WANTED:.0f} s)")
        taken = processor_seconds(partial(diagnosis_of, QUADCOPTER, QUADCOPTER_DATA))
        print(f"{QUADCOPTER_DATA}: {taken:5.1f} s (wanted: under {QUADCOPTER_WANTED:.0f} s)", flush=True)
        print("\n samples  hypotheses  screening s", flush=True)
        sizes = [(duration, 1.0) for duration in DURATIONS] + [(DURATIONS[-1], share) for share in SHARES[:-1]]
        for duration, share in sizes:
            data = Path(folder) / f"screening-{duration}"
            if not data.exists():
                conceal(five_flights(100.0, duration), data, Path(folder) / "answers")
            records = data_set_of(read_data_set(data), scenario, nominal)
            samples, tested, seconds = screening_seconds(records, theta_of(nominal.inertia), share)
            print(f"{samples:8d}  {tested:10d}  {seconds:11.2f}", flush=True)


if __name__ == "__main__":
    main()
