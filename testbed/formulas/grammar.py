"""The formulas that a search tests, by class, with what each of them takes of the prior."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import combinations_with_replacement
from typing import Literal, TypeAlias

from testbed.formulas.law import Factor, Law, Memory
from testbed.formulas.motion import ATTITUDES, AXES, ELAPSED, GIMBAL_RATES, GIMBALS, RATES, TIME, TORQUES
from testbed.formulas.pattern import PLACEMENTS, Pattern

Class: TypeAlias = Literal[
    "time",
    "oscillation",
    "rate",
    "drag",
    "product of two rates",
    "product of three rates",
    "attitude",
    "gimbal angle",
    "gimbal rate",
    "gimbal rate times body rate",
    "actuator torque",
    "pulse in one run",
]
"""Formulas that are driven by the same quantities."""
MEMORIES: Mapping[Memory, str] = {"lag": "tau", "delay": "late", "hysteresis": "stretch"}
"""What a product may have, and the constant's name."""
SCANNED: Mapping[str, tuple[float, ...]] = {
    "tau": (0.05, 0.1, 0.2, 0.4, 0.8, 1.6),
    "late": (0.05, 0.1, 0.2, 0.4),
    "stretch": (0.03, 0.1, 0.3),
    "width": (0.1, 0.2, 0.4, 0.8),
}
"""Values from which constants are searched: a factor of two apart, a refit comes to what lies between. A pulse narrower
than 0.1 s is an impulse, `contact`; instants are tried as far apart as it is wide."""


def classes(units: int, *, torque: bool = False) -> Mapping[Class, tuple[tuple[Law, ...], ...]]:
    """Return the laws of each class, without a memory; the sine and cosine of one frequency go together.

    Args:
        units: number of gimbals that telemetry shows.
        torque: whether it shows the torque of actuators that store no momentum.
    """
    rates = [Factor(argument=name) for name in RATES]
    moved = [Factor(argument=name) for name in GIMBAL_RATES[:units]]
    waves = (Factor(function=each, argument=TIME, constants=("f",)) for each in ("sin", "cos"))
    found: dict[Class, list[tuple[Factor, ...]]] = {
        "time": [(Factor(argument=TIME),)],
        "pulse in one run": [(Factor(function="once", argument=ELAPSED, constants=("at", "width")),)],
        "rate": [(each,) for each in rates],
        "drag": [
            *((Factor(function="norm", argument="w"), each) for each in rates),
            *((Factor(function="abs", argument=each.argument), each) for each in rates),
        ],
        "product of two rates": list(combinations_with_replacement(rates, 2)),
        "product of three rates": list(combinations_with_replacement(rates, 3)),
        "attitude": [(Factor(argument=name),) for name in ATTITUDES],
    }
    if units:
        functions: tuple[Literal["sin", "cos", ""], ...] = ("sin", "cos", "")
        found["gimbal angle"] = [
            (Factor(function=each, argument=name),) for name in GIMBALS[:units] for each in functions
        ]
        found["gimbal rate"] = [(each,) for each in moved]
        found["gimbal rate times body rate"] = [(each, rate) for each in moved for rate in rates]
    if torque:
        given = [Factor(argument=name) for name in TORQUES]
        squares = [(Factor(function="abs", argument=each.argument), each) for each in given]
        found["actuator torque"] = [*((each,) for each in given), *combinations_with_replacement(given, 2), *squares]
    single = {name: tuple((Law.of(*factors),) for factors in laws) for name, laws in found.items()}
    return {**single, "oscillation": (tuple(Law.of(wave) for wave in waves),)}


def with_memories(name: Class, law: Law) -> Iterator[Law]:
    """Yield a law of a class without and with every memory that says something else of it."""
    yield law
    if name in ("time", "oscillation", "pulse in one run", "attitude"):
        return
    for memory, constant in MEMORIES.items():
        if memory != "hysteresis" or (len(law.factors) == 1 and not law.factors[0].function):
            yield Law.of(*law.factors, memory=memory, memory_constant=constant)


def patterns(units: int, *, torque: bool = False) -> Mapping[Class, tuple[Pattern, ...]]:
    """Return all formulas that are tested, by class.

    Args:
        units: number of gimbals that telemetry shows.
        torque: whether it shows the torque of actuators that store no momentum.
    """
    return {
        name: tuple(
            pattern
            for laws in every
            for each in ([laws] if len(laws) > 1 else [(law,) for law in with_memories(name, laws[0])])
            for place in PLACEMENTS
            if not is_listed(pattern := Pattern(laws=each, placement=place))
        )
        for name, every in classes(units, torque=torque).items()
    }


def is_listed(pattern: Pattern) -> bool:
    """Return whether an effect of the library has this form.

    Drag about an axis by the rate about it; of the actuators' torque about an axis a factor, a lag or a delay.
    """
    law = pattern.laws[0]
    if pattern.placement in AXES and law.factors == (Factor(argument=f"torque_{pattern.placement}"),):
        return law.memory != "hysteresis"
    own = f"w_{pattern.placement}"
    along_own = pattern.placement in AXES and {factor.argument for factor in law.factors} == {own}
    drag = len(law.factors) == 1 or any(factor.function == "abs" for factor in law.factors)
    return along_own and drag and law.memory in ("", "hysteresis")


def shares(every: Mapping[Class, tuple[Pattern, ...]]) -> Mapping[Pattern, float]:
    """Return each formula's share of the prior of its class: it halves with each factor, constant and direction."""
    weights = [{pattern: 2.0**-pattern.length for pattern in alike} for alike in every.values()]
    return {pattern: weight / sum(own.values()) for own in weights for pattern, weight in own.items()}
