"""The nominal platform with an estimated inertia, as a file for other programs."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from testbed.arrays import Matrix3
from testbed.assembly.platform import nominal_properties
from testbed.errors import OutputError
from testbed.files import whole_file
from testbed.plant.description import platform_mjcf, platform_urdf
from testbed.scenario.scenario import Scenario


def write_mjcf(scenario: Scenario, inertia: Matrix3, path: Path) -> Path:
    """Write the platform of a scenario with another inertia as MJCF.

    Args:
        scenario: the nominal model, whose mass and geometry are kept.
        inertia: J of the whole platform about its centre of mass, gimbals at zero, shape (3, 3), kg·m², body axes.
        path: of the file; one that is there is replaced.

    Raises:
        InputError: the units' own inertia is more than that of the whole platform.
        OutputError: the file cannot be written.
    """
    properties = replace(nominal_properties(scenario), inertia=inertia, cabin_size=None)
    return _written(path, platform_mjcf(properties, scenario.platform.model))


def write_urdf(scenario: Scenario, inertia: Matrix3, path: Path) -> Path:
    """Write the platform of a scenario with another inertia as URDF; as `write_mjcf`."""
    properties = replace(nominal_properties(scenario), inertia=inertia, cabin_size=None)
    return _written(path, platform_urdf(properties, scenario.platform.model))


def _written(path: Path, text: str) -> Path:
    try:
        with whole_file(path) as part:
            part.write_text(text, encoding="utf-8")
    except OSError as error:
        raise OutputError(f"{path}: cannot be written ({error.strerror}); choose another file") from error
    return path
