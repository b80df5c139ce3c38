"""Blind sets of craft with wheels: without an effect, or with one of two or four detectable sizes.

What is recorded, and how well, never depends on what is hidden. Cases stand in random order; each is a function of the
set's seed and of its number.
"""

from __future__ import annotations

from dataclasses import asdict, replace
from itertools import product
from pathlib import Path

import numpy as np

from concealing.effect import HiddenEffect
from concealing.order import Order, case_generator, case_name, order_generator, shuffled, turns
from concealing.power import NOISES, UnreachableError, degrees_of, detectable_norm, noise_sized, searched
from concealing.sealing import SEAL, kept_rows, sealed_text, spiked, write_sealed
from concealing.wheel_case import WheelCase, WheelRun, platform_of
from concealing.wheel_flight import FlownWheels, fly_wheels, shown_speed, theta
from concealing.wheel_signature import signal
from testbed.records.record import Record, RunDetails

NULL_SHARE = 0.3
"""Of the cases, which have no effect: 60 of 200."""
MULTIPLES = (2.0, 4.0)
"""Sizes of effects, in smallest detectable sizes."""
_ATTEMPTS = 20
_DURATION_FREE, _DURATION_STANDING = (40.0, 60.0), (20.0, 30.0)
"""s; the maneuvers of the shipped scenarios take 60 and 40 s."""
_DIAGONAL, _PRODUCTS = 0.03, 0.02
"""Standard deviations of the inertia's errors, as shares of a principal moment and of the geometric mean of two: as
far as the shipped truths are from what is believed of them."""
_RELEASE_ERROR = 0.003
"""rad/s, of each axis."""


def wheel_orders(scenario: Path, cases: int, seed: int) -> list[Order]:
    """Return the cases of a set in their random order; effects and sizes take turns, so that each gets its share.

    Args:
        scenario: the nominal one.
        cases: how many.
        seed: of the set.
    """
    rng, null = order_generator(seed), round(NULL_SHARE * cases)
    listed = product(platform_of(scenario).drawn, MULTIPLES)
    hidden = (("single", *each) for each in turns(rng, listed, cases - null))
    return shuffled([*[("null", None, None)] * null, *hidden], rng)


def make_wheels(order: Order, seed: int, scenario: Path, data: Path, answers: Path) -> Path:
    """Make one case where it is not whole yet; return its data folder."""
    name = case_name(order)
    if not (data / name / SEAL).exists():
        conceal_wheels(wheel_case_of(order, seed, scenario), data / name, answers / name)
    return data / name


def wheel_case_of(order: Order, seed: int, scenario: Path) -> WheelCase:
    """Return a case as it was ordered.

    Raises:
        UnreachableError: no data set shows its effect as much.
    """
    rng = case_generator(seed, order)
    for _ in range(_ATTEMPTS):
        case = _bare_case(rng, scenario, order.effect)
        if order.effect is None:
            return case
        try:
            return with_hidden(rng, case, order.effect, order.multiple)
        except UnreachableError:
            continue
    raise UnreachableError(f"{order.effect}: no data set out of {_ATTEMPTS} can show it at {order.multiple}")


def with_hidden(rng: np.random.Generator, case: WheelCase, effect: str, times: float) -> WheelCase:
    """Return a case with an effect of so many detectable sizes, at a component that is drawn.

    Raises:
        UnreachableError: it does not show as much at any size.
    """
    platform = platform_of(case.scenario)
    kind = platform.kinds[effect]
    drawn = HiddenEffect(effect=effect, component=str(rng.choice(kind.components)), parameters=kind.draw(rng))
    typical = drawn.in_one_of(len(case.runs))
    hypotheses = sum(len(each.components) for each in platform.drawn.values())
    target = times * detectable_norm(degrees_of(kind, typical, len(case.runs)), hypotheses)
    if effect in NOISES:
        samples = sum(run.duration for run in case.runs) * platform.gyro_rate
        hidden, shown = noise_sized(typical, target, samples, platform.sensors.gyro_noise), target
    else:
        hidden, shown = searched(kind, typical, target, lambda tried: signal(replace(case, effects=(tried,))))
    return replace(case, effects=(hidden,), stratum="single", notes={"detectable_sizes": times, "sigma": shown})


