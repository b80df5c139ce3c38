"""testbed montecarlo: many runs of one scenario, in statistics."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from testbed.assembly.engine import require_comparable
from testbed.campaign.plan import command_alone
from testbed.cli.campaign_progress import campaign_progress
from testbed.cli.console import command_line, design_progress, print_as_json, say, say_interrupted, show, warn
from testbed.cli.failures import COMPLETED, INTERRUPTED
from testbed.cli.notices import print_verdict
from testbed.cli.options import changed_flight, print_folder, require_folder
from testbed.cli.tables import offset_lines, statistics_table
from testbed.experiment.planning import starts_of
from testbed.library.campaigns import Campaign, executor_of, flown_into, origin_of, planned_in
from testbed.outputs.folder import reserved_folder
from testbed.report.verdict import campaign_verdict
from testbed.report.wording import estimator_name

_MOST_LISTED = 5


def run_montecarlo(
    source: str,
    changes: Sequence[str],
    runs: int,
    seed: int | None,
    out: Path | None,
    *,
    resume: bool,
    scheduler: str | None,
    workers: int | None,
    check: int,
) -> int:
    """Fly a campaign, write its folder as it goes, print its statistics; returns the exit code.

    Raises:
        InputError: the scenario, the folder, or the scheduler cannot be used; what was flown is kept.
    """
    scenario = changed_flight(source, changes)
    require_folder("campaign", out, resume=resume)
    seed = scenario.seed if seed is None else seed
    executor = executor_of(scheduler, workers)
    if check:
        require_comparable(scenario, check, runs)
    origin = origin_of(scenario, seed, runs, command_line())
    with reserved_folder(out, f"{scenario.name}-montecarlo", resume=resume) as reserved:
        folder = reserved.path
        with design_progress(0 if resume else starts_of(scenario)) as report:
            plan = planned_in(folder, scenario, seed=seed, runs=runs, resume=resume, progress=report)
        try:
            with campaign_progress(runs) as progress:
                campaign = flown_into(folder, plan, origin, executor, progress, check)
        except KeyboardInterrupt:
            again = f"repeat the command with --out {folder} --resume to go on"
            say_interrupted(f". What was flown is kept in {folder}: {again}")
            return INTERRUPTED
    _print_result(source, folder, campaign)
    print_as_json(folder / "montecarlo.json")
    return COMPLETED


def _print_result(source: str, folder: Path, campaign: Campaign) -> None:
    statistics, failures = campaign.statistics, campaign.failures
    if statistics.failed < statistics.runs:
        show(statistics_table(statistics))
        say()
    for text in offset_lines(statistics):
        say(text)
    flown = statistics.runs - statistics.failed
    say(f"Runs       {flown} of {statistics.runs} completed")
    if campaign.engine_check is not None:
        check = campaign.engine_check
        say(
            f"Engines    {check.runs} runs in MuJoCo and by the compiled equations: body rates within "
            f"{check.largest_difference:.1e} rad/s (run {check.run})"
        )
    for failure in failures[:_MOST_LISTED]:
        warn(f"run {failure['run']} failed", str(failure["message"]))
        say(f"           to see it: {command_alone(campaign.plan, source, failure['seed'])}")
    if len(failures) > _MOST_LISTED:
        say(f"           and {len(failures) - _MOST_LISTED} more, all in the report")
    for each in campaign.unestimated:
        name = estimator_name(each["estimator"])
        warn("note", f"no estimate by {name} of {each['runs']} of {flown} runs: {each['message']}")
    print_verdict(campaign_verdict(statistics))
    say()
    print_folder(folder)
