"""testbed export: the estimated platform for other programs."""

from __future__ import annotations

from pathlib import Path

from testbed.cli.console import say
from testbed.errors import InputError
from testbed.library.exporting import export
from testbed.outputs.diagnosis_folder import EXTENDED


def export_platform(folder: Path, mjcf: Path | None, urdf: Path | None, estimator: str | None) -> None:
    """Write the estimated platform and say where.

    Raises:
        InputError: the folder holds no estimate, no file is asked for, or one is there or cannot be written.
    """
    for option, path in {"--mjcf": mjcf, "--urdf": urdf}.items():
        if path is not None and path.exists():
            raise InputError(f"{option} {path}: exists; choose another file")
    extended = folder / EXTENDED
    beside = f"; with whatever the diagnosis found it is {extended}/" if extended.is_dir() else ""
    for path in export(folder, mjcf=mjcf, urdf=urdf, estimator=estimator):
        say(f"{path}: the platform of {folder} with its estimated inertia{beside}")
