"""The folder of a design: the maneuver in forms that a scenario can take up again, and its figures."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pyarrow as pa
from pyarrow import csv

from testbed.experiment.result import SCHEMA, design_of, starts_of_design
from testbed.files import TextFile, write_json
from testbed.maneuver.design import Design
from testbed.maneuver.maneuver import Maneuver
from testbed.outputs.provenance import Provenance
from testbed.scenario.scenario import Scenario
from testbed.signals import SIGNALS

_SAMPLES_PER_SECOND = 100.0


def write_design(folder: Path, file: TextFile, origin: Provenance, scenario: Scenario, design: Design) -> None:
    """Write scenario, design.json, maneuver.toml (control points), maneuver.csv (samples) and provenance.json.

    Args:
        folder: to write into.
        file: the scenario as it was read.
        origin: what made the design.
        scenario: read from the file.
        design: of its maneuver.

    Raises:
        OSError: the folder cannot be written.
    """
    content = {
        "schema": SCHEMA,
        "scenario": scenario.name,
        "design": design_of(design),
        "starts": starts_of_design(design),
        "provenance": origin.reproducible,
    }
    (folder / "scenario.toml").write_bytes(file.content)
    write_json(folder / "design.json", content)
    write_json(folder / "provenance.json", origin.content)
    (folder / "maneuver.toml").write_text(maneuver_section(design), encoding="utf-8")
    csv.write_csv(maneuver_table(design.maneuver), folder / "maneuver.csv")


def maneuver_section(design: Design) -> str:
    """Return a [maneuver] section with the spline's control points, every digit kept."""
    maneuver = design.maneuver
    in_gimbal_space = design.parametrization == "gimbal"
    spline = maneuver.gimbal_angle if in_gimbal_space else maneuver.body_rate
    assert spline is not None
    rows = ",\n".join(f"  {row}" for row in np.asarray(spline.c).tolist())
    key = "gimbal_angle_rad" if in_gimbal_space else "body_rate_rad_s"
    return (
        f"# {design.criterion}-optimal; replaces the [maneuver] of a scenario\n"
        f'[maneuver]\nkind = "control_points"\nparametrization = "{design.parametrization}"\n'
        f"duration_s = {maneuver.duration!r}\n{key} = [\n{rows},\n]\n"
    )


def maneuver_table(maneuver: Maneuver) -> pa.Table:
    """Return a maneuver's reference, a column for each signal, 100 rows a second."""
    time = np.linspace(0.0, maneuver.duration, round(maneuver.duration * _SAMPLES_PER_SECOND) + 1)
    reference = maneuver.reference(time)
    columns = {"time_s": time} | dict(zip(SIGNALS["body_rate"].columns, reference.body_rate.T, strict=True))
    if reference.gimbal_angle is not None:
        columns |= dict(zip(SIGNALS["gimbal_angle"].columns, reference.gimbal_angle.T, strict=True))
    return pa.table(columns)
