"""A case that was asked for: these effects, of this size, in so many runs; what is left open is drawn."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from concealing.case import Case
from concealing.library import KINDS, LISTED, UNLISTED
from concealing.power import UnreachableError
from concealing.strata import (
    ATTEMPTS,
    MULTIPLES,
    NEVER_HIDDEN,
    UNLISTED_SIGMA,
    bare_case,
    drawn_actuation,
    drawn_run,
    drawn_telemetry,
    hidden_effect,
    unlisted_effect,
)


def any_effect(rng: np.random.Generator) -> str:
    """Draw the id of a listed effect."""
    return str(rng.choice([name for name in LISTED if name not in NEVER_HIDDEN]))


def asked_case(
    rng: np.random.Generator,
    scenario: Path,
    effects: Sequence[str],
    size: float | None = None,
    runs: int | None = None,
) -> Case:
    """Draw a case with certain effects.

    Args:
        rng: source of all randomness.
        scenario: the nominal one.
        effects: ids; none for a set without any.
        size: of each alone, in smallest detectable sizes, or in sigma where it is unlisted; None to draw it.
        runs: how many; None to draw it.

    Raises:
        ValueError: an effect is not known, or they cannot be together, or no data set shows one as much as asked for.
    """
    _check(effects)
    for _ in range(ATTEMPTS):
        try:
            return _drawn(rng, scenario, effects, size, runs)
        except UnreachableError as error:
            reason = error
    raise ValueError(f"no data set out of {ATTEMPTS} shows as much as asked for: {reason}; ask for a smaller --size")


def _check(effects: Sequence[str]) -> None:
    hideable = [name for name in KINDS if name not in NEVER_HIDDEN]
    for name in effects:
        if name not in hideable:
            raise ValueError(f"--effect {name}: cannot be hidden; what can: {', '.join(hideable)}")
    if len(set(effects)) < len(effects):
        raise ValueError("--effect: give each effect once")
    if effects and not _possible(effects):
        raise ValueError(f"--effect: no platform can have all of {', '.join(effects)}: they need other actuators")


def _possible(effects: Sequence[str]) -> list[str]:
    """Return the actuation of platforms that can have all of some effects."""
    return [kind for kind in KINDS[effects[0]].actuation if all(kind in KINDS[name].actuation for name in effects)]


def _drawn(
    rng: np.random.Generator, scenario: Path, effects: Sequence[str], size: float | None, runs: int | None
) -> Case:
    actuation = drawn_actuation(rng, effects[0] if effects else None)
    if effects and actuation not in _possible(effects):
        actuation = "cmg" if "cmg" in _possible(effects) else "applied_torque"
    case = bare_case(rng, scenario, actuation, effects[0] if effects else None)
    case = replace(case, telemetry=drawn_telemetry(rng, *effects))
    count = len(case.runs) if runs is None else runs
    case = replace(case, runs=tuple(drawn_run(rng, case.telemetry.gyro_rate) for _ in range(count)))
    return _with_effects(rng, case, effects, size)


def _with_effects(rng: np.random.Generator, case: Case, effects: Sequence[str], size: float | None) -> Case:
    unlisted = any(name in UNLISTED for name in effects)
    wanted = float(rng.choice(UNLISTED_SIGMA if unlisted else MULTIPLES)) if size is None else size
    hidden, notes = [], {}
    for number, name in enumerate(effects, start=1):
        effect, shown = (unlisted_effect if name in UNLISTED else hidden_effect)(rng, case, name, wanted)
        hidden.append(effect)
        notes[f"sigma_{number}" if len(effects) > 1 else "sigma"] = shown
    sized_in = {"wanted_sigma" if unlisted else "detectable_sizes": wanted} if effects else {}
    stratum = "unlisted" if unlisted else ("null", "single", "pair")[min(len(effects), 2)]
    return replace(case, effects=tuple(hidden), stratum=stratum, notes=sized_in | notes)
