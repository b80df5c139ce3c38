"""Random cases of each part of the score card. What is recorded, and how well, never depends on what is hidden,
but that an effect which only unit telemetry shows gets it, and more noise than stated is beside a statement."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Literal

import numpy as np

from concealing.case import Case, Run, Telemetry
from concealing.effect import CLUSTER, GYRO, PLATFORM, HiddenEffect, direction
from concealing.flown import sensors_of
from concealing.guidance import pool
from concealing.library import KINDS, LISTED, UNLISTED
from concealing.power import UnreachableError
from concealing.sizing import detectable, sized

Stratum = Literal["null", "single", "pair", "unlisted", "sigma_understated", "sigma_overstated", "flown"]
MULTIPLES = (0.5, 1.0, 2.0, 4.0, 8.0)
"""Sizes of single effects, in smallest detectable sizes."""
UNLISTED_SIGMA = (8.0, 16.0)
"""Sizes of unlisted effects, in sigma."""
PAIR_MULTIPLE = 4.0
FLOWN_MULTIPLES = (2.0, 4.0)
"""Sizes of single effects that are flown in MuJoCo, in smallest detectable sizes."""
FLOWN_EFFECTS = (
    *("viscous_drag", "quadratic_drag", "body_torque", "inertial_torque", "tether", "contact"),
    *("flexible_appendage", "slosh"),
    *("rotor_speed", "rotor_spin_down", "gimbal_zero", "gimbal_misalignment", "gimbal_viscous_friction"),
    *("gyro_bias", "gyro_drift", "gyro_scale", "gyro_misalignment", "gyro_latency", "gyro_bandwidth", "gyro_noise"),
)
"""Those that an MJCF, or a torque or reading beside it, holds as well as the equations of motion do."""
_LOOK_ALIKES = (
    {"gyro_latency", "gyro_bandwidth"},
    {"body_torque", "inertial_torque", "gyro_drift"},
    {"viscous_drag", "quadratic_drag", "tether"},
    {"gyro_noise", "gyro_quantization"},
    {"gimbal_viscous_friction", "gimbal_coulomb_friction"},
)
"""Effects that no pair has both of: nobody could say which two they were."""
_MISSTATED = 0.2
_APPLIED_SHARE = 0.1
ATTEMPTS = 20
NEVER_HIDDEN = {"inertia"}
"""Every case has an inertia of its own: it is re-estimated, and no verdict."""


def random_case(
    rng: np.random.Generator,
    stratum: Stratum,
    scenario: Path,
    effect: str | None = None,
    multiple: float | None = None,
) -> Case:
    """Draw a case.

    Args:
        rng: source of all randomness.
        stratum: part of the score card.
        scenario: the nominal one.
        effect: id of the (first) effect; None for any.
        multiple: its size, in smallest detectable sizes, or sigma where it is unlisted; None for any of the stratum's.
    """
    draw = _DRAWN[stratum]
    for _ in range(ATTEMPTS):
        try:
            return draw(rng, scenario, effect, multiple)
        except UnreachableError:
            continue
    raise UnreachableError(f"{stratum}, {effect}: no data set out of {ATTEMPTS} can show it at {multiple}")


def _null(rng: np.random.Generator, scenario: Path, effect: str | None, multiple: float | None) -> Case:  # noqa: ARG001
    return bare_case(rng, scenario, drawn_actuation(rng, None), None)


def _single(rng: np.random.Generator, scenario: Path, effect: str | None, multiple: float | None) -> Case:
    chosen = _chosen(rng, LISTED, effect)
    case = bare_case(rng, scenario, drawn_actuation(rng, chosen), chosen)
    times = float(rng.choice(MULTIPLES)) if multiple is None else multiple
    hidden, shown = hidden_effect(rng, case, chosen, times)
    notes = {"detectable_sizes": times, "sigma": shown}
    return replace(case, effects=(hidden,), stratum="single", notes=notes)


def _pair(rng: np.random.Generator, scenario: Path, effect: str | None, multiple: float | None) -> Case:
    """Two effects of different ids in one CMG platform, each sized alone."""
    cmg = {name: kind for name, kind in LISTED.items() if "cmg" in kind.actuation}
    first = _chosen(rng, cmg, effect)
    second = _chosen(rng, {name: kind for name, kind in cmg.items() if not _alike(name, first)}, None)
    case = replace(bare_case(rng, scenario, "cmg", first), telemetry=drawn_telemetry(rng, first, second))
    times = PAIR_MULTIPLE if multiple is None else multiple
    pair = [hidden_effect(rng, case, name, times) for name in (first, second)]
    notes: dict[str, float | str] = {"detectable_sizes": times} | {
        f"sigma_{index + 1}": shown for index, (_, shown) in enumerate(pair)
    }
    return replace(case, effects=tuple(hidden for hidden, _ in pair), stratum="pair", notes=notes)


def _unlisted(rng: np.random.Generator, scenario: Path, effect: str | None, multiple: float | None) -> Case:
    chosen = _chosen(rng, UNLISTED, effect)
    case = bare_case(rng, scenario, drawn_actuation(rng, chosen), chosen)
    target = float(rng.choice(UNLISTED_SIGMA)) if multiple is None else multiple
    hidden, shown = unlisted_effect(rng, case, chosen, target)
    notes = {"wanted_sigma": target, "sigma": shown}
    return replace(case, effects=(hidden,), stratum="unlisted", notes=notes)


def _understated(rng: np.random.Generator, scenario: Path, effect: str | None, multiple: float | None) -> Case:  # noqa: ARG001
    """The gyro is 1 / 0.8 times as noisy as stated: `gyro_noise` is the answer."""
    case = bare_case(rng, scenario, drawn_actuation(rng, None), None)
    extra = sensors_of(case).gyro_noise * np.sqrt(1.0 / (1.0 - _MISSTATED) ** 2 - 1.0)
    louder = HiddenEffect(effect="gyro_noise", component=GYRO, parameters={"extra_noise": float(extra)})
    stated = replace(case.telemetry, stated_noise=1.0)
    return replace(case, telemetry=stated, effects=(louder,), stratum="sigma_understated")


def _overstated(rng: np.random.Generator, scenario: Path, effect: str | None, multiple: float | None) -> Case:  # noqa: ARG001
    """More noise is stated than there is: the answer is none, with a notice."""
    case = bare_case(rng, scenario, drawn_actuation(rng, None), None)
    stated = replace(case.telemetry, stated_noise=1.0 + _MISSTATED)
    return replace(case, telemetry=stated, stratum="sigma_overstated")


def _flown(rng: np.random.Generator, scenario: Path, effect: str | None, multiple: float | None) -> Case:
    """A case that MuJoCo flies; without an effect unless one is named."""
    case = replace(bare_case(rng, scenario, "cmg", effect), simulator="mujoco", stratum="flown")
    if effect is None:
        return case
    times = float(rng.choice(FLOWN_MULTIPLES)) if multiple is None else multiple
    hidden, shown = hidden_effect(rng, case, effect, times)
    return replace(case, effects=(hidden,), notes={"detectable_sizes": times, "sigma": shown})


_DRAWN: dict[str, Callable[[np.random.Generator, Path, str | None, float | None], Case]] = {
    "null": _null,
    "single": _single,
    "pair": _pair,
    "unlisted": _unlisted,
    "sigma_understated": _understated,
    "sigma_overstated": _overstated,
    "flown": _flown,
}


def _alike(one: str, other: str) -> bool:
    return one == other or any({one, other} <= alike for alike in _LOOK_ALIKES)


def drawn_actuation(rng: np.random.Generator, effect: str | None) -> Literal["cmg", "applied_torque"]:
    """Return what turns the platform: with or without an effect, the same share is under applied torque."""
    applied = rng.random() < _APPLIED_SHARE
    possible = ("cmg", "applied_torque") if effect is None else KINDS[effect].actuation
    wanted: Literal["cmg", "applied_torque"] = "applied_torque" if applied else "cmg"
    return wanted if wanted in possible else possible[0]


def _chosen(rng: np.random.Generator, among: dict, effect: str | None) -> str:
    return effect or str(rng.choice([name for name in among if name not in NEVER_HIDDEN]))


def hidden_effect(rng: np.random.Generator, case: Case, effect: str, times: float) -> tuple[HiddenEffect, float]:
    """Draw a listed effect of so many detectable sizes; return it and its signature's norm in sigma."""
    kind = KINDS[effect]
    drawn = HiddenEffect(effect=effect, component=str(rng.choice(kind.components)), parameters=kind.draw(rng))
    typical = drawn.in_one_of(len(case.runs))
    return sized(case, typical, times * detectable(case, typical))


