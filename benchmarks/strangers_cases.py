"""The blind cases that Basilisk flies: drawn, sized, flown, written as records, and their answers sealed.

Each case is a function of the set's seed and of its number. How large an effect is, is seen by flying the case without
noise of gyro and encoders and asking what of its readings the nominal model leaves (`concealing.nominal`), inertia and
initial rates projected out: its norm in standard deviations is two or four times the smallest that can be seen.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, replace
from itertools import product
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from benchmarks.strangers_effects import answered
from benchmarks.strangers_engine import PLATFORMS, Engine, Flown, Platform, Run, StrangerCase, engine
from concealing.craft import Array
from concealing.effect import HiddenEffect
from concealing.nominal import Telemetry, nudged, predictions, unexplained
from concealing.order import Order, case_generator, case_name, order_generator, shuffled, turns
from concealing.power import UnreachableError, degrees_of, detectable_norm, searched
from concealing.sealing import SEAL, sealed_text, write_sealed
from concealing.wheel_effects import FLYING, IN_DRIVES
from concealing.wheel_signature import left_by_motors
from testbed.dynamics.environment import EARTH, EARTH_RADIUS
from testbed.dynamics.gravity_gradient import gravity_gradient_torque
from testbed.records.record import Record, RunDetails

MULTIPLES = (2.0, 4.0)
"""Sizes of effects, in smallest detectable sizes; those of pairs are of the larger."""
NULL_SHARE, PAIR_SHARE = 0.25, 0.125
"""Of the cases: a hundred and fifty of four hundred."""
DROPPED = 2
"""First readings of a run that are left out: imuSensor says zero when it is called first, which may be late."""
_ATTEMPTS = 20
_DURATION = (30.0, 40.0)
_RUNS = (2, 3, 3)
_DIAGONAL, _PRODUCTS = 0.03, 0.02
"""Standard deviations of the inertia's errors, as in `concealing.wheel_set`."""
_RELEASE_SHARE = 0.02
"""Standard deviation of the body rate at release, of the largest rate that is asked for."""


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
