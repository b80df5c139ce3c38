"""What made a result: inputs, seed, versions, command. Enough to make it again."""

from __future__ import annotations

import hashlib
import platform
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from typing import Any

from testbed.files import FileStamp, TextFile, stamped
from testbed.scenario.body import BodyScenario
from testbed.scenario.maneuver import CsvManeuver
from testbed.scenario.scenario import Scenario

_PACKAGES = ("testbed", "mujoco", "numpy", "scipy", "casadi", "rerun-sdk")


@dataclass(frozen=True, kw_only=True)
class Provenance:
    """What made a result.

    Attributes:
        scenario: name of what was done.
        inputs: every file that was read, as it was read.
        deciding: what else decides the numbers: seed, hashes of models, versions.
        circumstances: what does not decide them: command line, machine, time.
    """

    scenario: str
    inputs: tuple[FileStamp, ...]
    deciding: Mapping[str, str]
    circumstances: Mapping[str, str]

    @property
    def reproducible(self) -> dict[str, Any]:
        """What a result states of itself, the same whenever and wherever it is made again."""
        return {**self.deciding, "inputs": [asdict(stamp) for stamp in self.inputs]}

    @property
    def content(self) -> dict[str, Any]:
        """What provenance.json holds."""
        return {"scenario": self.scenario, **self.circumstances, **self.reproducible}

    @property
    def listed(self) -> dict[str, str]:
        """Every entry by name, as a page lists them."""
        inputs = {f"input {stamp.path}": f"sha256 {stamp.sha256}, {stamp.size} bytes" for stamp in self.inputs}
        return {"scenario": self.scenario, **self.circumstances, **self.deciding, **inputs}

    @property
    def recording_id(self) -> str:
        """A name from everything that decides the result, and from nothing else: a viewer merges equal names."""
        deciding = repr((sorted(self.deciding.items()), sorted(stamp.sha256 for stamp in self.inputs)))
        return f"{self.scenario}-{hashlib.sha256(deciding.encode()).hexdigest()[:16]}"

    def with_command(self, command: str) -> Provenance:
        """Return the same, made by another command."""
        return replace(self, circumstances={**self.circumstances, "command": command})

    def with_deciding(self, **more: str) -> Provenance:
        """Return the same with more of what decides the numbers, such as the hash of a model."""
        return replace(self, deciding={**self.deciding, **more})


def provenance(
    scenario: BodyScenario,
    file: TextFile,
    command: str,
    *,
    data: Sequence[FileStamp] = (),
    deciding: Mapping[str, str] | None = None,
) -> Provenance:
    """Return what made a result from one scenario.

    Args:
        scenario: as read.
        file: it was read from.
        command: line that was given.
        data: measured records that were read.
        deciding: what else decides the numbers, such as the seed.
    """
    return Provenance(
        scenario=scenario.name,
        inputs=(file.stamp, *_beside(scenario), *data),
        deciding={"scenario_sha256": file.stamp.sha256, **(deciding or {}), **_versions()},
        circumstances=_circumstances(command),
    )


def provenance_of_several(
    name: str, files: Sequence[TextFile], command: str, deciding: Mapping[str, str]
) -> Provenance:
    """Return what made a result from several scenarios.

    Args:
        name: of the result.
        files: the scenarios.
        command: line that was given.
        deciding: what else decides the numbers, such as the seed.
    """
    hashes = {f"scenario_{file.path.stem}_sha256": file.stamp.sha256 for file in files}
    return Provenance(
        scenario=name,
        inputs=tuple(file.stamp for file in files),
        deciding={**deciding, **hashes, **_versions()},
        circumstances=_circumstances(command),
    )


def provenance_of_files(
    name: str, inputs: Sequence[FileStamp], command: str, packages: Sequence[str] = _PACKAGES
) -> Provenance:
    """Return what made something from files alone.

    Args:
        name: of what was made.
        inputs: the files.
        command: line that was given.
        packages: whose versions decide it.
    """
    return Provenance(
        scenario=name, inputs=tuple(inputs), deciding=_versions(packages), circumstances=_circumstances(command)
    )


def _beside(scenario: BodyScenario) -> list[FileStamp]:
    """Return the stamps of the files that a scenario names."""
    stamps = [] if scenario.platform.model is None else [stamped(scenario.platform.model, "the platform's MJCF")]
    if isinstance(scenario, Scenario) and isinstance(scenario.maneuver, CsvManeuver):
        stamps.append(stamped(scenario.maneuver.file, "the maneuver's table"))
    return stamps


def _versions(packages: Sequence[str] = _PACKAGES) -> dict[str, str]:
    installed = {f"version_{package}": _version(package) for package in packages}
    return {name: found for name, found in installed.items() if found} | {"version_python": platform.python_version()}


def _version(package: str) -> str:
    """Return the version of a package; empty where it is not installed, as those of an optional extra may be."""
    try:
        return version(package)
    except PackageNotFoundError:
        return ""


def _circumstances(command: str) -> dict[str, str]:
    return {
        "command": command,
        "machine": f"{platform.system()} {platform.machine()}",
        "created": datetime.now(UTC).isoformat(timespec="seconds"),
    }
