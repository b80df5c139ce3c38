"""The compiled equations of motion against MuJoCo: steps, closed-loop flights, and a campaign's runs with estimates.

Run with `python -m benchmarks.engines`. Each engine flies the same seeds; how far apart they come out is in the note.
"""

from __future__ import annotations

import numpy as np

from benchmarks.flight import SCENARIOS
from benchmarks.paired import PairedTimes, paired, seconds
from benchmarks.ratios import Ratio
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
CAMPAIGN = 10_000
BLOCKS: dict[Engine, int] = {"mujoco": BLOCK_RUNS, "compiled": COMPILED_BLOCK_RUNS}


def ratios() -> list[Ratio]:
    """Return the three rows, on one core."""
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
            note=(
                f"{RUNS} runs; {CAMPAIGN:,} on two cores would take {CAMPAIGN * runs.ours / 2.0:.0f} and "
                f"{CAMPAIGN * runs.theirs / 2.0:.0f} s, without the start of their processes"
            ),
        ),
    ]


def _plan(engine: Engine) -> CampaignPlan:
    scenario = read_scenario(SCENARIOS / "gimbal_d_optimal.toml")
    scenario = scenario.model_copy(
        update={
            "simulation": scenario.simulation.model_copy(update={"engine": engine}),
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
    for row in ratios():
        print(row)
