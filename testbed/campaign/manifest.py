"""campaign.json: what decides a campaign's results, so that only the same campaign goes on in its folder."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from testbed.assembly.engine import engine_of
from testbed.assembly.platform import nominal_platform, true_platform
from testbed.campaign.plan import CampaignPlan, block_runs
from testbed.errors import InputError
from testbed.files import read_bytes, whole_file
from testbed.maneuver.maneuver import Maneuver
from testbed.plant.fingerprint import model_sha256
from testbed.plant.plant import Engine
from testbed.scenario.scenario import Scenario

MANIFEST = "campaign.json"
_SCHEMA = 1
LARGEST_MANIFEST = 100_000_000
"""Bytes; a campaign of a million runs notes 40,000 checksums, which take 4 MB."""
_MOST_SHOWN = 8
"""Differences between two campaigns that a message lists."""
_DECIDING_PACKAGES = ("testbed", "mujoco", "numpy", "scipy", "pyarrow")


@dataclass(frozen=True, kw_only=True)
class Manifest:
    """What campaign.json says.

    Attributes:
        complete: whether all runs are there.
        seconds: of flying and estimating, all starts of the campaign together, s.
        campaign: what decides its results, as `identity_of`.
        parts: SHA-256 of each part by its name; None of a campaign begun before parts had checksums.
    """

    complete: bool
    seconds: float
    campaign: Mapping[str, Any]
    parts: Mapping[str, str] | None

    def after(self, seconds: float, parts: Mapping[str, str], *, complete: bool) -> Manifest:
        """Return the manifest with further seconds of work and the checksums of the parts that are kept now."""
        return replace(self, complete=complete, seconds=self.seconds + seconds, parts=dict(sorted(parts.items())))


def claimed(folder: Path, plan: CampaignPlan) -> Manifest:
    """Return the manifest of a campaign's folder; a new one where there is none yet.

    A campaign goes on with as many runs as it had, or with more.

    Raises:
        InputError: the folder holds another campaign, or cannot be written.
    """
    campaign = identity_of(plan)
    if not (folder / MANIFEST).exists():
        manifest = Manifest(complete=False, seconds=0.0, campaign=campaign, parts={})
        write_manifest(folder, manifest)
        return manifest
    manifest = read_manifest(folder)
    extended = plan.runs > manifest.campaign["runs"]
    wanted = campaign | {"runs": manifest.campaign["runs"]} if extended else campaign
    engine = manifest.campaign["engine"]
    further = [] if engine == wanted["engine"] else [f"  To go on with it: --set simulation.engine={engine}"]
    require_same(folder, "campaign", manifest.campaign, wanted, further)
    return replace(manifest, campaign=campaign)


def read_manifest(folder: Path) -> Manifest:
    """Read a folder's campaign.json.

    Raises:
        InputError: there is none, or it is damaged.
    """
    try:
        content = json.loads(read_bytes(folder / MANIFEST, "a campaign's manifest", LARGEST_MANIFEST))
        return _manifest_of(dict(content))
    except (InputError, ValueError, KeyError, TypeError, RecursionError) as error:
        raise InputError(f"{folder}: is not the folder of a campaign: {MANIFEST} cannot be read ({error})") from error


def _manifest_of(content: Mapping[str, Any]) -> Manifest:
    """Return the manifest that JSON holds; what is not what it should be raises a TypeError or ValueError."""
    parts = content.get("parts")
    return Manifest(
        complete=content["complete"] is True,
        seconds=float(content["seconds"]),
        # Campaigns begun before there were two engines do not say that MuJoCo flew them.
        campaign={"engine": "mujoco", **content["campaign"], "runs": int(content["campaign"]["runs"])},
        parts=None if parts is None else {str(name): str(checksum) for name, checksum in dict(parts).items()},
    )


def write_manifest(folder: Path, manifest: Manifest) -> None:
    """Write a folder's campaign.json, whole or not at all; the folder is made where there is none.

    Raises:
        InputError: it cannot be written.
    """
    content = {"schema": _SCHEMA, **asdict(manifest)}
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with whole_file(folder / MANIFEST) as part:
            part.write_text(json.dumps(content, indent=2, ensure_ascii=False) + "\n", encoding="utf-8")
    except OSError as error:
        raise InputError(
            f"{folder}: cannot be written ({error.strerror}); make room or choose another folder"
        ) from error


def deciding_versions(engine: Engine = "mujoco") -> dict[str, str]:
    """Return the versions of everything that the numbers of runs pass through, which an engine flew."""
    packages = _DECIDING_PACKAGES if engine == "mujoco" else (*_DECIDING_PACKAGES, "numba")
    return {package: version(package) for package in packages}


def identity_of(plan: CampaignPlan) -> dict[str, Any]:
    """Return what decides a campaign's results, as JSON.

    Raises:
        InputError: the platforms cannot be built.
    """
    engine = engine_of(plan.scenario, many=True)
    return {
        "name": plan.scenario.name,
        "seed": plan.seed,
        "runs": plan.runs,
        "block_runs": block_runs(plan),
        "scenario": _deciding_keys(plan.scenario),
        "maneuver_sha256": maneuver_sha256(plan.maneuver),
        "nominal_model_sha256": model_sha256(nominal_platform(plan.scenario).model),
        "true_model_sha256": model_sha256(true_platform(plan.scenario).model),
        "versions": deciding_versions(engine),
        "engine": engine,
    }


def maneuver_sha256(maneuver: Maneuver) -> str:
    """Return the SHA-256 of a maneuver's reference: knots and control points of its splines."""
    digest = hashlib.sha256(np.float64(maneuver.duration).tobytes())
    for spline in maneuver.splines:
        digest.update(np.ascontiguousarray(spline.t).tobytes() + np.ascontiguousarray(spline.c).tobytes())
    return digest.hexdigest()


