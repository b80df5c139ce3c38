"""Two hundred closed-loop flights of 5 s against the same in Basilisk, on the same two cores.

Ours fly by the compiled equations of motion, and in MuJoCo. All fly the same platform under an 80 Hz controller, two
processes each, in turn, and each with the largest step that keeps its body rate within 1e-6 rad/s of its own converged
solution (a tenth of the step), out of the same ladder. A run is set up and flown on both sides; neither writes records
or estimates anything. The flights are equally brisk: ours fly the gimbal-space design with gimbals up to 1.9 rad/s,
Basilisk's turn back from an attitude error drawn so that theirs do.

Run with `python -m benchmarks.basilisk`.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.environments import BASILISK, UnavailableError, environment
from benchmarks.flight_worker import STEPS, body_rate_errors, largest_step
from benchmarks.paired import PairedTimes, paired, workers
from benchmarks.ratios import Ratio
from testbed.plant.plant import Engine
from testbed.scenario.reader import read_scenario
from testbed.scenario.scenario import Scenario

SCENARIO = Path(__file__).resolve().parents[1] / "scenarios" / "gimbal_d_optimal.toml"
SCRIPT = Path(__file__).with_name("foreign") / "basilisk_flights.py"
COMMAND = "python -m benchmarks.basilisk"
RUNS, PROCESSES, PAIRS, CHECKED = 200, 2, 5, 2
ATTITUDE_ERROR = 0.13
"""Length of the MRP that a flight starts from, 30 deg: its gimbals reach 1.9 rad/s."""
NATURAL_FREQUENCY, DAMPING = 1.0, 0.9
"""Of Basilisk's attitude loop, rad/s and of critical."""
TARGETS: dict[Engine, float] = {"compiled": 15.0, "mujoco": 2.0}
"""How many times as fast as Basilisk each engine shall be."""
PLAIN_STEPS = (1_000_000, 500_000)
"""Steps at which Basilisk's modules are tried in one task, ns."""


def ratios() -> list[Ratio]:
    """Return the rows: Basilisk arranged at its best, and as its own examples arrange it."""
    try:
        python = environment(*BASILISK)
    except UnavailableError as error:
        return [_row(f"{RUNS} closed-loop flights of 5 s, Basilisk", None, note=f"not measured: {error}")]
    scenario = read_scenario(SCENARIO)
    fliers = [_flier(engine) for engine in ("compiled", "mujoco")]
    return [*_best(python, scenario, fliers), _plain(python, scenario, fliers[0])]


@dataclass(frozen=True, kw_only=True)
class _Flier:
    """One of our engines, and how far its steps are from converged ones, rad/s.

    Attributes:
        engine: of the scenario.
        errors: of the body rate by step, as `body_rate_errors` has them.
        step: the largest one that keeps within the tolerance, s.
    """

    engine: Engine
    errors: dict[float, float]
    step: float

    @property
    def words(self) -> str:
        """What flies, and how precisely."""
        name = "MuJoCo" if self.engine == "mujoco" else "compiled equations"
        return f"{name} at {1e3 * self.step:.3g} ms, {self.errors[self.step]:.1e} rad/s from converged"


def _flier(engine: Engine) -> _Flier:
    errors = body_rate_errors(SCENARIO, engine)
    _print_ladder(f"ours, {engine}", errors)
    return _Flier(engine=engine, errors=errors, step=largest_step(errors))


def case(scenario: Scenario, *, control_step: float | None, steps: list[int]) -> dict[str, Any]:
    """Return the inputs of Basilisk: the platform's numbers, the controller, and how every run starts.

    Args:
        scenario: the nominal platform.
        control_step: of the flight software, s; None to run it at the integrator's step, in one task.
        steps: of the ladder, ns.
    """
    platform, cluster = scenario.platform, scenario.cluster
    inertia = np.array(platform.inertia_kg_m2)
    directions = np.random.default_rng(1).standard_normal((RUNS, 3))
    mean_inertia = float(np.trace(inertia)) / 3.0
    return {
        "platform": {
            "inertia_kg_m2": inertia.tolist(),
            "mass_kg": platform.mass_kg,
            "skew_rad": float(np.deg2rad(cluster.skew_deg)),
            "mounting_radius_m": cluster.mounting_radius_m,
            "gimbal_mass_kg": cluster.gimbal_mass_kg,
            "gimbal_inertia_kg_m2": cluster.gimbal_inertia_kg_m2,
            "rotor_mass_kg": cluster.rotor_mass_kg,
            "rotor_momentum_N_m_s": cluster.rotor_momentum_N_m_s,
            "rotor_spin_inertia_kg_m2": cluster.rotor_spin_inertia_kg_m2,
            "rotor_transverse_inertia_kg_m2": cluster.rotor_transverse_inertia_kg_m2,
        },
        # An MRP is a quarter of the angle: J θ̈ = -P θ̇ - K θ / 4.
        "attitude_gain_N_m": 4.0 * NATURAL_FREQUENCY**2 * mean_inertia,
        "rate_gain_N_m_s": 2.0 * DAMPING * NATURAL_FREQUENCY * mean_inertia,
        "servo_gain_1_s": cluster.gimbal_servo_bandwidth_rad_s,
        "control_step_s": control_step,
        "steps_ns": steps,
        "duration_s": scenario.simulation.duration_s,
        "sample_s": 0.025,
        "attitudes": (ATTITUDE_ERROR * directions / np.linalg.norm(directions, axis=1, keepdims=True)).tolist(),
        "checked": CHECKED,
    }


