"""The blind cases that Basilisk flies: drawn, sized, flown, written as records, and their answers sealed.

Each case is a function of the set's seed and of its number. How large an effect is, is seen by flying the case without
noise of gyro and encoders and asking what of its readings the nominal model leaves (`concealing.nominal`), inertia and
initial rates projected out: its norm in standard deviations is two or four times the smallest that can be seen.
"""

from __future__ import annotations

import json
import subprocess
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field, replace
from itertools import pairwise, product
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from benchmarks.environments import environment
from benchmarks.strangers_craft import (
    BESIDE_PARTS,
    STEPS,
    WITH_PARTS,
    Craft,
    answered,
    drawn_craft,
    engine_craft,
    step_of,
)
from concealing.craft import Array
from concealing.effect import EffectKind, HiddenEffect
from concealing.nominal import Telemetry, nudged, predictions, unexplained
from concealing.order import Order, case_generator, case_name, order_generator, shuffled, turns
from concealing.power import UnreachableError, degrees_of, detectable_norm, searched
from concealing.sealing import SEAL, sealed_text, write_sealed
from concealing.wheel_case import WheelPlatform, platform_of
from concealing.wheel_effects import FLYING, IN_DRIVES
from concealing.wheel_signature import left_by_motors
from testbed.dynamics.environment import EARTH, EARTH_RADIUS
from testbed.dynamics.gravity_gradient import gravity_gradient_torque
from testbed.records.record import Record, RunDetails

REQUIREMENT = "bsk==2.12.1"
SCRIPT = Path(__file__).with_name("foreign") / "basilisk_strangers.py"
MULTIPLES = (2.0, 4.0)
"""Sizes of effects, in smallest detectable sizes; those of pairs are of the larger."""
NULL_SHARE, PAIR_SHARE = 0.25, 0.125
"""Of the cases: a hundred and fifty of four hundred."""
DROPPED = 2
"""First readings of a run that are left out: imuSensor says zero when it is called first, which may be late."""
_ATTEMPTS = 20
_DURATION = (30.0, 40.0)
_RUNS = (2, 3, 3)
_KNOTS = (4.0, 8.0)
"""s between two corners of the wanted body rate; between them its acceleration is constant."""
_DIAGONAL, _PRODUCTS = 0.03, 0.02
"""Standard deviations of the inertia's errors, as in `concealing.wheel_set`."""
_RELEASE_SHARE = 0.02
"""Standard deviation of the body rate at release, of the largest rate that is asked for."""
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
    python = environment("basilisk-venv", REQUIREMENT)
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


def stranger_orders(name: str, cases: int, seed: int) -> list[Order]:
    """Return the cases of a platform in their random order; effects and sizes take turns, so that each gets its share.

    Args:
        name: of the platform.
        cases: how many.
        seed: of the set.
    """
    rng, kinds = order_generator(seed), PLATFORMS[name].kinds
    null, pairs = round(NULL_SHARE * cases), round(PAIR_SHARE * cases)
    single = turns(rng, product(kinds, MULTIPLES), cases - null - pairs)
    first = turns(rng, kinds, pairs)
    wanted = [
        *[("null", None, None)] * null,
        *(("single", *each) for each in single),
        *(("pair", effect, MULTIPLES[-1]) for effect in first),
    ]
    return shuffled(wanted, rng)


def make_stranger(order: Order, seed: int, scenario: Path, data: Path, answers: Path) -> Path:
    """Make one case where it is not whole yet; return its data folder.

    Args:
        order: of the case.
        seed: of the set.
        scenario: of the platform, the nominal one.
        data: folder of the set's records.
        answers: folder of its answers.
    """
    folder = data / case_name(order)
    name = next(name for name, platform in PLATFORMS.items() if platform.scenario == scenario)
    if not (folder / SEAL).exists():
        with engine() as flying:
            case = stranger_case(order, seed, name, flying)
            flown = flying.fly(case)
        records = [record_of(case.platform, each, index) for index, each in enumerate(flown)]
        write_sealed(_answer(case, flown), records, folder, answers / case_name(order))
    return folder


