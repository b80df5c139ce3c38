"""The folder of a campaign. It grows while the campaign runs and cannot appear whole; campaign.json says how far it is.

`run_campaign` writes the runs and campaign.json; here is what comes before and after.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pyarrow as pa

from testbed.assembly.control import flight_clock
from testbed.assembly.platform import nominal_platform
from testbed.campaign.engine_check import EngineCheck
from testbed.campaign.manifest import MANIFEST, read_manifest
from testbed.campaign.plan import CampaignPlan
from testbed.campaign.result import checked, montecarlo_of
from testbed.campaign.statistics import CampaignStatistics
from testbed.errors import InputError
from testbed.experiment.planning import Plan, plan_maneuver, starts_of
from testbed.files import TextFile, read_bytes, whole_file, write_json
from testbed.maneuver.maneuver import Maneuver
from testbed.outputs.design_folder import maneuver_section
from testbed.outputs.provenance import Provenance
from testbed.report.campaign import write_campaign_report
from testbed.scenario.reader import LARGEST_SCENARIO, read_maneuver
from testbed.scenario.scenario import Scenario

_MANEUVER, _SCENARIO = "maneuver.toml", "scenario.toml"


def start_campaign(folder: Path, file: TextFile, plan: Plan) -> None:
    """Write the scenario, and the maneuver where it was designed, before the first run.

    Args:
        folder: of the campaign.
        file: the scenario as it was read.
        plan: with the maneuver.

    Raises:
        InputError: the folder cannot be written.
    """
    try:
        (folder / _SCENARIO).write_bytes(file.content)
        if plan.design is not None:
            (folder / _MANEUVER).write_text(maneuver_section(plan.design), encoding="utf-8")
    except OSError as error:
        raise InputError(
            f"{folder}: cannot be written ({error.strerror}); make room or choose another folder"
        ) from error


def kept_maneuver(folder: Path, scenario: Scenario) -> Maneuver:
    """Return the maneuver that a campaign began with; a design is not made again.

    Raises:
        InputError: the folder is no campaign's, or its maneuver cannot be read.
    """
    if not _is_begun(folder, scenario):
        read_manifest(folder)
    if starts_of(scenario) and (folder / _MANEUVER).is_file():
        scenario = scenario.model_copy(update={"maneuver": read_maneuver(folder / _MANEUVER)})
    return plan_maneuver(scenario, nominal_platform(scenario)).maneuver


def _is_begun(folder: Path, scenario: Scenario) -> bool:
    """Tell whether a campaign of a scenario was interrupted in a folder before its first run."""
    kept = folder / _SCENARIO
    if (folder / MANIFEST).exists() or (folder / "runs").exists() or not kept.is_file():
        return False
    return read_bytes(kept, "a scenario file", LARGEST_SCENARIO) == scenario.file.content


def finish_campaign(
    folder: Path,
    file: TextFile,
    origin: Provenance,
    plan: CampaignPlan,
    table: pa.Table,
    statistics: CampaignStatistics,
    engine_check: EngineCheck | None = None,
) -> None:
    """Write montecarlo.json, provenance.json and the report of a complete campaign.

    Args:
        folder: of the campaign.
        file: the scenario as it was read.
        origin: what made the campaign.
        plan: of the campaign.
        table: its runs.
        statistics: of the runs.
        engine_check: of runs that both engines flew.

    Raises:
        InputError: the folder cannot be written.
    """
    result = campaign_result(plan, table, statistics, read_manifest(folder).seconds, engine_check)
    result |= {"provenance": origin.reproducible}
    try:
        for name, content in (("montecarlo.json", result), ("provenance.json", origin.content)):
            with whole_file(folder / name) as part:
                write_json(part, content)
    except OSError as error:
        raise InputError(f"{folder}: cannot be written ({error.strerror}); make room there") from error
    write_campaign_report(
        folder / "report.html",
        plan=plan,
        scenario_path=file.path,
        table=table,
        statistics=statistics,
        provenance=origin.listed | {"scenario.toml": file.text},
        result=result,
    )


def campaign_result(
    plan: CampaignPlan,
    table: pa.Table,
    statistics: CampaignStatistics,
    seconds: float,
    engine_check: EngineCheck | None = None,
) -> dict[str, Any]:
    """Return what montecarlo.json holds, without provenance.

    Args:
        plan: of the campaign.
        table: its runs.
        statistics: of the runs.
        seconds: that flying and estimating took.
        engine_check: of runs that both engines flew.
    """
    clock = flight_clock(plan.scenario, plan.maneuver.duration)
    flight = clock.ticks * clock.period
    result = montecarlo_of(table, statistics, name=plan.scenario.name, seed=plan.seed, seconds=seconds, flight_s=flight)
    return result | ({} if engine_check is None else {"engine_check": checked(engine_check)})
