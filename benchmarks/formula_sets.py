"""Sets with a torque by a random formula, hidden by the concealing engine, and what is right to say of them.

Of every five sets one has no effect; the others hide a law of each family in turns, at 8 and at 16 sigma. A set is a
function of the seed and its number. It has five runs of 5 s at 16 Hz of the shipped platform.
"""

from __future__ import annotations

import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import count
from pathlib import Path

import numpy as np

from concealing.case import Case, Run
from concealing.effect import HiddenEffect, Parameters, vector
from concealing.files import record
from concealing.flown import fly_case
from concealing.formula_effects import LAWS, drawn_law
from concealing.guidance import pool
from concealing.library import KINDS
from concealing.power import UnreachableError
from concealing.sizing import sized
from testbed.arrays import Array
from testbed.assembly.platform import nominal_platform
from testbed.diagnosis.reading import DataSet, data_set_of
from testbed.formulas.grammar import classes
from testbed.formulas.motion import ATTITUDES
from testbed.formulas.pattern import PLACEMENTS, Pattern, pattern_of
from testbed.records.reading import read_data_set
from testbed.records.writing import write_record
from testbed.scenario.reader import read_scenario

SCENARIO = Path("scenarios/diagnose.toml")
SIGMAS = (8.0, 16.0)
NULL_EVERY = 5
"""Of so many sets the last one has no effect."""
NO_LAW = "none"
"""Family of a set without an effect."""
LISTED = (
    "body_torque",
    "inertial_torque",
    "viscous_drag",
    "quadratic_drag",
    "tether",
    "slosh",
    "contact",
    "flexible_appendage",
    "gimbal_zero",
    "rotor_speed",
)
"""Effects of the library that formulas might take for theirs."""
_RUNS, _DURATION = 5, 5.0
_UNITS = 6
"""Gimbals of the platform."""


@dataclass(frozen=True, kw_only=True)
class HiddenFormula:
    """What is hidden in a set.

    Attributes:
        family: of the law; `none` without an effect.
        sigma: of the signature that was wanted; 0 without an effect.
        shown: that it has.
        formula: as the grammar writes it; empty without an effect.
        values: of the formula's constants and coefficients, in the order in which they are estimated, SI.
    """

    family: str
    sigma: float
    shown: float = 0.0
    formula: str = ""
    values: tuple[float, ...] = ()


def wanted(number: int) -> tuple[str, float]:
    """Return the family and the size, in sigma, of a set; numbers begin with 1."""
    if number % NULL_EVERY == 0:
        return NO_LAW, 0.0
    place = number - 1 - number // NULL_EVERY
    return LAWS[place // len(SIGMAS) % len(LAWS)], SIGMAS[place % len(SIGMAS)]


def set_of(seed: int, number: int) -> tuple[Case, HiddenFormula]:
    """Return a set with what is hidden in it."""
    rng = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(number,)))
    family, sigma = wanted(number)
    for _ in count():
        case = _bare_case(rng)
        if family == NO_LAW:
            break
        typical = HiddenEffect(effect="formula_torque", component="platform", parameters=drawn_law(rng, family))
        try:
            hidden, shown = sized(case, typical, sigma)
        except UnreachableError:
            continue
        formula, values = formula_of(hidden.parameters)
        says = HiddenFormula(family=family, sigma=sigma, shown=shown, formula=str(formula), values=tuple(values))
        return replace(case, effects=(hidden,)), says
    return case, HiddenFormula(family=NO_LAW, sigma=0.0)


def listed_set_of(seed: int, number: int) -> tuple[Case, str]:
    """Return a set that hides an effect of the library at 16 sigma, one after the other, and the effect."""
    rng = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(number, 1)))
    effect = LISTED[(number - 1) % len(LISTED)]
    kind = KINDS[effect]
    for _ in count():
        case = _bare_case(rng)
        typical = HiddenEffect(effect=effect, component=kind.components[0], parameters=kind.draw(rng))
        try:
            hidden, _ = sized(case, typical, SIGMAS[-1])
        except UnreachableError:
            continue
        break
    return replace(case, effects=(hidden,)), effect


def _bare_case(rng: np.random.Generator) -> Case:
    runs = tuple(
        Run(
            duration=_DURATION,
            maneuver=int(rng.integers(len(pool()))),
            planned_spin=tuple(np.round(0.15 * rng.standard_normal(3), 3).tolist()),
            release_error=tuple((0.01 * rng.standard_normal(3)).tolist()),
        )
        for _ in range(_RUNS)
    )
    errors = (*(6.6e-4 * rng.standard_normal(3)), *(2e-4 * rng.standard_normal(3)))
    return Case(scenario=SCENARIO, seed=int(rng.integers(2**62)), runs=runs, theta_error=tuple(map(float, errors)))