def small_effects(rng: np.random.Generator, case: Case, count: int, times: float) -> tuple[HiddenEffect, ...]:
    """Draw so many listed effects of different ids for a CMG platform, each of so many detectable sizes alone.

    What is drawn shows in what the case records; no two look alike.
    """
    possible = [name for name, kind in LISTED.items() if "cmg" in kind.actuation and not _sits_inside(name)]
    names: list[str] = []
    for name in rng.permutation([each for each in possible if each not in NEVER_HIDDEN]):
        if len(names) < count and not any(_alike(str(name), other) for other in names):
            names.append(str(name))
    bare = replace(case, effects=())
    return tuple(hidden_effect(rng, bare, name, times)[0] for name in names)


def unlisted_effect(rng: np.random.Generator, case: Case, effect: str, sigma: float) -> tuple[HiddenEffect, float]:
    """Draw an effect of no library whose signature has a norm in sigma; return it and the norm that it has."""
    return sized(case, HiddenEffect(effect=effect, component=PLATFORM, parameters=KINDS[effect].draw(rng)), sigma)


def bare_case(
    rng: np.random.Generator, scenario: Path, actuation: Literal["cmg", "applied_torque"], effect: str | None
) -> Case:
    """Draw everything but the effect."""
    telemetry = drawn_telemetry(rng, effect)
    count = int(rng.choice((2, 3, 4, 5, 5, 5, 6)))
    diagonal, off_diagonal = 6.6e-4 * rng.standard_normal(3), 2e-4 * rng.standard_normal(3)
    return Case(
        scenario=scenario,
        seed=int(rng.integers(2**62)),
        runs=tuple(drawn_run(rng, telemetry.gyro_rate) for _ in range(count)),
        theta_error=tuple(map(float, (*diagonal, *off_diagonal))),
        telemetry=telemetry,
        actuation=actuation,
        feedback=bool(rng.random() < 0.8),
    )


