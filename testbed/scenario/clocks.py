"""The clocks of a run in exact arithmetic: every period a whole number of steps, and of each other.

Rounding a period to steps would shift samples in time without a trace, so what does not divide is refused.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from fractions import Fraction
from itertools import pairwise

from testbed.scenario.section import Conflict

_LARGEST_DENOMINATOR = 10**6
_SEARCHED = 500
"""How many step counts on either side are looked through for a short step."""
_SHORT = 10
"""Characters of a step that a person would write, such as 0.00078125."""


def exact(value: float) -> Fraction:
    """Return the ratio that was meant: 0.00125 is 1/800, and 0.016666666666666666 is 1/60."""
    simple = Fraction(repr(value)).limit_denominator(_LARGEST_DENOMINATOR)
    return simple if float(simple) == value else Fraction(repr(value))


def divides(part: Fraction, whole: Fraction) -> bool:
    """Tell whether `whole` is a whole multiple of `part`."""
    return (whole / part).denominator == 1


def step_conflicts(step: float, rates: Mapping[str, float]) -> Iterator[Conflict]:
    """Find a step that does not divide every clock's period.

    Args:
        step: s.
        rates: of the clocks, by dotted key, Hz.
    """
    missed = [key for key, rate in rates.items() if not divides(exact(step), 1 / exact(rate))]
    if missed:
        names = ", ".join(f"{key} = {rates[key]}" for key in missed)
        choices = " or ".join(str(choice) for choice in nearest_steps(step, rates))
        yield Conflict(key="simulation.step_s", text=f"{step} s does not divide the period of {names}; use {choices}")


def rate_conflicts(rates: Mapping[str, float]) -> Iterator[Conflict]:
    """Find clocks of which the slower's period is not a whole number of the faster's.

    Args:
        rates: of the clocks, by dotted key, Hz.
    """
    ordered = sorted(rates.items(), key=lambda item: item[1])
    for (slow_key, slow), (fast_key, fast) in pairwise(ordered):
        if not divides(exact(slow), exact(fast)):
            whole = fast // slow
            yield Conflict(
                key=fast_key,
                text=f"{fast} is no whole multiple of {slow_key} = {slow}; use {whole * slow} or {(whole + 1) * slow}",
            )


def order_conflicts(rates: Mapping[str, float], fastest: str) -> Iterator[Conflict]:
    """Find clocks that tick more often than the one that drives the loop.

    Args:
        rates: of the clocks, by dotted key, Hz.
        fastest: key of the clock that drives the loop.
    """
    for key, rate in rates.items():
        if rate > rates[fastest]:
            yield Conflict(key=fastest, text=f"{rates[fastest]} is slower than {key} = {rate}; use {rate} or more")


def duration_conflicts(duration: float, control_rate: float) -> Iterator[Conflict]:
    """Find a run that does not end with a control period.

    Args:
        duration: s.
        control_rate: Hz.
    """
    periods = exact(duration) * exact(control_rate)
    if periods.denominator != 1:
        counts = sorted({max(1, math.floor(periods)), math.ceil(periods)})
        choices = " or ".join(str(float(count / exact(control_rate))) for count in counts)
        text = f"{duration} s is no whole number of control periods of 1/{control_rate} s; use {choices}"
        yield Conflict(key="simulation.duration_s", text=text)


def nearest_steps(step: float, rates: Mapping[str, float]) -> list[float]:
    """Return the nearest larger and smaller step that divides every period, short decimals where there are any.

    Args:
        step: s.
        rates: of the clocks, Hz.
    """
    tick = _common_period(1 / exact(rate) for rate in rates.values())
    steps = tick / exact(step)
    fewer, more = math.ceil(steps) - 1, math.floor(steps) + 1
    larger = _friendliest(tick, range(fewer, max(0, fewer - _SEARCHED), -1))
    smaller = _friendliest(tick, range(more, more + _SEARCHED))
    return [float(choice) for choice in larger + smaller]


def _common_period(periods: Iterable[Fraction]) -> Fraction:
    numerators, denominators = zip(*(period.as_integer_ratio() for period in periods), strict=True)
    return Fraction(math.gcd(*numerators), math.lcm(*denominators))


def _friendliest(tick: Fraction, divisors: range) -> list[Fraction]:
    """The first part of the tick that is a short decimal, or else the first; none of no divisors."""
    choices = [tick / divisor for divisor in divisors]
    short = (choice for choice in choices if len(str(float(choice))) <= _SHORT and exact(float(choice)) == choice)
    return [next(short, choices[0])] if choices else []
