"""Flying a scenario many times."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pyarrow as pa

from testbed.assembly.engine import engine_of, require_comparable
from testbed.assembly.platform import nominal_platform
from testbed.campaign.engine_check import EngineCheck, check_engines
from testbed.campaign.executor import Executor
from testbed.campaign.local import LocalExecutor, usable_cores
from testbed.campaign.manifest import read_manifest
from testbed.campaign.plan import CampaignPlan
from testbed.campaign.result import failures_of, unestimated_of
from testbed.campaign.run import SILENT, Progress, run_campaign
from testbed.campaign.statistics import CampaignStatistics, EstimatorStatistics, statistics_of
from testbed.errors import InputError
from testbed.experiment.planning import require_flyable_by
from testbed.library.arguments import AnyPath, Checks, GivenScenario, Runs, Seed, Switch, Text, Workers, checked
from testbed.library.notebook import Shown
from testbed.library.runs import DesignProgress, GivenManeuver, Maneuver, design, silent
from testbed.library.scenarios import naming, require_flyable
from testbed.outputs.campaign_folder import campaign_result, finish_campaign, kept_maneuver, start_campaign
from testbed.outputs.folder import reserved_folder
from testbed.outputs.provenance import Provenance, provenance
from testbed.report.campaign import campaign_page
from testbed.report.frame.blocks import Page
from testbed.report.verdict import campaign_verdict
from testbed.scenario.scenario import Scenario

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Campaign(Shown):
    """Many flights of one scenario.

    Attributes:
        plan: scenario, maneuver, seed and number of runs.
        table: one row per run, in their order.
        statistics: bias, scatter and coverage of each estimator.
        origin: what made it.
        seconds: that flying and estimating took.
        engine_check: how far apart runs come out that both engines flew; None where none were.
    """

    plan: CampaignPlan
    table: pa.Table
    statistics: CampaignStatistics
    origin: Provenance
    seconds: float
    engine_check: EngineCheck | None = None

    @property
    def estimators(self) -> Mapping[str, EstimatorStatistics]:
        """Figures of each estimator, by its name."""
        return self.statistics.estimators

    @property
    def unestimated(self) -> list[dict[str, Any]]:
        """Estimators that gave no estimate of some completed runs: name, number of runs and most frequent message."""
        return unestimated_of(self.table)

    @property
    def failures(self) -> list[dict[str, Any]]:
        """Runs that were not flown to their end: `run`, `seed` and `message` of each."""
        return failures_of(self.table)

    @property
    def result(self) -> dict[str, Any]:
        """What montecarlo.json holds, without provenance."""
        return campaign_result(self.plan, self.table, self.statistics, self.seconds, self.engine_check)

    @property
    def verdict(self) -> str:
        """Whether the estimators' intervals hold, in a sentence."""
        return campaign_verdict(self.statistics).text

    def __str__(self) -> str:
        """Return the verdict."""
        return f"{self.plan.runs} runs of {self.plan.scenario.name}, seed {self.plan.seed}. {self.verdict}"

    def to_pandas(self) -> pd.DataFrame:
        """Return a row for each run: seed, truth, bound, estimates with their standard deviations, SI."""
        return self.table.to_pandas()

    def to_xarray(self) -> xr.Dataset:
        """Return the same with the dimension `run`."""
        dataset: xr.Dataset = self.to_pandas().set_index("run").to_xarray()
        return dataset

    def _page(self) -> Page:
        path = self.plan.scenario.file.path
        return campaign_page(self.plan, path, self.table, self.statistics, self.origin.listed, {})