def require_same(
    folder: Path, what: str, kept: Mapping[str, Any], now: Mapping[str, Any], further: Sequence[str] = ()
) -> None:
    """Refuse to resume in the folder of a different campaign, diagnosis or reproduction.

    Args:
        folder: of the results.
        what: it holds, for the message: "campaign".
        kept: what decides the results that are there.
        now: what decides those that are wanted.
        further: lines of the message below the differences.

    Raises:
        InputError: they differ; the message lists every difference.
    """
    changes = differences(kept, now)
    if changes:
        message = (
            f"{folder}: holds another {what}, and nothing in it was touched: repeat its command, or choose another "
            "folder. It was started with"
        )
        raise InputError("\n".join([message, *changes, *further]))


def differences(kept: Mapping[str, Any], now: Mapping[str, Any]) -> list[str]:
    """Return what differs between two identities, a line per key: its name, the kept value, the present one."""
    before, after = dict(_leaves(kept)), dict(_leaves(now))
    keys = [*before, *(key for key in after if key not in before)]
    return [
        f"  {key} {_shown(before, key)}, now {_shown(after, key)}"
        for key in keys
        if _shown(before, key) != _shown(after, key)
    ]


def _deciding_keys(scenario: Scenario) -> dict[str, Any]:
    """The scenario without its paths: what the files hold is in the hashes, and they may be moved."""
    keys: dict[str, Any] = json.loads(scenario.model_dump_json(exclude_none=True, by_alias=True))
    keys["platform"].pop("model", None)
    keys["maneuver"].pop("file", None)
    keys["simulation"].pop("engine")  # what flies is said beside the scenario
    return keys


def _leaves(tree: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    for key, value in tree.items():
        if isinstance(value, Mapping):
            yield from _leaves(value, f"{prefix}{key}.")
        else:
            yield prefix + key, value


def _shown(leaves: Mapping[str, Any], key: str) -> str:
    return json.dumps(leaves[key], ensure_ascii=False) if key in leaves else "absent"
