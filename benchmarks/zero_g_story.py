"""The zero-g campaign with something hidden in it: what the diagnosis names, and what leaving it out does to J.

python -m benchmarks.zero_g_story [--campaigns N]: flies the five flights of `zero_g_campaign` N times a situation, each
cut at its first contact, diagnoses them with the CAD model, and writes docs/zero-g-story.md with its picture after
every campaign. With 0, the page is written anew from what docs/zero-g-story.json holds.

What is hidden is flown by the simulator (another rotor momentum in the MJCF; the gyro's own model of its sampling), on
scenarios of which the diagnosis is shown the telemetry alone.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from itertools import count, islice
from typing import Any

import numpy as np

from benchmarks.table import DOCS, here_and_now
from benchmarks.zero_g_story_page import Outcome, draw, page
from testbed.arrays import Theta
from testbed.assembly.platform import nominal_platform, true_platform
from testbed.campaign.flights import fly_seeds
from testbed.campaign.plan import run_seed
from testbed.diagnosis.findings import stds_of
from testbed.diagnosis.method import diagnosed
from testbed.diagnosis.model import Fit
from testbed.diagnosis.reading import data_set_of
from testbed.dynamics.inertia import theta_of
from testbed.effects.registry import EFFECTS, NOISE_EFFECTS
from testbed.experiment.planning import plan_maneuver
from testbed.maneuver.maneuver import Maneuver
from testbed.records.record import Record
from testbed.records.selection import telemetry_only
from testbed.reproduction.zero_g import FLIGHTS, SCENARIO
from testbed.reproduction.zero_g_cuts import SHORTEST
from testbed.scenario.reader import read_scenario
from testbed.scenario.scenario import Scenario
from testbed.scenario.shipped import shipped_scenario

SEED = 1
CAMPAIGNS = 20
ROTOR_ERROR = 0.03
"""More momentum of unit 3 than its tachometer, and with it the servo of its speed, knows of."""
LATENCY = 0.01
"""s"""
_UNIT = 2
_AT_ONCE = 8
"""Flights; some meet the wall too soon to be used, and others take their places."""
ROWS, PAGE, PICTURE = DOCS / "zero-g-story.json", DOCS / "zero-g-story.md", DOCS / "images" / "zero_g_story.png"


@dataclass(frozen=True, kw_only=True)
class Situation:
    """Something that the flown platform has and the CAD model does not.

    Attributes:
        words: in words.
        key: effect and component; empty for nothing.
        changes: to the sections of the flown scenario.
    """

    words: str
    key: str
    changes: dict[str, dict[str, Any]]


def situations(scenario: Scenario) -> tuple[Situation, ...]:
    """Return what is hidden, each in campaigns of its own."""
    nominal = scenario.cluster.rotor_momentum_N_m_s
    momentum, shown = [nominal] * 6, [0.0] * 6
    momentum[_UNIT], shown[_UNIT] = nominal * (1.0 + ROTOR_ERROR), 1.0 / (1.0 + ROTOR_ERROR) - 1.0
    rotor = {
        "truth": {"rotor_momentum_N_m_s": tuple(momentum)},
        "tachometer": {"scale_factor_error": tuple(shown)},
    }
    return (
        Situation(words="nothing", key="", changes={}),
        Situation(words="unit 3 has 3 % more momentum", key="rotor_speed:cmg3", changes=rotor),
        Situation(words="the gyro is 10 ms late", key="gyro_latency:gyro", changes={"gyro": {"latency_s": LATENCY}}),
    )


def outcome_of(scenario: Scenario, maneuver: Maneuver, situation: Situation, campaign: int) -> Outcome:
    """Fly a campaign with something hidden in it, and diagnose it.

    Args:
        scenario: of the campaign; nothing is hidden in it yet.
        maneuver: of all flights.
        situation: what is hidden.
        campaign: number; its flights have the releases and the noise of the reproduction's campaign of that number.
    """
    nominal, truth = nominal_platform(scenario), theta_of(true_platform(scenario).inertia)
    flown = _changed(scenario, situation.changes)
    flights = list(islice(usable_flights(flown, maneuver, run_seed(SEED, campaign)), FLIGHTS))
    data = data_set_of(flights, scenario, nominal)
    *_, last = diagnosed(data.runs, data.heldout, EFFECTS, theta_of(nominal.inertia), noise_effects=NOISE_EFFECTS)
    return Outcome(
        hidden=situation.words,
        key=situation.key,
        campaign=campaign,
        verdict=last.verdict,
        named=tuple(step.placed.key for step in last.steps) + tuple(each.effect.id for each in last.scatter),
        look_alikes=tuple(each.key for each in last.steps[0].look_alikes) if last.steps else (),
        gap=(last.gap_before.fit, last.gap.fit),
        heldout_gap=(last.gap_before.heldout, last.gap.heldout),
        without=_deviations(last.baseline, truth),
        with_named=_deviations(last.model, truth),
        usable=tuple(map(usable_time, flights)),
    )


def usable_flights(flown: Scenario, maneuver: Maneuver, seed: int) -> Iterator[Record]:
    """Yield the telemetry of one flight after the other, each with the time of its first contact stated.

    Those that met the wall too soon are left out.
    """
    found = 0
    for first in count(0, _AT_ONCE):
        for flight in fly_seeds(flown, maneuver, [run_seed(seed, run) for run in range(first, first + _AT_ONCE)]):
            record = None if flight.flown is None else flight.flown.record
            if record is not None and usable_time(record) >= SHORTEST:
                found += 1
                yield replace(telemetry_only(record), details=replace(record.details, name=f"flight {found}"))


def usable_time(record: Record) -> float:
    """Return the time from the release to the first contact, or to the end, s."""
    last = record.details.usable_to
    return float(record.time[-1] if last is None else last) - float(record.time[0])


def _changed(scenario: Scenario, changes: dict[str, dict[str, Any]]) -> Scenario:
    sections = {name: getattr(scenario, name).model_copy(update=change) for name, change in changes.items()}
    return scenario.model_copy(update=sections)


def _deviations(fit: Fit, truth: Theta) -> tuple[float, ...]:
    """Return the error of every inertia parameter in the standard deviations that the fit claims."""
    return tuple(((fit.theta - truth) / stds_of(fit)[:6]).tolist())


def write(outcomes: Sequence[Outcome], measured: str) -> None:
    """Write what was found, the page and the picture."""
    rows = {"measured": measured, "outcomes": [asdict(each) for each in outcomes]}
    ROWS.write_text(json.dumps(rows, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    PAGE.write_text(page(outcomes, measured, PICTURE.relative_to(DOCS).as_posix()), encoding="utf-8")
    draw(outcomes, PICTURE)


def read() -> tuple[list[Outcome], str]:
    """Return what was found last, and when and on what."""
    rows = json.loads(ROWS.read_text(encoding="utf-8"))
    return [Outcome(**each) for each in rows["outcomes"]], rows["measured"]


def main() -> None:
    parser = argparse.ArgumentParser(description="Hide something in the zero-g campaign, and diagnose it.")
    parser.add_argument("--campaigns", type=int, default=CAMPAIGNS, help="a situation; 0 only writes the page anew")
    campaigns = parser.parse_args().campaigns
    if not campaigns:
        write(*read())
        return
    scenario = read_scenario(shipped_scenario(SCENARIO))
    maneuver, outcomes = plan_maneuver(scenario, nominal_platform(scenario)).maneuver, []
    for campaign in range(campaigns):
        for situation in situations(scenario):
            outcomes.append(outcome_of(scenario, maneuver, situation, campaign))
            print(line(outcomes[-1]), flush=True)
        write(outcomes, here_and_now())


def line(outcome: Outcome) -> str:
    """Return an outcome in a line."""
    without, with_named = (float(np.max(np.abs(each))) for each in (outcome.without, outcome.with_named))
    return (
        f"{outcome.campaign:3} {outcome.hidden:30} {outcome.verdict:12} {', '.join(outcome.named) or '-'}"
        f" (or {', '.join(outcome.look_alikes) or '-'}): gap {outcome.gap[0]:.2f} -> {outcome.gap[1]:.2f}, held out "
        f"{outcome.heldout_gap[0]:.2f} -> {outcome.heldout_gap[1]:.2f}, J off {without:.1f} -> {with_named:.1f} sigma"
    )


if __name__ == "__main__":
    main()
