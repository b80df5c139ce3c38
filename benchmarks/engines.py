"""The compiled equations of motion against MuJoCo: steps, flights, runs with estimates; and a whole campaign by them.

Run with `python -m benchmarks.engines`. Each engine flies the same seeds; how far apart they come out is in the note.
`python -m benchmarks.engines campaign` flies a campaign of 10,000 runs on two cores and on one, their processes' start
included. `python -m benchmarks.engines fly RUNS CORES` flies one, and prints its times and memory as JSON.
"""

from __future__ import annotations

import json
import resource
import subprocess
import sys
from dataclasses import dataclass, replace

import numpy as np

from benchmarks.campaign import campaign_seconds, peak_bytes
from benchmarks.flight import SCENARIOS
from benchmarks.paired import PairedTimes, paired, seconds
from benchmarks.ratios import Ratio
from testbed.assembly.engine import with_engine
from testbed.assembly.platform import nominal_platform, true_plant
from testbed.campaign.engine_check import check_engines
from testbed.campaign.flights import fly_seeds
from testbed.campaign.plan import BLOCK_RUNS, COMPILED_BLOCK_RUNS, Block, CampaignPlan, run_seed
from testbed.campaign.rows import block_rows
from testbed.experiment.planning import plan_maneuver
from testbed.plant.plant import Engine
from testbed.scenario.reader import read_scenario

COMMAND = "python -m benchmarks.engines"
STEPS, RUNS, CHECKED, PAIRS = 400, 100, 5, 3
ESTIMATORS = ("iv_momentum", "output_error")
CAMPAIGN, CORES = 10_000, 2
ALLOWED_SECONDS, ALLOWED_BYTES = 60.0, 1.5e9
CAMPAIGN_COMMAND = f"{COMMAND} campaign"
BLOCKS: dict[Engine, int] = {"mujoco": BLOCK_RUNS, "compiled": COMPILED_BLOCK_RUNS}


def ratios() -> list[Ratio]:
    """Return the rows of steps, flights and runs, on one core."""
    plans = {engine: _plan(engine) for engine in BLOCKS}
    apart = check_engines(plans["mujoco"], CHECKED).largest_difference
    note = f"body rates of {CHECKED} runs within {apart:.1e} rad/s; one core, median of {PAIRS} pairs"
    steps, flights, runs = _step_times(plans), _flight_times(plans), _run_times(plans)
    return [
        Ratio(
            what=f"steps of {BLOCK_RUNS} platforms with six gyros, compiled against MuJoCo's RK4 at the same step",
            ours=f"{1e6 * steps.ours:.2f} µs a step",
            theirs=f"MuJoCo {1e6 * steps.theirs:.2f} µs a step",
            ratio=steps.ratio,
            target="at least 10",
            command=COMMAND,
            note=note,
        ),
        Ratio(
            what="closed-loop flights of gimbal_d_optimal, compiled against MuJoCo, records included",
            ours=f"{1e3 * flights.ours:.1f} ms a flight",
            theirs=f"MuJoCo {1e3 * flights.theirs:.1f} ms a flight",
            ratio=flights.ratio,
            target="at least 5",
            command=COMMAND,
            note=f"{COMPILED_BLOCK_RUNS} and {BLOCK_RUNS} side by side, NumPy's controller for all of them at once",
        ),
        Ratio(
            what="the same, estimated by momentum form and output error",
            ours=f"{1e3 * runs.ours:.1f} ms a run",
            theirs=f"MuJoCo {1e3 * runs.theirs:.1f} ms a run",
            ratio=runs.ratio,
            target="at least 3",
            command=COMMAND,
            note=f"{RUNS} runs, one core",
        ),
    ]


def campaign_ratios() -> list[Ratio]:
    """Return the time of 10,000 runs against a minute, their memory against 1.5 GB, and two cores against one."""
    whole, alone = _flown_alone(CORES), _flown_alone(1)
    spent = whole.processor_seconds / CAMPAIGN
    return [
        Ratio(
            what=f"campaign of {CAMPAIGN:,} runs of gimbal_d_optimal, momentum form and output error, {CORES} cores",
            ours=f"{whole.seconds:.0f} s",
            theirs=f"{ALLOWED_SECONDS:.0f} s",
            ratio=ALLOWED_SECONDS / whole.seconds,
            target="at least 1",
            command=CAMPAIGN_COMMAND,
            note=f"processes' start included; a run takes {1e3 * spent:.1f} ms of processor time",
        ),
        Ratio(
            what="its peak memory, share of 1.5 GB",
            ours=f"{whole.peak_bytes / 1e9:.2f} GB",
            theirs="1.5 GB",
            ratio=whole.peak_bytes / ALLOWED_BYTES,
            target="below 1",
            command=CAMPAIGN_COMMAND,
            note=f"the campaign's own process and {CORES} times its largest worker",
        ),
        Ratio(
            what=f"the same campaign: {CORES} cores against 1",
            ours=f"{whole.seconds:.1f} s",
            theirs=f"one core {alone.seconds:.1f} s",
            ratio=alone.seconds / whole.seconds,
            target="at least 1.8",
            command=CAMPAIGN_COMMAND,
            note="a process a core, their start included; on a machine with other work cores are not what is had",
        ),
    ]


