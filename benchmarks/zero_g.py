"""Table 3 over many campaigns: estimate, coverage, start-up; the search for contacts, and what a late cut does.

Run with `python -m benchmarks.zero_g [CAMPAIGNS] [PROCESSES]`.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace

import numpy as np

from testbed.arrays import Array
from testbed.assembly.estimators import estimation_settings
from testbed.assembly.platform import PlatformModel, nominal_platform
from testbed.assembly.telemetry import telemetry_of
from testbed.campaign.plan import run_seed
from testbed.dynamics.inertia import PARAMETER_NAMES
from testbed.errors import InputError
from testbed.estimation.combine import CombinedEstimate, combined
from testbed.estimation.contact import first_contact
from testbed.estimation.estimate import Estimate, EstimationSettings
from testbed.estimation.registry import ESTIMATORS
from testbed.estimation.telemetry import Telemetry
from testbed.maneuver.maneuver import Maneuver
from testbed.records.selection import sampled
from testbed.reproduction.zero_g import FLIGHTS, PAPER_THETA, SCENARIO, Table3, table3
from testbed.reproduction.zero_g_coverage import coverage_of
from testbed.reproduction.zero_g_flights import CutFlight, fly_campaigns
from testbed.scenario.reader import read_scenario
from testbed.scenario.scenario import Scenario
from testbed.scenario.shipped import shipped_scenario

SEED = 1
LATE_CAMPAIGNS = 20
LATE_SAMPLES = (0, 1, 2, 4, 1000)
"""Used after the contact began; the last stands for a record that is never cut."""
TOUCHES = (2.0, 3.0, 4.0, 5.0, 6.0, 8.0)
"""Steps of the body rate, in standard deviations of the gyro."""


def main() -> None:
    """Print every figure."""
    campaigns = int(sys.argv[1]) if len(sys.argv) > 1 else 200
    processes = int(sys.argv[2]) if len(sys.argv) > 2 else 1
    started = time.perf_counter()
    table = table3(campaigns, SEED, processes=processes)
    print(f"{campaigns} campaigns of {FLIGHTS} flights in {time.perf_counter() - started:.0f} s on {processes} core(s)")
    print(f"columns {', '.join(PARAMETER_NAMES)}; 1e-3 kg m2")
    print_table(table)
    print_coverage(table)
    scenario = read_scenario(shipped_scenario(SCENARIO))
    print_contacts(scenario, table.maneuver)


def print_table(table: Table3) -> None:
    """Print the campaign shown, as Table 3."""
    print(f"{'paper':24}{_row(1e3 * PAPER_THETA, 3)}")
    print(f"{'CAD':24}{_row(1e3 * table.cad_theta, 3)}")
    for name, estimate in table.combined.items():
        print(f"{name:24}{_row(1e3 * estimate.theta, 3)}\n{'  ±':24}{_row(1e3 * estimate.std, 3)}")
        print(f"{'  error / std':24}{_row((estimate.theta - table.true_theta) / estimate.std, 2)}")
    usable = ", ".join(f"{flight.usable:.2f}" for flight in table.flights)
    print(f"usable: {usable} s; held out {table.heldout.usable:.2f} s")
    figure = table.figure6
    print(
        f"figure 6, rms misfit: {figure.estimated_misfit:.2%} with the estimate, {figure.nominal_misfit:.2%} with CAD"
    )


def print_coverage(table: Table3) -> None:
    """Print how the averages of all campaigns lie about the truth, and how their flights were cut."""
    for name, coverage in table.coverage.items():
        print(name)
        print(f"{'  mean error':24}{_row(1e3 * coverage.mean_error, 4)}")
        print(f"{'  scatter':24}{_row(1e3 * coverage.std, 4)}")
        print(f"{'  claimed':24}{_row(1e3 * coverage.claimed_std, 4)}")
        print(f"{'  95 % intervals hold':24}{_row(coverage.share, 3)}  all {coverage.overall_share:.3f}")
        for bound, share in zip(("from", "to"), coverage.share_band.T, strict=True):
            print(f"{'  ... ' + bound:24}{_row(share, 3)}")
    low, middle, high = np.percentile(table.usable, [5, 50, 95])
    print(f"{table.cuts}\nusable: 90 % within {low:.2f} to {high:.2f} s, median {middle:.2f} s")


def print_contacts(scenario: Scenario, maneuver: Maneuver) -> None:
    """Print what late cuts do to the averages of some campaigns, and how gentle a touch is found in their flights."""
    seeds = [run_seed(SEED, campaign) for campaign in range(LATE_CAMPAIGNS)]
    campaigns = [campaign.flights for campaign in fly_campaigns(scenario, maneuver, seeds, FLIGHTS)]
    nominal = nominal_platform(scenario)
    settings = estimation_settings(scenario, nominal, maneuver)
    for samples in LATE_SAMPLES:
        cut = [[cut_late(flight, samples, scenario, nominal) for flight in flights] for flights in campaigns]
        for name in ("iv", "output_error"):
            averages = [average for flights in cut if (average := _average(name, flights, settings))]
            errors = np.array([each.theta for each in averages]) - PAPER_THETA
            print(f"cut {samples} samples late, {name}: {len(averages)} of {len(cut)} campaigns give an estimate")
            print(f"{'  rms error':24}{_row(1e3 * np.sqrt(np.mean(errors**2, axis=0)), 3)}")
            print(f"{'  95 % intervals hold':24}{coverage_of(averages, PAPER_THETA).overall_share:8.2f}")
    free = [flight.telemetry for flights in campaigns for flight in flights]
    for touch in TOUCHES:
        early, late = (_found(free, touch, after, settings) for after in (slice(8, 24), slice(24, None)))
        print(f"touch of {touch:.0f} standard deviations: found {early:.0%} from 0.5 to 1.5 s, {late:.0%} later")


def cut_late(flight: CutFlight, samples: int, scenario: Scenario, nominal: PlatformModel) -> Telemetry:
    """Return the telemetry as if the cut had come so many samples after the contact began, by the truth."""
    time, _ = sampled(flight.record, "body_rate")
    free = len(time) if flight.onset is None else int(np.searchsorted(time, flight.onset))
    last = float(time[min(free + samples, len(time)) - 1])
    record = replace(flight.record, details=replace(flight.record.details, usable_to=last))
    return telemetry_of(record, scenario, nominal)


def _average(name: str, flights: Sequence[Telemetry], settings: EstimationSettings) -> CombinedEstimate | None:
    estimates: list[Estimate] = []
    for telemetry in flights:
        with suppress(InputError):  # a record that goes on behind the wall may fit nothing
            estimates.append(ESTIMATORS[name](telemetry, settings))
    return combined(estimates) if estimates else None


def _found(flights: Sequence[Telemetry], touch: float, part: slice, settings: EstimationSettings) -> float:
    """Put a step into a part of each free flight, and return the share found from a sample before to three after it."""
    rng = np.random.default_rng(SEED)
    found = 0
    for telemetry in flights:
        time, direction = telemetry.gyro_time, rng.standard_normal(3)
        first = int(rng.choice(np.arange(len(time) - 4)[part]))
        rate = telemetry.body_rate.copy()
        rate[first:] += touch * telemetry.gyro_noise * direction / np.linalg.norm(direction)
        contact = first_contact(replace(telemetry, body_rate=rate), settings.nominal_theta)
        found += contact is not None and time[first - 1] <= contact.first_seen <= time[first + 3]
    return found / len(flights)


def _row(values: Array, digits: int) -> str:
    return "  ".join(f"{value:8.{digits}f}" for value in values)


if __name__ == "__main__":
    main()
