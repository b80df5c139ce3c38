"""Small blind cases: three short runs at 16 Hz, gimbal angles and tachometers, one effect or none."""

from __future__ import annotations

from dataclasses import replace
from typing import Literal

import numpy as np

from concealing.case import Case, Run, Telemetry
from concealing.effect import HiddenEffect
from concealing.library import KINDS, UNLISTED
from concealing.sizing import detectable, sized
from concealing.strata import bare_case
from support.diagnosed_records import SCENARIO

RUNS = 3
SECONDS = 2.0
SPIN = 0.2
"""rad/s at release of two of the runs: it separates what reads the rate from the inertia."""
INSIDE = ("gimbal_viscous_friction",)
"""Effects that only the motor torque shows; it is recorded with these alone, for the time that it takes."""


def blind_case(
    seed: int,
    effect: str | None = None,
    component: str = "",
    size: float = 4.0,
    actuation: Literal["cmg", "applied_torque"] = "cmg",
) -> Case:
    """Return a case.

    Args:
        seed: of everything.
        effect: hidden in it; None for none.
        component: where.
        size: in smallest detectable sizes; in sigma where no library lists the effect.
        actuation: what turns the platform.
    """
    rng = np.random.default_rng(seed)
    inside = effect in INSIDE
    telemetry = Telemetry(gimbal_torque=inside, rate_command=False, encoder_noise=1e-4, encoder_step=0.0)
    case = replace(bare_case(rng, SCENARIO, actuation, effect), telemetry=telemetry, feedback=True)
    case = replace(case, runs=tuple(_short(run, index) for index, run in enumerate((*case.runs, *case.runs)[:RUNS])))
    if effect is None:
        return case
    drawn = HiddenEffect(effect=effect, component=component, parameters=KINDS[effect].draw(rng))
    typical = drawn.in_one_of(RUNS)
    unlisted = effect in UNLISTED
    hidden, shown = sized(case, typical, size if unlisted else size * detectable(case, typical))
    notes = {"wanted_sigma" if unlisted else "detectable_sizes": size, "sigma": shown}
    return replace(case, effects=(hidden,), stratum="unlisted" if unlisted else "single", notes=notes)


def _short(run: Run, index: int) -> Run:
    spin = tuple(SPIN * float(axis == index) for axis in range(3)) if index < 2 else (0.0, 0.0, 0.0)
    return replace(run, duration=SECONDS, maneuver=index, planned_spin=spin)
