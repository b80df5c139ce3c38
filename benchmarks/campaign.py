"""Campaigns: two cores against one, and what a run costs in time and memory as campaigns grow.

Run with `python -m benchmarks.campaign`; `python -m benchmarks.campaign RUNS` flies one campaign and prints, as JSON,
its wall time and the most memory that it can have held.
"""

from __future__ import annotations

import json
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

from benchmarks.paired import paired, seconds
from benchmarks.ratios import Ratio
from testbed.assembly.platform import nominal_platform
from testbed.campaign.local import LocalExecutor
from testbed.campaign.plan import CampaignPlan
from testbed.campaign.run import run_campaign
from testbed.campaign.statistics import statistics_of
from testbed.experiment.planning import plan_maneuver
from testbed.scenario.reader import read_scenario

SCENARIO = Path(__file__).resolve().parents[1] / "scenarios" / "basic.toml"
CORES, RUNS, PAIRS = 2, 300, 2
SIZES = (100, 1_000, 10_000)
COMMAND = "python -m benchmarks.campaign"
GIB = 2**30


def ratios() -> list[Ratio]:
    """Return the time on one core over that on two."""
    plan = campaign_plan(RUNS)
    times = paired(lambda: campaign_seconds(plan, CORES), lambda: campaign_seconds(plan, 1), PAIRS)
    return [
        Ratio(
            what=f"campaign of {RUNS} runs with four estimators: {CORES} cores against 1",
            ours=f"{times.ours:.1f} s",
            theirs=f"one core {times.theirs:.1f} s",
            ratio=times.ratio,
            target="at least 1.7",
            command=COMMAND,
            note=f"a process a core, their start included, median of {PAIRS} pairs",
        )
    ]


def size_ratios() -> list[Ratio]:
    """Return how a run's cost grows with the campaign, and the memory of the largest one against 2 GiB."""
    sizes = {runs: _measured_alone(runs) for runs in SIZES}
    smallest, largest = sizes[SIZES[0]], sizes[SIZES[-1]]
    cost = {runs: 1e3 * size["seconds"] / runs for runs, size in sizes.items()}
    peaks = ", ".join(f"{runs:,} runs {size['peak_bytes'] / GIB:.2f} GiB" for runs, size in sizes.items())
    return [
        Ratio(
            what=f"cost of a run in a campaign of {SIZES[-1]:,} over one of {SIZES[0]:,}",
            ours=f"{cost[SIZES[-1]]:.0f} ms a run",
            theirs=f"{SIZES[0]:,} runs: {cost[SIZES[0]]:.0f} ms a run",
            ratio=(largest["seconds"] / SIZES[-1]) / (smallest["seconds"] / SIZES[0]),
            target="at most 1",
            command="make bench-long",
            note="start of the processes included; " + ", ".join(f"{r:,} runs {c:.0f} ms" for r, c in cost.items()),
        ),
        Ratio(
            what=f"peak memory of a campaign of {SIZES[-1]:,} runs, share of 2 GiB",
            ours=f"{largest['peak_bytes'] / GIB:.2f} GiB",
            theirs="2 GiB",
            ratio=largest["peak_bytes"] / (2 * GIB),
            target="below 1",
            command="make bench-long",
            note=f"the campaign's own process and {CORES} times its largest worker; {peaks}",
        ),
    ]


def campaign_plan(runs: int) -> CampaignPlan:
    """Return a campaign of the paper's basic profile."""
    scenario = read_scenario(SCENARIO)
    maneuver = plan_maneuver(scenario, nominal_platform(scenario)).maneuver
    return CampaignPlan(scenario=scenario, maneuver=maneuver, seed=1, runs=runs)


def campaign_seconds(plan: CampaignPlan, workers: int) -> float:
    """Time a campaign in a folder of its own, its statistics included, as `testbed montecarlo` does it."""
    with tempfile.TemporaryDirectory() as folder:
        return seconds(
            lambda: statistics_of(run_campaign(plan, Path(folder), LocalExecutor(workers=workers))),
        )


def _measured_alone(runs: int) -> dict[str, float]:
    """Fly a campaign in a process of its own, so that the peak is its own too."""
    command = [sys.executable, "-m", "benchmarks.campaign", str(runs)]
    print(f"flying {runs:,} runs ...", flush=True)
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    measured: dict[str, float] = json.loads(done.stdout.splitlines()[-1])
    return measured


def _fly(runs: int) -> None:
    took = campaign_seconds(campaign_plan(runs), CORES)
    print(json.dumps({"seconds": took, "peak_bytes": peak_bytes(CORES)}))


def peak_bytes(workers: int) -> int:
    """Return the most memory that this process and so many workers of its can have held together."""
    own = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    largest_worker = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss
    return 1024 * (own + workers * largest_worker)


if __name__ == "__main__":
    if len(sys.argv) > 1:
        _fly(int(sys.argv[1]))
    else:
        for row in ratios():
            print(row)
