"""The nominal platform with an estimated inertia, as a file for other programs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from testbed.arrays import Matrix3
from testbed.assembly.platform import nominal_properties
from testbed.dynamics.inertia import theta_of
from testbed.errors import InputError, OutputError
from testbed.estimation.body import is_body
from testbed.files import whole_file
from testbed.plant.description import body_mjcf, body_urdf, platform_mjcf, platform_urdf
from testbed.plant.properties import PlatformProperties
from testbed.scenario.body import BodyScenario


def write_mjcf(scenario: BodyScenario, inertia: Matrix3, path: Path) -> Path:
    """Write the platform of a scenario with another inertia as MJCF; one without actuators as a free body.

    Args:
        scenario: the nominal model, whose mass and geometry are kept.
        inertia: J of the whole platform about its centre of mass, gimbals at zero, shape (3, 3), kg·m², body axes.
        path: of the file; one that is there is replaced.

    Raises:
        InputError: the units' own inertia is more than that of the whole platform, or no body has it.
        OutputError: the file cannot be written.
    """
    return _written(path, _described(scenario, inertia, platform_mjcf, body_mjcf))


def write_urdf(scenario: BodyScenario, inertia: Matrix3, path: Path) -> Path:
    """Write the platform of a scenario with another inertia as URDF; as `write_mjcf`."""
    return _written(path, _described(scenario, inertia, platform_urdf, body_urdf))


def _described(
    scenario: BodyScenario,
    inertia: Matrix3,
    of_platform: Callable[[PlatformProperties, Path | None], str],
    of_body: Callable[[str, float, Matrix3], str],
) -> str:
    if not scenario.stores_momentum:
        return of_body(scenario.name, _mass(scenario, inertia), inertia)
    properties = replace(nominal_properties(scenario), inertia=inertia, cabin_size=None)
    return of_platform(properties, scenario.platform.model)


def _mass(scenario: BodyScenario, inertia: Matrix3) -> float:
    """Return a body's mass, where it can have such an inertia."""
    if not is_body(theta_of(inertia)):
        raise InputError(f"{scenario.name}: no body has the estimated inertia: nothing is written of it")
    if scenario.platform.mass_kg is None:
        raise InputError(f"{scenario.name}: platform.mass_kg is missing; add it: both formats state a body's mass")
    return scenario.platform.mass_kg


def _written(path: Path, text: str) -> Path:
    try:
        with whole_file(path) as part:
            part.write_text(text, encoding="utf-8")
    except OSError as error:
        raise OutputError(f"{path}: cannot be written ({error.strerror}); choose another file") from error
    return path
