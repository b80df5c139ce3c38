"""The folder of estimates from records measured elsewhere."""

from __future__ import annotations

import shutil
from collections.abc import Mapping, Sequence
from pathlib import Path

from testbed.assembly.platform import PlatformModel
from testbed.delivery.folder import whole_folder
from testbed.delivery.provenance import provenance
from testbed.delivery.run_folder import write_json
from testbed.dynamics.inertia import theta_of
from testbed.experiment.experiment import CombinedEstimation, Estimation
from testbed.experiment.result import SCHEMA, estimates_of
from testbed.records.record import Record
from testbed.report.measured import write_estimates_report
from testbed.scenario.scenario import Scenario


def write_estimates(
    folder: Path,
    scenario_path: Path,
    scenario: Scenario,
    nominal: PlatformModel,
    records: Sequence[Record],
    estimations: Mapping[str, Estimation],
    combined: CombinedEstimation,
) -> None:
    """Write the scenario, estimates.json (every record's estimates, and their combination), report and provenance.

    Raises:
        InputError: the folder is taken, or cannot be written.
    """
    content = {
        "schema": SCHEMA,
        "scenario": scenario.name,
        "nominal": {"theta_kg_m2": theta_of(nominal.inertia).tolist()},
        "records": {name: _record(estimation) for name, estimation in estimations.items()},
        "combined": estimates_of(combined.by_name),
    }
    scenario_text = scenario_path.read_text(encoding="utf-8")
    origin = provenance(scenario, scenario_text)
    with whole_folder(folder) as part:
        shutil.copyfile(scenario_path, part / "scenario.toml")
        write_json(part / "estimates.json", content)
        write_json(part / "provenance.json", origin)
        write_estimates_report(
            part / "report.html",
            scenario=scenario,
            nominal=nominal,
            records=records,
            estimations=estimations,
            combined=combined,
            provenance=origin | {"scenario.toml": scenario_text},
            result=content,
        )


def _record(estimation: Estimation) -> dict[str, object]:
    bound = estimation.bound_std
    return {
        "estimates": estimates_of(estimation.by_name),
        "failures": dict(estimation.failures),
        "bound_std_kg_m2": None if bound is None else bound.tolist(),
    }