def stranger_case(order: Order, seed: int, name: str, flying: Engine) -> StrangerCase:
    """Return a case as it was ordered.

    Raises:
        UnreachableError: no data set shows its effects as much.
    """
    rng = case_generator(seed, order)
    for _ in range(_ATTEMPTS):
        case = _bare_case(rng, name)
        if order.effect is None:
            return case
        try:
            return _with_effects(rng, case, order, flying)
        except UnreachableError:
            continue
    raise UnreachableError(f"{order.effect}: no data set out of {_ATTEMPTS} can show it at {order.multiple}")


def _bare_case(rng: np.random.Generator, name: str) -> StrangerCase:
    platform = PLATFORMS[name]
    moments = np.diag(platform.numbers.inertia)
    products = np.sqrt(moments[[1, 0, 0]] * moments[[2, 2, 1]])
    error = (*_DIAGONAL * moments * rng.standard_normal(3), *_PRODUCTS * products * rng.standard_normal(3))
    return StrangerCase(
        platform=name,
        seed=int(rng.integers(2**62)),
        duration=float(round(rng.uniform(*_DURATION))),
        runs=tuple(_drawn_run(rng, platform) for _ in range(int(rng.choice(_RUNS)))),
        theta_error=tuple(map(float, error)),
    )


def _drawn_run(rng: np.random.Generator, platform: Platform) -> Run:
    motion, gyro, navigation = (int(each) for each in rng.integers(1, 2**31, 3))
    release = _RELEASE_SHARE * platform.largest_rate * rng.standard_normal(3)
    return Run(motion=motion, gyro=gyro, navigation=navigation, release_error=tuple(map(float, release)))


def _with_effects(rng: np.random.Generator, case: StrangerCase, order: Order, flying: Engine) -> StrangerCase:
    """Return a case with its effects, each of the size that it alone has to have."""
    kinds = PLATFORMS[case.platform].kinds
    names = [order.effect]
    if order.stratum == "pair":
        names.append(str(rng.choice([each for each in kinds if each != order.effect])))
    found = [_sized(rng, case, name, order.multiple, flying) for name in names]
    sizes = {f"sigma_{index + 1}": shown for index, (_, shown) in enumerate(found)}
    notes = sizes if order.stratum == "pair" else {"sigma": found[0][1]}
    return replace(
        case,
        effects=tuple(hidden for hidden, _ in found),
        stratum=order.stratum,
        notes={"detectable_sizes": order.multiple, **notes},
    )


def _sized(
    rng: np.random.Generator, case: StrangerCase, effect: str, times: float, flying: Engine
) -> tuple[HiddenEffect, float]:
    kind = PLATFORMS[case.platform].kinds[effect]
    typical = HiddenEffect(effect=effect, component=str(rng.choice(kind.components)), parameters=kind.draw(rng))
    tests = sum(len(each.components) for each in {**FLYING, **PLATFORMS[case.platform].kinds}.values())
    target = times * detectable_norm(degrees_of(kind, typical, len(case.runs)), tests)
    return searched(kind, typical, target, lambda tried: signal(replace(case, effects=(tried,)), flying))


def signal(case: StrangerCase, flying: Engine) -> float:
    """Return the norm of the whitened signature of a case's effects, in sigma, flown without the gyro's noise.

    Raises:
        UnreachableError: there is no such craft.
    """
    known, flown = PLATFORMS[case.platform].numbers.sensors, flying.fly(case, quiet=True)
    parts = [left_unexplained(case, flown) / known.gyro_noise]
    if any(effect.effect in IN_DRIVES for effect in case.effects):
        parts.append(left_by_drives(case, flown) / np.hypot(known.tachometer_noise, known.gyro_noise))
    return float(np.sqrt(sum(float(part @ part) for part in parts)))


