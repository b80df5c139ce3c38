"""The estimated platform of a folder that a command has written, as MJCF or URDF."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from testbed.arrays import Theta
from testbed.assembly.description import write_mjcf, write_urdf
from testbed.dynamics.inertia import PARAMETER_NAMES, inertia_of
from testbed.errors import InputError, words_of
from testbed.files import read_text, require_folder
from testbed.library.arguments import AnyPath, Text, checked
from testbed.library.scenarios import naming
from testbed.report.verdict import leading_estimator
from testbed.scenario.reader import read_body_scenario

_LARGEST = 100_000_000
"""Bytes of a result; a diagnosis of a hundred runs has 10 MB."""


@checked
def export(
    folder: AnyPath,
    *,
    mjcf: AnyPath | None = None,
    urdf: AnyPath | None = None,
    estimator: Text | None = None,
) -> tuple[Path, ...]:
    """Write the estimated platform of a run, of estimates or of a diagnosis for other programs, and return the files.

    Args:
        folder: that `testbed run`, `testbed estimate` or `testbed diagnose` has written.
        mjcf: file for MuJoCo; one that is there is replaced.
        urdf: file of the same platform without motors; likewise.
        estimator: whose estimate; by default the most efficient one. A diagnosis has one only.

    Raises:
        InputError: the folder holds no estimate, no file is asked for, or one cannot be written.

    Example:
        >>> import pathlib, tempfile, testbed as tb
        >>> with tempfile.TemporaryDirectory() as place:
        ...     folder = tb.fly(tb.read_scenario("basic"), seed=1).save(f"{place}/run")
        ...     written = tb.export(folder, urdf=f"{place}/platform.urdf")
        ...     [path.name for path in written]
        ['platform.urdf']
    """
    if mjcf is None and urdf is None:
        raise InputError("nothing to export: give a file for MJCF, for URDF, or for both")
    if mjcf is not None and urdf is not None and Path(mjcf).resolve() == Path(urdf).resolve():
        raise InputError(f"{mjcf}: is asked for as MJCF and as URDF: give each a file of its own")
    place = Path(folder)
    inertia = inertia_of(_theta(place, estimator))
    scenario = read_body_scenario(place / "scenario.toml")
    asked = ((mjcf, write_mjcf), (urdf, write_urdf))
    with naming(scenario):
        return tuple(write(scenario, inertia, Path(path)) for path, write in asked if path is not None)


def _theta(folder: Path, estimator: str | None) -> Theta:
    require_folder(folder)
    for name, estimates in _ESTIMATES.items():
        path = folder / name
        if path.is_file():
            try:
                found = estimates(json.loads(read_text(path, "a result", _LARGEST).text))
                known = {name: _finite(theta) for name, theta in found.items() if theta is not None}
            except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
                raise InputError(
                    f"{path}: is not as testbed wrote it ({words_of(error)}); run that command again"
                ) from error
            return _chosen(path, known, estimator)
    raise InputError(
        f"{folder}: holds none of {', '.join(_ESTIMATES)}: name the folder of a run, estimate or diagnosis"
    )


def _finite(values: Sequence[float]) -> Theta:
    theta = np.array(values, dtype=np.float64)
    if theta.shape != (len(PARAMETER_NAMES),) or not np.isfinite(theta).all():
        raise ValueError(f"{values} are no {len(PARAMETER_NAMES)} numbers")
    return theta


def _chosen(path: Path, known: Mapping[str, Theta], estimator: str | None) -> Theta:
    if not known:
        raise InputError(f"{path}: holds no estimate of the inertia")
    if estimator is not None and estimator not in known:
        raise InputError(f"{path}: has no estimate by {estimator}; there are {', '.join(known)}")
    name = estimator or (next(iter(known)) if len(known) == 1 else leading_estimator(known))
    return known[name]


def _by_estimator(estimates: Mapping[str, Any]) -> dict[str, Any]:
    return {name: each["theta_kg_m2"] for name, each in estimates.items()}


_ESTIMATES: Mapping[str, Callable[[Mapping[str, Any]], Mapping[str, Any]]] = {
    "estimates.json": lambda result: _by_estimator(result["combined"]),
    "result.json": lambda result: _by_estimator(result["estimates"]),
    "diagnosis.json": lambda result: {"diagnosis": result["inertia"]["after"]["theta_kg_m2"]},
}
"""What each result holds, by its file."""
