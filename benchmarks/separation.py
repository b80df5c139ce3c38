"""Indistinguishable effects: an ambiguous diagnosis, the flight that it proposes, and the diagnosis with its record.

python -m benchmarks.separation [NAME ...]: each situation is hidden by the concealing engine, diagnosed with the whole
library, and the proposed scenario is flown by the engine on the hidden craft as often as the proposal says. The wanted
distance is that of the proposal; what is realised is the root of the difference of evidence, in sigma.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from math import sqrt
from pathlib import Path

from concealing.case import Case, Run, Telemetry
from concealing.effect import HiddenEffect
from concealing.files import conceal
from support.next_flights import next_record
from testbed.assembly.platform import nominal_platform
from testbed.diagnosis.method import diagnosed
from testbed.diagnosis.reading import data_set_of
from testbed.diagnosis.state import Diagnosis
from testbed.dynamics.inertia import theta_of
from testbed.effects.registry import EFFECTS, NOISE_EFFECTS
from testbed.next_experiment.proposal import Proposal, proposal_of
from testbed.next_experiment.scenario import write_next
from testbed.records.reading import read_data_set
from testbed.records.writing import write_record
from testbed.report.diagnosis.next import distance_words, flight_words, pair_words
from testbed.scenario.reader import read_scenario

SCENARIO = Path(__file__).resolve().parents[1] / "scenarios" / "diagnose.toml"
RUNS, SECONDS = 3, 3.0
"""Of each situation before the proposed flight; all from rest, at 16 Hz."""


def _vector(name: str, *values: float) -> dict[str, float]:
    return {f"{name}_{axis}": value for axis, value in zip("xyz", values, strict=True)}


SITUATIONS = {
    "quadratic or linear drag": HiddenEffect(
        effect="quadratic_drag", component="platform", parameters=_vector("coefficient", 2.2e-4, 2.2e-4, 2.2e-4)
    ),
    "latency or bandwidth": HiddenEffect(effect="gyro_latency", component="gyro", parameters={"delay": 0.016}),
    "one unit or the opposite one": HiddenEffect(
        effect="rotor_speed", component="cmg3", parameters={"relative_error": 0.008}
    ),
    "body or inertial torque": HiddenEffect(
        effect="body_torque", component="platform", parameters=_vector("torque", 2.4e-5, 1.8e-5, -1.8e-5)
    ),
    "gyro scale or inertia": HiddenEffect(effect="gyro_scale", component="x", parameters={"scale_factor_error": 0.03}),
}


@dataclass(frozen=True, kw_only=True, eq=False)
class Outcome:
    """One situation.

    Attributes:
        before: diagnosis of the runs from rest.
        proposal: of the next flight; None where the diagnosis asked for none.
        after: diagnosis with the proposed flights; None where none was flown.
        seconds: of processor time that the proposal took.
    """

    before: Diagnosis
    proposal: Proposal | None
    after: Diagnosis | None
    seconds: float


def case_of(hidden: HiddenEffect, seed: int) -> Case:
    """Return a case of runs from rest with one effect, its inertia a few percent from the nominal one."""
    return Case(
        scenario=SCENARIO,
        seed=seed,
        runs=tuple(Run(duration=SECONDS, maneuver=index) for index in range(RUNS)),
        effects=(hidden,),
        theta_error=(3e-4, -5e-4, 4e-4, 1e-4, -1e-4, 5e-5),
        telemetry=Telemetry(gimbal_torque=False, rate_command=False, encoder_noise=1e-4, encoder_step=0.0),
    )


def distinguished(
    hidden: HiddenEffect, folder: Path, seed: int = 5, effects: Sequence[str] = tuple(EFFECTS)
) -> Outcome:
    """Hide an effect, diagnose, fly what is proposed on the hidden craft, add its records, and diagnose again.

    Args:
        hidden: the effect.
        folder: new, for records, answer and the proposed scenario.
        seed: of the case.
        effects: ids that the diagnosis knows.
    """
    case = case_of(hidden, seed)
    conceal(case, folder / "data", folder / "answer")
    before = _diagnosed(folder / "data", effects)
    began = time.process_time()
    scenario = read_scenario(SCENARIO)
    proposal = proposal_of(before, scenario)
    seconds = time.process_time() - began
    if proposal is None or proposal.flight is None:
        return Outcome(before=before, proposal=proposal, after=None, seconds=seconds)
    proposed = read_scenario(write_next(scenario, proposal.flight, "Distinguishes the effects.", folder / "next"))
    for number in range(1, proposal.times + 1):
        write_record(next_record(case, proposed, number), folder / "data" / f"next_{number}.csv")
    return Outcome(before=before, proposal=proposal, after=_diagnosed(folder / "data", effects), seconds=seconds)


def realised(diagnosis: Diagnosis, rival: str) -> float:
    """Return how far the first effect is ahead of a rival: the root of the difference of evidence; NaN if it is not."""
    compared = diagnosis.steps[0].screening.candidates if diagnosis.steps else ()
    behind = {
        each.placed.key: diagnosis.steps[0].candidate.log_bayes_factor - each.log_bayes_factor for each in compared
    }
    return sqrt(max(behind[rival], 0.0)) if rival in behind else float("nan")


def _diagnosed(data: Path, effects: Sequence[str]) -> Diagnosis:
    scenario = read_scenario(SCENARIO)
    nominal = nominal_platform(scenario)
    records = data_set_of(read_data_set(data), scenario, nominal)
    known = {name: EFFECTS[name] for name in effects}
    *_, last = diagnosed(records.runs, records.heldout, known, theta_of(nominal.inertia), noise_effects=NOISE_EFFECTS)
    return last


def _names(diagnosis: Diagnosis) -> str:
    named = ", ".join(step.placed.key for step in diagnosis.steps)
    alike = sorted({other.key for step in diagnosis.steps for other in step.look_alikes})
    return f"{diagnosis.verdict}: {named or '-'}" + (f" or {', '.join(alike)}" if alike else "")


def main() -> None:
    parser = argparse.ArgumentParser(description="Fly what diagnoses propose, and diagnose again.")
    parser.add_argument("names", nargs="*", help=f"of {', '.join(SITUATIONS)}")
    for name in parser.parse_args().names or SITUATIONS:
        if name not in SITUATIONS:
            sys.exit(f"{name}: no such situation; there are {', '.join(SITUATIONS)}")
        with tempfile.TemporaryDirectory() as folder:
            outcome = distinguished(SITUATIONS[name], Path(folder))
        print(f"\n{name}: {SITUATIONS[name].effect} ({SITUATIONS[name].component}) is hidden")
        print(f"  before  {_names(outcome.before)}")
        if outcome.proposal is not None:
            print(f"  next    {flight_words(outcome.proposal)} ({outcome.seconds:.1f} s)")
            for each in outcome.proposal.separations:
                print(f"          {pair_words(each)}: {distance_words(each)}")
        if outcome.after is not None and outcome.proposal is not None:
            print(f"  after   {_names(outcome.after)}")
            rivals = {key for each in outcome.proposal.separations for key in each.keys}
            ahead = {rival: realised(outcome.after, rival) for rival in sorted(rivals)}
            for rival, distance in ahead.items():
                if distance > 0.0:  # neither the first itself nor one that was not worth a refit
                    print(f"          ahead of {rival} by {distance:.1f} sigma", flush=True)


if __name__ == "__main__":
    main()
