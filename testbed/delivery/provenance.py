"""What made a run: versions, model, scenario, seed. Enough to make it again."""

from __future__ import annotations

import hashlib
import platform
from collections.abc import Mapping
from dataclasses import asdict
from datetime import UTC, datetime
from importlib.metadata import version

from testbed.experiment.experiment import Experiment
from testbed.plant.fingerprint import model_sha256
from testbed.reproduction.reproduction import Extent
from testbed.scenario.body import BodyScenario

_PACKAGES = ("testbed", "mujoco", "numpy", "scipy", "casadi", "rerun-sdk")


def run_provenance(experiment: Experiment, scenario_text: str) -> dict[str, str]:
    """Return what decides a run, and what it ran on.

    Args:
        experiment: the run.
        scenario_text: its scenario file, verbatim.
    """
    deciding = {"seed": str(experiment.seed), "model_sha256": model_sha256(experiment.truth.model)}
    return provenance(experiment.scenario, scenario_text) | deciding


def provenance(scenario: BodyScenario, scenario_text: str) -> dict[str, str]:
    """Return the scenario, the versions and the machine behind a result.

    Args:
        scenario: as read.
        scenario_text: its file, verbatim.
    """
    return {"scenario": scenario.name, "scenario_sha256": _sha256(scenario_text), **_versions()}


def reproduction_provenance(extent: Extent, scenarios: Mapping[str, str]) -> dict[str, str]:
    """Return what decides a reproduction, and what it ran on.

    Args:
        extent: how much was flown, and the seed.
        scenarios: text of every scenario file that was used, by name.
    """
    hashes = {f"scenario_{name}_sha256": _sha256(text) for name, text in scenarios.items()}
    extents = {name: str(value) for name, value in asdict(extent).items()}
    return {"scenario": "reproduction", **extents, **hashes, **_versions()}


def _versions() -> dict[str, str]:
    return {
        **{f"version_{package}": version(package) for package in _PACKAGES},
        "version_python": platform.python_version(),
        "machine": f"{platform.system()} {platform.machine()}",
        "created": datetime.now(UTC).isoformat(timespec="seconds"),
    }


def recording_id_of(provenance: dict[str, str]) -> str:
    """Return a name from everything that decides the run, and from nothing else: a viewer merges equal names."""
    deciding = sorted(item for item in provenance.items() if item[0] not in {"created", "machine"})
    return f"{provenance['scenario']}-{_sha256(repr(deciding))[:16]}"


def _sha256(text: str) -> str:
    return hashlib.sha256(text.encode("utf-8")).hexdigest()
