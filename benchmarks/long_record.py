"""Time and memory of `testbed estimate` on a long record: `python -m benchmarks.long_record [--rows N]`.

The motion is a sum of slow sines about three axes; the cluster takes up exactly the body's momentum, h = -J ω, so that
the truth is known and no simulation of hours is needed.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
import tomllib
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet
import tomli_w

from testbed.dynamics.inertia import theta_of
from testbed.scenario.shipped import shipped_scenario

INERTIA = np.array([[0.0221, 0.0001, 0.0], [0.0001, 0.0219, 0.0002], [0.0, 0.0002, 0.0272]])
"""kg·m²; the nominal platform's but for half a percent."""
RATE = 100.0
"""Hz; of gyro and telemetry."""


def main() -> None:
    """Estimate from records of so many rows each, in a process of its own; print time, memory and error."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rows", type=int, nargs="*", default=[200_000, 2_000_000])
    parser.add_argument("--seed", type=int, default=77)
    arguments = parser.parse_args()
    for rows in arguments.rows:
        with tempfile.TemporaryDirectory() as folder:
            print(_measured(Path(folder), rows, arguments.seed), flush=True)


def _measured(folder: Path, rows: int, seed: int) -> str:
    tree = tomllib.loads(shipped_scenario("diagnose").read_text(encoding="utf-8"))
    tree["gyro"]["sample_rate_hz"] = RATE
    tree["simulation"] |= {"control_rate_hz": RATE, "telemetry_rate_hz": RATE}
    (folder / "scenario.toml").write_text(tomli_w.dumps(tree), encoding="utf-8")
    _write_record(folder / "data", rows, tree["gyro"]["noise_rad_s"], np.random.default_rng(seed))
    command = [sys.executable, "-c", "from testbed.cli import main; main()", "estimate", "scenario.toml"]
    began = time.perf_counter()
    process = subprocess.Popen([*command, "--data", "data", "--out", "out"], cwd=folder, stdout=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    taken = time.perf_counter() - began
    if status:
        sys.exit(f"{rows} rows: the estimate ended with status {status}")
    estimates = json.loads((folder / "out" / "estimates.json").read_text(encoding="utf-8"))["combined"]
    errors = {
        name: np.abs(np.array(estimate["theta_kg_m2"]) - theta_of(INERTIA)) / np.array(estimate["std_kg_m2"])
        for name, estimate in estimates.items()
    }
    worst = ", ".join(f"{name} {error.max():.1f}" for name, error in errors.items())
    return (
        f"{rows:,} rows: {taken:.1f} s, {usage.ru_utime + usage.ru_stime:.1f} s of processor time, "
        f"{usage.ru_maxrss / 1024:.0f} MB; largest error in stated standard deviations: {worst}"
    )


def _write_record(folder: Path, rows: int, noise: float, rng: np.random.Generator) -> None:
    folder.mkdir()
    time_s = np.arange(rows) / RATE
    phases = rng.uniform(0.0, 2.0 * np.pi, (3, 3))
    rate = sum(
        0.05 * np.sin(2.0 * np.pi * hertz * time_s[:, None] + phase)
        for hertz, phase in zip((0.11, 0.23, 0.31), phases, strict=True)
    )
    momentum = -rate @ INERTIA
    columns = {"time_s": time_s}
    for axis, name in enumerate("xyz"):
        columns[f"body_rate_{name}_rad_s"] = rate[:, axis] + rng.normal(0.0, noise, rows)
        columns[f"cluster_momentum_{name}_N_m_s"] = momentum[:, axis]
    pyarrow.parquet.write_table(pa.table(columns), folder / "run.parquet")
    (folder / "run.toml").write_text(f"gyro_noise_rad_s = {noise}\n", encoding="utf-8")


if __name__ == "__main__":
    main()