def _bare_case(rng: np.random.Generator, scenario: Path, effect: str | None) -> WheelCase:
    """Draw everything but the effect; the noise is stated where the effect is noise."""
    platform, drawn = platform_of(scenario), rng.random(3)
    longest = _DURATION_FREE if platform.pivot is None else _DURATION_STANDING
    moments = np.diag(platform.inertia)
    products = np.sqrt(moments[[1, 0, 0]] * moments[[2, 2, 1]])
    error = (*_DIAGONAL * moments * rng.standard_normal(3), *_PRODUCTS * products * rng.standard_normal(3))
    return WheelCase(
        scenario=scenario,
        seed=int(rng.integers(2**62)),
        runs=tuple(_drawn_run(rng, longest) for _ in range(int(rng.choice((2, 3, 3, 4))))),
        theta_error=tuple(map(float, error)),
        dropouts=float(rng.uniform(0.02, 0.1)) if drawn[0] < 0.15 else 0.0,
        outliers=float(rng.uniform(0.003, 0.015)) if drawn[1] < 0.15 else 0.0,
        stated_noise=None if drawn[2] < 0.15 and effect not in NOISES else 1.0,
    )


def _drawn_run(rng: np.random.Generator, duration: tuple[float, float]) -> WheelRun:
    return WheelRun(
        duration=float(round(rng.uniform(*duration))),
        motion=int(rng.integers(2**62)),
        at_rest=bool(rng.random() < 0.5),
        release_error=tuple(map(float, _RELEASE_ERROR * rng.standard_normal(3))),
    )


def conceal_wheels(case: WheelCase, data_folder: Path, answer_folder: Path) -> FlownWheels:
    """Fly a case, write its records, seal its answer.

    Args:
        case: what to fly.
        data_folder: new or empty.
        answer_folder: new or empty; another one.
    """
    flown = fly_wheels(case)
    records = [wheel_record(flown, index) for index in range(len(case.runs))]
    write_sealed(_answer(flown), records, data_folder, answer_folder)
    return flown


def wheel_record(flown: FlownWheels, index: int) -> Record:
    """Return one run as its telemetry tells it, spikes and gaps included."""
    case, log, ticks = flown.case, flown.log, flown.rows[index]
    noise, time = flown.platform.sensors.gyro_noise, flown.log.time[ticks]
    scatter = log.reading - log.wheel_speed - flown.craft.wheels.speed_bias
    held = np.floor((time - flown.craft.telemetry_late) / flown.clock.period + 1e-9)
    held = np.clip(held, 0, flown.clock.ticks).astype(int)
    channels = {
        "body_rate": spiked(case.seed, index, case.outliers, log.gyro[ticks, index], noise),
        "wheel_speed": (shown_speed(flown, time) + scatter[ticks])[:, index],
        "wheel_torque_command": log.command[held, index],
        "wheel_torque": log.torque[held, index],
    }
    kept = kept_rows(case.seed, index, case.dropouts, len(ticks))
    stated = None if case.stated_noise is None else case.stated_noise * noise
    return Record(
        time=time[kept],
        channels={name: values[kept] for name, values in channels.items()},
        details=RunDetails(name=f"run_{index + 1}", gyro_noise=stated),
    )


def _answer(flown: FlownWheels) -> str:
    case, noise = flown.case, flown.platform.sensors.gyro_noise
    content = {
        "notes": case.notes,
        "true_theta_kg_m2": theta(flown.craft),
        "initial_rates_rad_s": flown.log.body_rate[0].tolist(),
        "gyro_noise_rad_s": np.hypot(noise, flown.craft.gyro.extra_noise).tolist(),
        "stated_over_nominal_noise": case.stated_noise,
        "case": asdict(case) | {"scenario": case.scenario.name},
    }
    return sealed_text(case.seed, case.stratum, case.effects, flown.platform.kinds, content)
