"""Satellites that Basilisk flies, what flies of them in a case, and Basilisk itself, in a process of its own."""

from __future__ import annotations

import json
import subprocess
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from benchmarks.environments import BASILISK, environment
from benchmarks.strangers_craft import STEPS, Craft, drawn_craft, engine_craft, step_of
from benchmarks.strangers_effects import BESIDE_PARTS, WITH_PARTS
from concealing.craft import Array
from concealing.effect import EffectKind, HiddenEffect
from concealing.wheel_case import WheelPlatform, platform_of

SCRIPT = Path(__file__).with_name("foreign") / "basilisk_strangers.py"
_KNOTS = (4.0, 8.0)
"""s between two corners of the wanted body rate; between them its acceleration is constant."""
_STEP, _FINE_STEP = 5_000_000, 1_000_000
"""ns, of the integration; the fine one where a rotor that is out of balance turns by a third of a radian in it."""


@dataclass(frozen=True, kw_only=True)
class Platform:
    """A satellite that Basilisk flies.

    Attributes:
        scenario: the nominal one.
        kinds: what can be hidden in it.
        largest_rate: that is asked for about each axis, rad/s.
        altitude: of its orbit, m; None where it flies freely.
        encoder_clicks: of a turn of a wheel.
        navigation: bounds of the errors of attitude, as an MRP, and of rate, rad/s.
        natural_frequency: of the attitude loop, rad/s.
    """

    scenario: Path
    kinds: Mapping[str, EffectKind]
    largest_rate: Array
    encoder_clicks: int
    navigation: Mapping[str, float]
    natural_frequency: float
    altitude: float | None = None

    @property
    def numbers(self) -> WheelPlatform:
        """What its scenario says of it."""
        return platform_of(self.scenario)


_ROOT = Path(__file__).resolve().parents[1]
PLATFORMS = {
    "cubesat_wheels": Platform(
        scenario=_ROOT / "scenarios" / "cubesat_wheels.toml",
        kinds=BESIDE_PARTS,
        largest_rate=np.array([0.08, 0.08, 0.16]),
        encoder_clicks=512,
        navigation={"attitude_mrp": 1e-4, "body_rate_rad_s": 2e-4},
        natural_frequency=0.3,
    ),
    "microsat": Platform(
        scenario=Path(__file__).with_name("foreign") / "microsat.toml",
        kinds=WITH_PARTS,
        largest_rate=np.array([0.024, 0.026, 0.05]),
        encoder_clicks=1024,
        navigation={"attitude_mrp": 2e-5, "body_rate_rad_s": 2e-5},
        natural_frequency=0.2,
        altitude=4.0e5,
    ),
}
"""By name; scenarios state the noise of gyros and encoders."""


class Run(NamedTuple):
    """One run: seeds of wanted motion, gyro and navigation, and what the rate at release is beside the wanted one."""

    motion: int
    gyro: int
    navigation: int
    release_error: tuple[float, float, float]


@dataclass(frozen=True, kw_only=True)
class StrangerCase:
    """One data set.

    Attributes:
        platform: its name.
        seed: of the answer's salt.
        duration: of every run, s.
        runs: in the order of their files.
        theta_error: true minus nominal J11, J22, J33, J23, J13, J12, kg·m².
        effects: hidden in it, in the parameters of the engine's modules.
        stratum: part of the score card.
        notes: what is known of it.
    """

    platform: str
    seed: int
    duration: float
    runs: tuple[Run, ...]
    theta_error: tuple[float, ...]
    effects: tuple[HiddenEffect, ...] = ()
    stratum: str = "null"
    notes: dict[str, float | str] = field(default_factory=dict)

    @property
    def craft(self) -> Craft:
        """What flies."""
        platform = PLATFORMS[self.platform]
        a, b, c, yz, xz, xy = self.theta_error
        error = np.array([[a, xy, xz], [xy, b, yz], [xz, yz, c]])
        craft = drawn_craft(platform.numbers, platform.numbers.inertia + error)
        for hidden in self.effects:
            craft = platform.kinds[hidden.effect].apply(craft, hidden.component, hidden.parameters)
        return craft


class Flown(NamedTuple):
    """The channels of one run as Basilisk logs them; times at control ticks, `true_` ones at their halves too."""

    time: Array
    body_rate: Array
    wheel_speed: Array
    wheel_torque_command: Array
    attitude_mrp: Array
    true_time: Array
    true_body_rate: Array
    true_attitude_mrp: Array
    true_wheel_speed: Array


