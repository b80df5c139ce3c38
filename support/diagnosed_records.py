"""Records made by the prediction itself, with or without an effect: quick, and exactly as the model says."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from pathlib import Path

import numpy as np

from testbed.arrays import Array
from testbed.assembly.platform import PlatformModel, nominal_platform
from testbed.dynamics.inertia import theta_of
from testbed.estimation.telemetry import GimbalTelemetry, Telemetry
from testbed.prediction.grid import grid_of
from testbed.prediction.hooks import Hooks
from testbed.prediction.integration import Values
from testbed.prediction.prediction import predicted
from testbed.records.record import Record, RunDetails
from testbed.scenario.reader import read_scenario
from testbed.scenario.scenario import Scenario

ROOT = Path(__file__).resolve().parents[1]
SCENARIO = ROOT / "scenarios" / "diagnose.toml"
NOISE = 0.001658
"""rad/s; the flight noise of the scenario."""


@cache
def nominal() -> tuple[Scenario, PlatformModel]:
    """The scenario that records are compared with, and its platform."""
    scenario = read_scenario(SCENARIO)
    return scenario, nominal_platform(scenario)


def records(
    count: int,
    *,
    seconds: float = 4.0,
    hooks: Sequence[Hooks] = (),
    values: Sequence[Array] = (),
    noise: float = NOISE,
    seed: int = 1,
) -> list[Record]:
    """Return runs of 16 Hz in which six gimbals swing, each its own way, after a release with some spin.

    Args:
        count: of the runs.
        seconds: of each.
        hooks: effects on the motion.
        values: their parameters, each of shape (K,).
        noise: of the gyro, rad/s.
        seed: of motions and noise.
    """
    rng = np.random.default_rng(seed)
    time = np.arange(0.0, seconds + 1e-9, 1.0 / 16.0)
    angles = [_swing(time, rng) for _ in range(count)]
    initial_rate = rng.normal(0.0, 0.05, (count, 1, 3))
    _, platform = nominal()
    blank = [
        Telemetry(
            gyro_time=time,
            body_rate=np.tile(released, (len(time), 1)),
            gyro_noise=noise,
            actuator_time=time,
            gimbals=GimbalTelemetry(cluster=platform.cluster, angle=angle),
        )
        for angle, released in zip(angles, initial_rate, strict=True)
    ]
    motion = Values(
        theta=theta_of(platform.inertia)[None],
        initial_rate=initial_rate,
        effects=tuple(value[None] for value in values),
    )
    rates = predicted(grid_of(blank), hooks, motion)
    return [
        Record(
            time=time,
            channels={"body_rate": rate[0] + rng.normal(0.0, noise, rate[0].shape), "gimbal_angle": angle},
            details=RunDetails(name=f"run{number}", gyro_noise=noise),
        )
        for number, (rate, angle) in enumerate(zip(rates, angles, strict=True), start=1)
    ]


def _swing(time: Array, rng: np.random.Generator) -> Array:
    """Return six gimbal angles from rest, two tones each, shape (N, 6), rad."""
    frequency = rng.uniform(0.15, 0.6, (2, 6))
    phase = rng.uniform(0.0, 2.0 * np.pi, (2, 6))
    size = rng.uniform(0.2, 0.6, (2, 6))
    tones = size * (np.sin(2.0 * np.pi * frequency * time[:, None, None] + phase) - np.sin(phase))
    return np.asarray(tones.sum(axis=1))
