"""The estimators against mujoco.sysid's output-error fit on the same records, both scatters beside the bound.

mujoco.sysid needs its extra; it gets an environment of its own under build/, the testbed's stays as it is.

Run with `python -m benchmarks.sysid [SEEDS]`: the time on one record, or with SEEDS the scatter over that many.
"""

from __future__ import annotations

import json
import statistics
import subprocess
import sys
import tempfile
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.environments import UnavailableError, environment
from benchmarks.paired import seconds
from benchmarks.ratios import Ratio
from testbed.arrays import Array, Theta
from testbed.assembly.estimators import estimation_settings
from testbed.assembly.platform import PlatformModel, nominal_platform, nominal_properties
from testbed.assembly.telemetry import telemetry_of
from testbed.dynamics.inertia import theta_of
from testbed.estimation.bound import cramer_rao_bound
from testbed.estimation.estimate import EstimationSettings
from testbed.estimation.registry import ESTIMATORS
from testbed.estimation.telemetry import Telemetry
from testbed.experiment.flying import fly_maneuver
from testbed.experiment.planning import plan_maneuver
from testbed.plant.build import shipped_model, specification
from testbed.plant.geometry import bus_inertia
from testbed.records.record import Record
from testbed.records.selection import sampled
from testbed.scenario.reader import read_scenario

SCENARIO = Path(__file__).resolve().parents[1] / "scenarios" / "gimbal_d_optimal.toml"
SCRIPT = Path(__file__).with_name("foreign") / "sysid_fit.py"
REQUIREMENT = "mujoco[sysid]==4.0.0"
COMMAND = "python -m benchmarks.sysid"
REPEATS, SCATTER_SEEDS = 21, 20
FIRST_SCALE = np.array([1.03, 0.98, 1.02, 1.0, 1.0, 1.0])
FIRST_OFFSET = np.array([0.0, 0.0, 0.0, 3e-4, -3e-4, 2e-4])
"""kg·m²; where the fit starts: the nominal inertia, a few percent off."""
AS_IT_COMES = {"optimizer": "mujoco", "weighted": False}
AT_ITS_FASTEST = {"optimizer": "scipy_parallel_fd", "weighted": True}
FASTEST_STEP = 0.0025


@dataclass(frozen=True, kw_only=True)
class Flown:
    """One flight for every estimator.

    Attributes:
        record: of the flight.
        telemetry: what the estimators take.
        settings: of the estimators.
    """

    record: Record
    telemetry: Telemetry
    settings: EstimationSettings


def ratios() -> list[Ratio]:
    """Return the time ratios on one record, with mujoco.sysid as it comes and at its fastest."""
    what = "time of momentum-form IV against mujoco.sysid's output-error fit of the same record"
    try:
        python = environment("sysid-venv", REQUIREMENT)
    except UnavailableError as error:
        return [_row(what, "at least 1,000", note=f"not measured: {error}")]
    platform, (flight,) = _flown([1])
    rows = []
    own_step = read_scenario(SCENARIO).simulation.step_s
    for how, options, step in (
        ("as it comes", AS_IT_COMES, own_step),
        ("at its fastest", AT_ITS_FASTEST, FASTEST_STEP),
    ):
        before = _times(flight)
        (fit,) = _fits(python, platform, [flight], step, options)
        ours = statistics.median(before + _times(flight))
        apart = np.abs(np.array(fit["theta_kg_m2"]) - _theta(flight, "iv_momentum")).max()
        rows.append(
            _row(
                f"{what}, sysid {how}",
                "at least 1,000",
                ours=f"{1e3 * ours:.1f} ms",
                theirs=f"mujoco.sysid {fit['seconds']:.1f} s",
                ratio=fit["seconds"] / ours,
                note=f"its optimizer {options['optimizer']}, step {1e3 * step:g} ms, two threads against our one; "
                f"answers {1e3 * apart:.3f}e-3 kg m² apart",
            )
        )
    return rows