def drawn_run(rng: np.random.Generator, gyro_rate: float) -> Run:
    """Draw a run: its length, its maneuver, its release."""
    spin = rng.uniform(0.05, 0.3) * direction(rng) * (rng.random() < 0.5)
    return Run(
        duration=float(round(rng.uniform(2.0, 5.0) * gyro_rate) / gyro_rate),
        maneuver=int(rng.integers(len(pool()))),
        planned_spin=tuple(map(float, np.round(spin, 3) + 0.0)),  # no negative zeros
        release_error=tuple(map(float, 0.01 * rng.standard_normal(3))),
    )


def drawn_telemetry(rng: np.random.Generator, *effects: str | None) -> Telemetry:
    """Draw what is recorded; where an effect sits inside the units, what shows it is recorded."""
    inside = any(_sits_inside(effect) for effect in effects)
    drawn = rng.random(7)
    return Telemetry(
        gyro_rate=float(rng.choice((16.0, 50.0, 100.0), p=(0.6, 0.2, 0.2))),
        momentum="cluster_momentum" if drawn[0] < 0.1 and not inside else "gimbal_angle",
        tachometers=bool(drawn[1] < 0.7),
        gimbal_torque=bool(drawn[2] < 0.7 or inside),
        rate_command=bool(drawn[3] < 0.7 or inside),
        encoder_noise=float(rng.choice((1e-4, 3e-4, 1e-3), p=(0.6, 0.3, 0.1))),
        encoder_step=float(rng.choice((0.0, 2.0 * np.pi / 2**14), p=(0.7, 0.3))),
        dropouts=float(rng.uniform(0.02, 0.1)) if drawn[4] < 0.15 else 0.0,
        outliers=float(rng.uniform(0.003, 0.015)) if drawn[5] < 0.15 else 0.0,
        stated_noise=None if drawn[6] < 0.15 and "gyro_noise" not in effects else 1.0,
    )


def _sits_inside(effect: str | None) -> bool:
    return effect is not None and any(part == CLUSTER or part.startswith("cmg") for part in KINDS[effect].components)
