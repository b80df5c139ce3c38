"""The folder of estimates from records measured elsewhere."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from testbed.assembly.platform import PlatformModel
from testbed.delivery.folder import whole_folder
from testbed.delivery.run_folder import write_json
from testbed.dynamics.inertia import theta_of
from testbed.experiment.experiment import CombinedEstimation, Estimation
from testbed.experiment.result import SCHEMA, estimates_of
from testbed.scenario.scenario import Scenario


def write_estimates(
    folder: Path,
    scenario_path: Path,
    scenario: Scenario,
    nominal: PlatformModel,
    estimations: Mapping[str, Estimation],
    combined: CombinedEstimation,
) -> None:
    """Write the scenario and estimates.json: every record's estimates, and their combination.

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
    with whole_folder(folder) as part:
        (part / "scenario.toml").write_text(scenario_path.read_text(encoding="utf-8"), encoding="utf-8")
        write_json(part / "estimates.json", content)


def _record(estimation: Estimation) -> dict[str, object]:
    bound = estimation.bound_std
    return {
        "estimates": estimates_of(estimation.by_name),
        "failures": dict(estimation.failures),
        "bound_std_kg_m2": None if bound is None else bound.tolist(),
    }
