"""testbed montecarlo: many runs of one scenario, in statistics."""

from __future__ import annotations

from pathlib import Path

from testbed.assembly.platform import nominal_platform
from testbed.campaign.executor import Executor
from testbed.campaign.local import LocalExecutor, usable_cores
from testbed.campaign.plan import CampaignPlan
from testbed.campaign.result import failures_of
from testbed.campaign.run import run_campaign
from testbed.campaign.statistics import CampaignStatistics, statistics_of
from testbed.cli.campaign_progress import campaign_progress
from testbed.cli.console import command_line, design_progress, say, show, warn
from testbed.cli.failures import COMPLETED, INTERRUPTED, naming
from testbed.cli.notices import print_verdict
from testbed.cli.tables import statistics_table
from testbed.delivery.campaign_folder import finish_campaign, kept_maneuver, start_campaign
from testbed.delivery.folder import reserved_folder
from testbed.delivery.provenance import provenance
from testbed.errors import InputError
from testbed.experiment.planning import plan_maneuver, starts_of
from testbed.files import TextFile
from testbed.maneuver.maneuver import Maneuver
from testbed.report.verdict import campaign_verdict
from testbed.scenario.reader import scenario_file, scenario_of
from testbed.scenario.scenario import Scenario

_MOST_LISTED = 5


def run_montecarlo(
    path: Path,
    runs: int,
    seed: int | None,
    out: Path | None,
    *,
    resume: bool,
    scheduler: str | None,
    workers: int | None,
) -> int:
    """Fly a campaign, write its folder as it goes, print its statistics; returns the exit code.

    Raises:
        InputError: the scenario, the folder, or the scheduler cannot be used; what was flown is kept.
    """
    file = scenario_file(path)
    scenario = scenario_of(file)
    if resume and out is None:
        raise InputError("--resume goes on with a campaign that was begun: name its folder with --out")
    seed = scenario.seed if seed is None else seed
    origin = provenance(scenario, file, command_line(), deciding={"seed": str(seed), "runs": str(runs)})
    executor = _executor(scheduler, workers)
    with reserved_folder(out, f"{scenario.name}-montecarlo", resume=resume) as reserved:
        folder = reserved.path
        maneuver = kept_maneuver(folder, scenario) if resume else _new_maneuver(folder, file, scenario)
        plan = CampaignPlan(scenario=scenario, maneuver=maneuver, seed=seed, runs=runs)
        try:
            with campaign_progress(runs) as progress:
                table = run_campaign(plan, folder, executor, progress)
                statistics = statistics_of(table)
                finish_campaign(folder, file, origin, plan, table, statistics)
        except KeyboardInterrupt:
            again = f"repeat the command with --out {folder} --resume to go on"
            say(f"Interrupted. What was flown is kept in {folder}: {again}")
            return INTERRUPTED
    _print_result(path, folder, statistics, failures_of(table))
    return COMPLETED


def _executor(scheduler: str | None, workers: int | None) -> Executor:
    if scheduler is None:
        return LocalExecutor(workers=usable_cores() if workers is None else workers)
    if workers is not None:
        raise InputError("--workers counts processes on this machine; a scheduler has workers of its own, omit one")
    try:
        from testbed.campaign.dask_executor import DaskExecutor  # noqa: PLC0415 - its library is optional
    except ImportError as error:
        raise InputError("--scheduler needs Dask: pip install 'testbed[cluster]'") from error
    cluster = DaskExecutor(address=scheduler)
    cluster.require_workers()
    return cluster


def _new_maneuver(folder: Path, file: TextFile, scenario: Scenario) -> Maneuver:
    with naming(file.path), design_progress(starts_of(scenario)) as report:
        plan = plan_maneuver(scenario, nominal_platform(scenario), report)
    start_campaign(folder, file, plan)
    return plan.maneuver


def _print_result(path: Path, folder: Path, statistics: CampaignStatistics, failures: list[dict[str, object]]) -> None:
    show(statistics_table(statistics))
    say()
    flown = statistics.runs - statistics.failed
    say(f"Runs       {flown} of {statistics.runs} completed")
    for failure in failures[:_MOST_LISTED]:
        warn(f"run {failure['run']} failed", str(failure["message"]))
        say(f"           to see it: testbed run {path} --dispersed --seed {failure['seed']}")
    if len(failures) > _MOST_LISTED:
        say(f"           and {len(failures) - _MOST_LISTED} more, all in the report")
    print_verdict(campaign_verdict(statistics))
    say()
    say(f"Folder     {folder}")
    say(f"Report     {folder / 'report.html'}")