class Engine:
    """Basilisk in a process of its own."""

    def __init__(self, process: subprocess.Popen[str], folder: Path) -> None:
        """Take a process that waits for paths, and a folder for what it is to fly and what it has flown."""
        self._process, self._folder = process, folder

    def fly(self, case: StrangerCase, *, quiet: bool = False) -> list[Flown]:
        """Fly a case's runs.

        Args:
            case: to fly.
            quiet: without the noise of the gyro; encoders and navigation err as before.

        Raises:
            UnreachableError: there is no such craft.
        """
        asked, out = self._folder / "asked.json", self._folder / "flown.npz"
        asked.write_text(json.dumps(self._asked(case, quiet)), encoding="utf-8")
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        print(asked, out, file=self._process.stdin, flush=True)
        while (line := self._process.stdout.readline()).strip() != "done":
            if not line:
                raise RuntimeError("Basilisk ended before it had flown the case")
        with np.load(out) as channels:
            return [Flown(*(channels[f"{index}_{name}"] for name in Flown._fields)) for index in range(len(case.runs))]

    def _asked(self, case: StrangerCase, quiet: bool) -> dict[str, Any]:
        platform = PLATFORMS[case.platform]
        inertia = float(np.trace(platform.numbers.inertia)) / 3.0
        circular = platform.natural_frequency
        believed = {
            # An MRP is a quarter of the angle: J θ̈ = -P θ̇ - K θ / 4.
            "gains": [4.0 * circular**2 * inertia, 2.0 * 0.9 * circular * inertia],
            "navigation": dict(platform.navigation),
            "encoder_clicks": platform.encoder_clicks,
        }
        craft = engine_craft(case.craft, platform.numbers, platform.altitude, believed)
        if quiet:
            craft["gyro"]["noise_rad_s"] = 0.0
        step = _step(case.craft)
        runs = [self._asked_run(case, index, run) | {"step_ns": step} for index, run in enumerate(case.runs)]
        return {"craft": craft, "runs": runs}

    def _asked_run(self, case: StrangerCase, index: int, run: Run) -> dict[str, Any]:
        platform = PLATFORMS[case.platform]
        time, attitude, rate, acceleration = waypoints(platform, case.duration, run.motion)
        path = self._folder / f"waypoints_{index}.csv"
        np.savetxt(path, np.column_stack([time, attitude, rate, acceleration]), delimiter=",", fmt="%.12g")
        return {
            "duration_s": case.duration,
            "attitude_mrp": attitude[0].tolist(),
            "body_rate_rad_s": (rate[0] + np.array(run.release_error)).tolist(),
            "seeds": [run.gyro, run.navigation],
            "waypoints": str(path),
        }


def _step(craft: Craft) -> int:
    """Return the step of the integration, ns."""
    coarsest = _FINE_STEP if craft.wheels.imbalance.any() else _STEP
    late = step_of(craft.gyro.late) if craft.gyro.late else coarsest
    return late if late <= coarsest else next(step for step in STEPS if step <= coarsest and late % step == 0)


@contextmanager
def engine() -> Iterator[Engine]:
    """Start Basilisk for as long as a block lasts.

    Raises:
        UnavailableError: it cannot be installed.
    """
    python = environment(*BASILISK)
    with tempfile.TemporaryDirectory() as folder:
        process = subprocess.Popen(
            [str(python), str(SCRIPT)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, encoding="utf-8"
        )
        try:
            yield Engine(process, Path(folder))
        finally:
            assert process.stdin is not None
            process.stdin.close()
            process.wait()


def waypoints(platform: Platform, duration: float, seed: int) -> tuple[Array, Array, Array, Array]:
    """Return a wanted motion: times, MRPs of the reference in N, and its rates and accelerations in its own axes.

    Rates go along straight lines from corner to corner, as wheels' torques do in slews: the jumps at corners make what
    is loose ring.
    """
    rng = np.random.default_rng(seed)
    corners = np.concatenate([[0.0], np.cumsum(rng.uniform(*_KNOTS, int(duration / _KNOTS[0]) + 2))])
    rates = rng.uniform(-1.0, 1.0, (len(corners), 3)) * platform.largest_rate
    rates[0] *= rng.random() < 0.5  # half of the runs begin at rest
    period = 1.0 / platform.numbers.control_rate
    time = period * np.arange(round(duration / period) + 2)
    rate = np.column_stack([np.interp(time, corners, each) for each in rates.T])
    slopes = np.diff(rates, axis=0) / np.diff(corners)[:, None]
    acceleration = slopes[np.searchsorted(corners, time, side="right") - 1]
    attitude = [Rotation.random(random_state=rng)]
    for before, after in pairwise(rate):
        attitude.append(attitude[-1] * Rotation.from_rotvec(0.5 * period * (before + after)))
    return time, np.array([each.as_mrp() for each in attitude]), rate, acceleration