def _best(python: Path, scenario: Scenario, fliers: Sequence[_Flier]) -> list[Ratio]:
    period = 1.0 / scenario.simulation.control_rate_hz
    steps = [round(1e9 * step) for step in STEPS if (1e9 * step / 10) % 1 == 0]  # Basilisk counts nanoseconds
    stated = case(scenario, control_step=period, steps=steps)
    found = _errors(python, stated)
    their_errors = {int(step) / 1e9: error for step, error in found["errors"].items()}
    their_step = largest_step(their_errors)
    _print_ladder("Basilisk", their_errors)
    theirs = (
        f"Basilisk at {1e3 * their_step:.3g} ms, {their_errors[their_step]:.1e}, its software at 80 Hz in a task of "
        f"its own, gimbals up to {found['gimbal_rate']:.2f} rad/s; {PROCESSES} processes each, median of {PAIRS} pairs"
    )
    return [
        _row(
            f"{RUNS} closed-loop flights of 5 s, {flier.engine}: against Basilisk, each at its largest step for "
            "1e-6 rad/s",
            _timed(python, stated, flier, their_step),
            f"{flier.words}; {theirs}",
            target=TARGETS[flier.engine],
        )
        for flier in fliers
    ]


def _plain(python: Path, scenario: Scenario, flier: _Flier) -> Ratio:
    stated = case(scenario, control_step=None, steps=list(PLAIN_STEPS)) | {"checked": 1}
    found = _errors(python, stated)["errors"]
    times = _timed(python, stated, flier, PLAIN_STEPS[0] / 1e9)
    reached = ", ".join(f"{error:.0e} at {int(step) / 1e6:g} ms" for step, error in found.items())
    note = f"the loop then converges with the first power of the step: {reached} (rad/s); ours: {flier.words}"
    return _row(f"the same, {flier.engine}, Basilisk's modules all in one task at 1 ms", times, note)


def _errors(python: Path, stated: dict[str, Any]) -> Any:
    with tempfile.TemporaryDirectory() as folder:
        path = _written(Path(folder) / "case.json", stated)
        done = subprocess.run([str(python), str(SCRIPT), "errors", path], check=True, capture_output=True, text=True)
    return json.loads(done.stdout.splitlines()[-1])


def _timed(python: Path, stated: dict[str, Any], flier: _Flier, their_step: float) -> PairedTimes:
    """Fly all runs in turn, ours and theirs, the same number in each process."""
    shares = [list(range(member, RUNS, PROCESSES)) for member in range(PROCESSES)]
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-m", "benchmarks.flight_worker", str(SCENARIO), flier.engine, repr(flier.step)]
        ours = [[*command, *map(str, share)] for share in shares]
        theirs = []
        for member, share in enumerate(shares):
            part = stated | {
                "step_ns": round(1e9 * their_step),
                "attitudes": [stated["attitudes"][run] for run in share],
            }
            path = _written(Path(folder) / f"case{member}.json", part)
            theirs.append([str(python), str(SCRIPT), "worker", path])
        with workers(ours) as fly_ours, workers(theirs) as fly_theirs:
            return paired(fly_ours, fly_theirs, PAIRS)


def _written(path: Path, content: dict[str, Any]) -> str:
    path.write_text(json.dumps(content), encoding="utf-8")
    return str(path)


def _print_ladder(whose: str, errors: dict[float, float]) -> None:
    rungs = ", ".join(f"{1e3 * step:.4g} ms {error:.1e}" for step, error in errors.items())
    print(f"{whose}: body rate against a tenth of the step, rad/s: {rungs}", flush=True)


def _row(what: str, times: PairedTimes | None, note: str, target: float = 2.0) -> Ratio:
    return Ratio(
        what=what,
        ours="" if times is None else f"{times.ours:.2f} s",
        theirs="Basilisk" if times is None else f"Basilisk {times.theirs:.2f} s",
        ratio=None if times is None else times.ratio,
        target=f"at least {target:g}",
        command=COMMAND,
        note=note,
    )


if __name__ == "__main__":
    for row in ratios():
        print(row)