@checked
def monte_carlo(
    scenario: GivenScenario,
    maneuver: GivenManeuver | None = None,
    *,
    runs: Runs,
    seed: Seed | None = None,
    scheduler: Text | None = None,
    workers: Workers | None = None,
    folder: AnyPath | None = None,
    resume: Switch = False,
    check: Checks = 0,
    progress: Progress = SILENT,
) -> Campaign:
    """Fly a scenario many times, each run with its own noise and dispersions.

    In a program, call it below `if __name__ == "__main__":`, as its worker processes import the program.

    Args:
        scenario: to fly.
        maneuver: as from `design`; planned first where None.
        runs: how many, two at least.
        seed: from which every run's own seed is derived; the scenario's where None.
        scheduler: address of a Dask scheduler, tcp://host:port; this machine where None.
        workers: cores of this machine to use; all where None.
        folder: keeps the runs as they come, and page and statistics at the end; in memory only where None.
        resume: whether to go on with the campaign in the folder.
        check: how many of the runs are flown by MuJoCo and by the compiled equations, to compare.
        progress: called as runs come.

    Raises:
        InputError: an argument, the folder or the scheduler cannot be used; a folder keeps what was flown.

    Example:
        >>> import testbed as tb
        >>> campaign = tb.monte_carlo(tb.read_scenario("basic"), runs=4, seed=1, workers=1)
        >>> campaign.statistics.failed
        0
    """
    if resume and folder is None:
        raise InputError("resume goes on with a campaign in a folder: give the folder of the campaign too")
    flown = require_flyable(scenario)
    executor = executor_of(scheduler, workers)
    campaign_seed = flown.seed if seed is None else seed
    if maneuver is not None:
        with naming(flown):
            require_flyable_by(flown, nominal_platform(flown), maneuver.plan.maneuver)
    origin = origin_of(flown, campaign_seed, runs, "testbed.monte_carlo")
    if check:
        require_comparable(flown, check, runs)
    if folder is None:
        planned = design(flown) if maneuver is None else maneuver
        plan = CampaignPlan(scenario=flown, maneuver=planned.plan.maneuver, seed=campaign_seed, runs=runs)
        began = time.monotonic()
        table = run_campaign(plan, None, executor, progress)
        seconds = time.monotonic() - began
        return Campaign(
            plan=plan,
            table=table,
            statistics=statistics_of(table),
            origin=origin,
            seconds=seconds,
            engine_check=check_engines(plan, check) if check else None,
        )
    with reserved_folder(Path(folder), "montecarlo", resume=resume) as reserved:
        plan = planned_in(reserved.path, flown, maneuver, seed=campaign_seed, runs=runs, resume=resume)
        return flown_into(reserved.path, plan, origin, executor, progress, check)


def planned_in(
    folder: Path,
    scenario: Scenario,
    maneuver: Maneuver | None = None,
    *,
    seed: int,
    runs: int,
    resume: bool = False,
    progress: DesignProgress = silent,
) -> CampaignPlan:
    """Begin a campaign in a folder, or take up the one that is there: its maneuver is not designed again.

    Args:
        folder: reserved for the campaign.
        scenario: to fly.
        maneuver: as from `design`; designed here where None.
        seed: from which every run's own seed is derived.
        runs: how many.
        resume: whether to go on with the campaign in the folder.
        progress: called with each start of a design as it ends.

    Raises:
        InputError: the folder cannot be written, or holds no campaign to go on with.
    """
    if resume:
        reference = kept_maneuver(folder, scenario)
    else:
        planned = design(scenario, progress=progress) if maneuver is None else maneuver
        start_campaign(folder, scenario.file, planned.plan)
        reference = planned.plan.maneuver
    return CampaignPlan(scenario=scenario, maneuver=reference, seed=seed, runs=runs)


def flown_into(
    folder: Path, plan: CampaignPlan, origin: Provenance, executor: Executor, progress: Progress, check: int = 0
) -> Campaign:
    """Fly what a folder does not hold yet of a campaign, and write its statistics and its page.

    Args:
        folder: reserved for the campaign, which `planned_in` has begun.
        plan: of the campaign.
        origin: what makes it.
        executor: gets the blocks flown.
        progress: called as runs come.
        check: how many of the runs are flown by both engines, to compare.

    Raises:
        InputError: the folder cannot be written, or is another campaign's.
    """
    table = run_campaign(plan, folder, executor, progress)
    statistics = statistics_of(table)
    compared = check_engines(plan, check) if check else None
    finish_campaign(folder, plan.scenario.file, origin, plan, table, statistics, compared)
    return Campaign(
        plan=plan,
        table=table,
        statistics=statistics,
        origin=origin,
        seconds=read_manifest(folder).seconds,
        engine_check=compared,
    )


def executor_of(scheduler: str | None, workers: int | None) -> Executor:
    """Return what flies the runs: this machine's cores, or a Dask cluster.

    Raises:
        InputError: both are given, Dask is not installed, or the scheduler has no workers.
    """
    if scheduler is None:
        return LocalExecutor(workers=usable_cores() if workers is None else workers)
    if workers is not None:
        raise InputError(
            "workers counts processes on this machine; a scheduler has workers of its own: omit one of the two"
        )
    try:
        from testbed.campaign.dask_executor import DaskExecutor  # noqa: PLC0415 - its library is optional
    except ImportError as error:
        raise InputError("a scheduler needs Dask: pip install 'testbed[cluster]'") from error
    cluster = DaskExecutor(address=scheduler)
    cluster.require_workers()
    return cluster


def origin_of(scenario: Scenario, seed: int, runs: int, command: str) -> Provenance:
    """Return the provenance of a campaign.

    Raises:
        InputError: the scenario asks for an engine that does not cover its platform.
    """
    with naming(scenario):
        engine = engine_of(scenario, many=True)
    return provenance(
        scenario, scenario.file, command, deciding={"seed": str(seed), "runs": str(runs), "engine": engine}
    )
