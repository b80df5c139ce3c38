"""The folder of a design: the maneuver in forms that a scenario can take up again, and its figures."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pyarrow as pa
from pyarrow import csv
from scipy.interpolate import BSpline

from testbed.assembly.platform import each_wheel
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
    csv.write_csv(maneuver_table(design.maneuver, scenario), folder / "maneuver.csv")


def maneuver_section(design: Design) -> str:
    """Return a [maneuver] section with the spline's control points, every digit kept."""
    maneuver = design.maneuver
    motion = {"gimbal_angle_rad": maneuver.gimbal_angle, "wheel_momentum_N_m_s": maneuver.wheel_momentum}
    splines = {"body_rate_rad_s": maneuver.body_rate} if design.parametrization == "body_rate" else motion
    lists = "".join(f"{key} = [\n{_rows(spline)},\n]\n" for key, spline in splines.items() if spline is not None)
    return (
        f"# {design.criterion}-optimal; replaces the [maneuver] of a scenario\n"
        f'[maneuver]\nkind = "control_points"\nparametrization = "{design.parametrization}"\n'
        f"duration_s = {maneuver.duration!r}\n{lists}"
    )


def _rows(spline: BSpline) -> str:
    return ",\n".join(f"  {row}" for row in np.asarray(spline.c).tolist())


def maneuver_table(maneuver: Maneuver, scenario: Scenario) -> pa.Table:
    """Return a maneuver's reference, a column for each signal, 100 rows a second.

    Args:
        maneuver: to sample.
        scenario: whose it is: the wheels' momenta are written as speeds.
    """
    time = np.linspace(0.0, maneuver.duration, round(maneuver.duration * _SAMPLES_PER_SECOND) + 1)
    reference = maneuver.reference(time)
    columns = {"time_s": time} | dict(zip(SIGNALS["body_rate"].columns, reference.body_rate.T, strict=True))
    if reference.gimbal_angle is not None:
        units = reference.gimbal_angle.shape[1]
        columns |= dict(zip(SIGNALS["gimbal_angle"].sized(units).columns, reference.gimbal_angle.T, strict=True))
    if reference.wheel_momentum is not None:
        speed = reference.wheel_momentum / each_wheel(scenario, "spin_inertia_kg_m2")
        columns |= dict(zip(SIGNALS["wheel_speed"].sized(speed.shape[1]).columns, speed.T, strict=True))
    return pa.table(columns)