def formula_of(law: Parameters) -> tuple[Pattern, Array]:
    """Return a hidden law as the grammar writes it, and the values of what a diagnosis estimates of it."""
    factors = ["t"] * int(law["clock"]) + ["norm(w)"] * int(law["length"])
    factors += [f"w_{axis}" for axis in "xyz" for _ in range(int(law[f"power_{axis}"]))]
    factors += [ATTITUDES[int(law["entry"]) - 1]] if law["entry"] else []
    product = "sin(2*pi*f*t) + cos(2*pi*f*t)" if law["frequency"] else "*".join(factors)
    along = vector(law, "coefficient")
    axes = np.flatnonzero(along)
    place = "in N" if law["in_space"] else "in B"
    if len(axes) == 1 and not law["in_space"]:
        place, along = f"about {'xyz'[axes[0]]}", along[axes]
    if law["frequency"]:
        along = np.array([law["frequency"], *(np.cos(law["phase"]) * along), *(np.sin(law["phase"]) * along)])
    return pattern_of(f"{product} {place}"), along


def data_of(case: Case) -> DataSet:
    """Return a set's records as a diagnosis reads them, of which it sees nothing else."""
    scenario = read_scenario(SCENARIO)
    with tempfile.TemporaryDirectory() as folder:
        flown = fly_case(case)
        for index in range(len(case.runs)):
            write_record(record(flown, index), Path(folder) / f"run_{index + 1}.csv")
        return data_set_of(read_data_set(Path(folder)), scenario, nominal_platform(scenario))


@dataclass(frozen=True, kw_only=True)
class Said:
    """What a method says of a set.

    Attributes:
        named: formulas and effects of the library, by key; the first one counts.
        alike: what it cannot distinguish from the first formula.
    """

    named: tuple[str, ...] = ()
    alike: tuple[str, ...] = ()

    @property
    def formulas(self) -> tuple[str, ...]:
        """Those that are named."""
        return tuple(each.removeprefix("formula:") for each in self.named if each.startswith("formula:"))


@dataclass(frozen=True, kw_only=True)
class Judged:
    """Whether it is right.

    Attributes:
        in_class: the hidden formula, or the same law in any direction of the body, is named first or alike.
        exact: the formula that is named first is the hidden one.
        driver: it has the same driver.
    """

    in_class: bool
    exact: bool
    driver: bool


def judged(said: Said, hidden: HiddenFormula) -> Judged:
    """Return what is right of what a method says of a set with an effect; all methods are judged by this."""
    meant = pattern_of(hidden.formula)
    wider = replace(meant, placement="B") if meant.placement in "xyz" else meant
    first = said.formulas[:1]
    return Judged(
        in_class=not {str(meant), str(wider)}.isdisjoint({*first, *said.alike}),
        exact=first == (str(meant),),
        driver=any(_driver(pattern_of(each)) == _driver(meant) for each in first),
    )


def _driver(pattern: Pattern) -> str:
    """Return the class of a formula whatever its memory and place."""
    bare = tuple(replace(law, memory="", memory_constant=None) for law in pattern.laws)
    return next((name for name, every in classes(_UNITS).items() if bare in every), "")


def placed_formulas(weights: Mapping[tuple[str, str], float]) -> list[str]:
    """Return formulas from weights by law and axis, the one with the most weight first.

    Of a law about one body axis the formula is about that axis; about several it is in a direction of B; of axes fixed
    in space it is in N.

    Args:
        weights: of a law, as the grammar writes it, about `x`, `y`, `z` of the body or `Nx`, `Ny`, `Nz`; those without
            weight are left out.
    """
    found: dict[tuple[str, str], dict[str, float]] = {}
    for (law, axis), weight in weights.items():
        found.setdefault((law, "N" if axis.startswith("N") else "B"), {})[axis] = weight
    total = {key: sum(each.values()) for key, each in found.items()}

    def text(law: str, frame: str) -> str:
        axes = list(found[law, frame])
        return f"{law} about {axes[0]}" if frame == "B" and len(axes) == 1 else f"{law} in {frame}"

    return [text(*key) for key in sorted(found, key=lambda key: -total[key])]


def patterns_of(laws: Sequence[str]) -> list[Pattern]:
    """Return laws in every placement."""
    return [
        pattern_of(f"{law} about {place}" if place in "xyz" else f"{law} in {place}")
        for law in laws
        for place in PLACEMENTS
    ]