@dataclass(frozen=True, kw_only=True)
class _Flown:
    """A campaign that was flown in a process of its own.

    Attributes:
        seconds: by the clock.
        processor_seconds: of its process and all workers.
        peak_bytes: the most that these can have held.
    """

    seconds: float
    processor_seconds: float
    peak_bytes: int


def _flown_alone(workers: int) -> _Flown:
    command = [sys.executable, "-m", "benchmarks.engines", "fly", str(CAMPAIGN), str(workers)]
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    return _Flown(**json.loads(done.stdout.splitlines()[-1]))


def _fly(runs: int, workers: int) -> None:
    """Fly a campaign as `testbed montecarlo` does, from the plan on, and print what it took."""
    plan = replace(_plan("compiled"), runs=runs)
    before = _processor_seconds()
    took = campaign_seconds(plan, workers)
    spent = _processor_seconds() - before
    print(json.dumps({"seconds": took, "processor_seconds": spent, "peak_bytes": peak_bytes(workers)}))


def _processor_seconds() -> float:
    """Return what this process and those of its that have ended have had of the processors, s."""
    used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(each.ru_utime + each.ru_stime for each in used)


def _plan(engine: Engine) -> CampaignPlan:
    scenario = with_engine(read_scenario(SCENARIOS / "gimbal_d_optimal.toml"), engine)
    scenario = scenario.model_copy(
        update={
            "estimation": scenario.estimation.model_copy(update={"estimators": ESTIMATORS}),
            "maneuver": scenario.maneuver.model_copy(update={"starts": 1}),  # one is as good to fly
        }
    )
    maneuver = plan_maneuver(scenario, nominal_platform(scenario)).maneuver
    return CampaignPlan(scenario=scenario, maneuver=maneuver, seed=1, runs=RUNS)


def _step_times(plans: dict[Engine, CampaignPlan]) -> PairedTimes:
    """Time steps of the plants alone, s a step of a platform."""
    scenario = plans["mujoco"].scenario
    flown = [(scenario, nominal_platform(scenario))] * BLOCK_RUNS

    def step(engine: Engine) -> float:
        plant = true_plant(flown, engine=engine)
        return seconds(lambda: plant.advance(np.full(plant.gimbal_rate.shape, 1e-5), STEPS)) / (STEPS * BLOCK_RUNS)

    return paired(lambda: step("compiled"), lambda: step("mujoco"), PAIRS)


def _flight_times(plans: dict[Engine, CampaignPlan]) -> PairedTimes:
    """Time flights and their records, s each."""

    def flights(engine: Engine) -> float:
        plan, seeds = plans[engine], range(BLOCKS[engine])
        return seconds(lambda: fly_seeds(plan.scenario, plan.maneuver, seeds)) / len(seeds)

    return paired(lambda: flights("compiled"), lambda: flights("mujoco"), PAIRS)


def _run_times(plans: dict[Engine, CampaignPlan]) -> PairedTimes:
    """Time a campaign's runs in the blocks that a worker gets, s each."""

    def runs(engine: Engine) -> float:
        plan, length = plans[engine], BLOCKS[engine]
        blocks = [
            Block(index=0, first=first, seeds=tuple(run_seed(plan.seed, first + run) for run in range(length)))
            for first in range(0, RUNS, length)
        ]
        return seconds(lambda: [block_rows(plan, block) for block in blocks]) / RUNS

    return paired(lambda: runs("compiled"), lambda: runs("mujoco"), PAIRS)


if __name__ == "__main__":
    match sys.argv[1:]:
        case ["fly", runs, workers]:
            _fly(int(runs), int(workers))
        case ["campaign"]:
            for row in campaign_ratios():
                print(row)
        case _:
            for row in ratios():
                print(row)