def left_unexplained(case: StrangerCase, flown: Sequence[Flown]) -> Array:
    """Return what of the gyro's readings the nominal model leaves, inertia and initial rates its own, flat, rad/s."""
    numbers = PLATFORMS[case.platform].numbers
    released = np.stack([run.true_body_rate[0] for run in flown])
    rates = predictions(_telemetry(case, flown), 1.0 / numbers.control_rate, *nudged(case.craft.inertia, released))
    shown = np.stack([run.body_rate for run in flown], axis=1)
    return unexplained(shown, rates, lambda values: values[DROPPED:].ravel())


def _telemetry(case: StrangerCase, flown: Sequence[Flown]) -> Telemetry:
    """What the true speeds and the nominal drawing say of the wheels, and what the believed orbit does."""
    platform = PLATFORMS[case.platform]
    wheels = platform.numbers.wheels
    speed = np.stack([run.true_wheel_speed for run in flown], axis=1)
    torque = np.zeros((*speed.shape[:2], 3))
    if platform.altitude is not None:
        rate = np.sqrt(EARTH / (EARTH_RADIUS + platform.altitude) ** 3)
        torque = np.stack([_gradient(run, rate, case.craft.inertia) for run in flown], axis=1)
    return Telemetry((wheels.spin_inertia * speed) @ wheels.axis, np.zeros((*speed.shape[:2], 3, 3)), torque)


def _gradient(run: Flown, rate: float, inertia: Array) -> Array:
    """Return the believed torque of the gravity gradient, (K, 3), N·m; down is z of N, and turns with the orbit."""
    turned = rate * run.true_time
    down_N = np.column_stack([-np.sin(turned), np.zeros_like(turned), np.cos(turned)])
    down_B = Rotation.from_mrp(run.true_attitude_mrp).inv().apply(down_N)
    return gravity_gradient_torque(inertia, down_B, rate)


def left_by_drives(case: StrangerCase, flown: Sequence[Flown]) -> Array:
    """Return what of the tachometers' readings the nominal motors and bearings leave, flat, rad/s."""
    numbers = PLATFORMS[case.platform].numbers
    parts = [
        left_by_motors(
            numbers.wheels, run.time, run.true_wheel_speed[::2], run.true_body_rate[::2], run.wheel_torque_command
        )[DROPPED:]
        for run in flown
    ]
    return np.concatenate([(each - each.mean(axis=0)).ravel() for each in parts])


def record_of(name: str, flown: Flown, index: int) -> Record:
    """Return a run as the project's records have it.

    Basilisk's readings are in SI units and in body axes already. A command stands at the reading from which on it
    holds. An MRP is turned into the quaternion q_NB of the same rotation, scalar first.

    Args:
        name: of the platform.
        flown: its channels.
        index: of the run.
    """
    platform = PLATFORMS[name]
    channels = {
        "body_rate": flown.body_rate,
        "wheel_speed": flown.wheel_speed,
        "wheel_torque_command": flown.wheel_torque_command,
    }
    if platform.altitude is not None:
        channels["attitude"] = Rotation.from_mrp(flown.attitude_mrp).as_quat(canonical=True)[:, [3, 0, 1, 2]]
    return Record(
        time=flown.time[DROPPED:],
        channels={key: values[DROPPED:] for key, values in channels.items()},
        details=RunDetails(name=f"run_{index + 1}", gyro_noise=platform.numbers.sensors.gyro_noise),
    )


def _answer(case: StrangerCase, flown: Sequence[Flown]) -> str:
    craft, inertia = case.craft, case.craft.inertia
    rows, columns = (0, 1, 2, 1, 0, 0), (0, 1, 2, 2, 2, 1)
    content = {
        "notes": case.notes,
        "true_theta_kg_m2": inertia[rows, columns].tolist(),
        "initial_rates_rad_s": [run.true_body_rate[0].tolist() for run in flown],
        "case": asdict(case),
    }
    hidden = [answered(craft, each) for each in case.effects]
    return sealed_text(case.seed, case.stratum, hidden, PLATFORMS[case.platform].kinds, content)