def scatter_ratios(seeds: int = SCATTER_SEEDS) -> list[Ratio]:
    """Return scatter over the bound, root mean square over the six parameters, and ours over theirs."""
    what = f"scatter over {seeds} seeds: momentum-form IV over mujoco.sysid"
    command = f"{COMMAND} {seeds}"
    try:
        python = environment("sysid-venv", REQUIREMENT)
    except UnavailableError as error:
        return [_row(what, "at most 1", note=f"not measured: {error}", command=command)]
    platform, flown = _flown(list(range(seeds)))
    truth = theta_of(platform.inertia)
    bound = _bound(flown, truth)
    fits = _fits(python, platform, flown, FASTEST_STEP, AT_ITS_FASTEST)
    theirs = _scatter(np.array([fit["theta_kg_m2"] for fit in fits]) - truth, bound)
    rows = []
    for name in ("iv_momentum", "output_error"):
        ours = _scatter(np.array([_theta(flight, name) for flight in flown]) - truth, bound)
        rows.append(
            _row(
                what.replace("momentum-form IV", "momentum-form IV" if name == "iv_momentum" else "output error"),
                "at most 1",
                ours=f"{ours:.3f} of the bound",
                theirs=f"mujoco.sysid {theirs:.3f} of the bound",
                ratio=ours / theirs,
                note=f"root mean square error over the bound, all six parameters, the same {seeds} records",
                command=command,
            )
        )
    return rows


def _flown(seeds: list[int]) -> tuple[PlatformModel, list[Flown]]:
    scenario = read_scenario(SCENARIO)
    platform = nominal_platform(scenario)
    maneuver = plan_maneuver(scenario, platform).maneuver
    settings = estimation_settings(scenario, platform, maneuver)
    records = [fly_maneuver(scenario, platform, platform, maneuver, seed).record for seed in seeds]
    return platform, [
        Flown(record=record, telemetry=telemetry_of(record, scenario, platform), settings=settings)
        for record in records
    ]


def _times(flight: Flown) -> list[float]:
    """Time the momentum form; an estimator remembers what follows from a telemetry, so each gets one of its own."""
    estimate = ESTIMATORS["iv_momentum"]
    copies = [replace(flight.telemetry) for _ in range(REPEATS)]
    return [seconds(partial(estimate, telemetry, flight.settings)) for telemetry in copies]


def _theta(flown: Flown, name: str) -> Theta:
    return ESTIMATORS[name](flown.telemetry, flown.settings).theta


def _scatter(errors: Array, bound_std: Theta) -> float:
    return float(np.sqrt(np.mean((errors / bound_std) ** 2)))


def _bound(flown: list[Flown], truth: Theta) -> Theta:
    """Return the standard deviations of the mean Cramér-Rao bound of the motions as measured, kg·m²."""
    bounds = [cramer_rao_bound(flight.telemetry, truth, np.zeros(3))[:6, :6] for flight in flown]
    return np.sqrt(np.diag(np.mean(bounds, axis=0)))


def _fits(
    python: Path, platform: PlatformModel, flown: list[Flown], step: float, options: dict[str, Any]
) -> list[dict[str, Any]]:
    """Fit every record in sysid's environment."""
    properties = nominal_properties(read_scenario(SCENARIO))
    theta = theta_of(platform.inertia)
    with tempfile.TemporaryDirectory() as folder:
        model, case_file = Path(folder) / "platform.xml", Path(folder) / "case.json"
        spec = specification(properties, shipped_model())
        spec.compile()
        model.write_text(spec.to_xml(), encoding="utf-8")
        content = {
            "model": str(model),
            "step_s": step,
            "gimbal_axis_inertia_kg_m2": float(platform.cluster.gimbal_axis_inertia[0]),
            "units_inertia_kg_m2": (platform.inertia - bus_inertia(platform.model, platform.inertia)).tolist(),
            "first_theta_kg_m2": (theta * FIRST_SCALE + FIRST_OFFSET).tolist(),
            "records": [_record(flight.record) for flight in flown],
            **options,
        }
        case_file.write_text(json.dumps(content), encoding="utf-8")
        done = subprocess.run([str(python), str(SCRIPT), str(case_file)], check=True, capture_output=True, text=True)
    fits: list[dict[str, Any]] = json.loads(done.stdout.splitlines()[-1])
    return fits


def _record(record: Record) -> dict[str, list[Any]]:
    gyro_time, body_rate = sampled(record, "body_rate")
    angle_time, angle = sampled(record, "gimbal_angle")
    _, speed = sampled(record, "rotor_speed")
    return {
        "gyro_time_s": gyro_time.tolist(),
        "body_rate_rad_s": body_rate.tolist(),
        "angle_time_s": angle_time.tolist(),
        "gimbal_angle_rad": angle.tolist(),
        "rotor_speed_rad_s": speed.tolist(),
    }


def _row(
    what: str,
    target: str,
    *,
    ours: str = "",
    theirs: str = "mujoco.sysid",
    ratio: float | None = None,
    note: str,
    command: str = COMMAND,
) -> Ratio:
    return Ratio(what=what, ours=ours, theirs=theirs, ratio=ratio, target=target, command=command, note=note)


if __name__ == "__main__":
    for row in scatter_ratios(int(sys.argv[1])) if len(sys.argv) > 1 else ratios():
        print(row)
