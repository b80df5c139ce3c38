"""How numbers and names are written on the pages."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from math import floor, isfinite, log10

import numpy as np

from testbed.arrays import Array
from testbed.dynamics.inertia_unit import InertiaUnit

BAND = 1.96
"""Standard deviations on either side that hold 95 % of a normal distribution."""

ESTIMATOR_NAMES: Mapping[str, str] = {
    "ls": "least squares",
    "iv": "instrumental variable",
    "iv_momentum": "IV, momentum form",
    "output_error": "output error",
}
"""What the pages call the estimators of a scenario."""

_MOST_DECIMALS = 6
_MOST_DIGITS = 9
"""Nothing is known better, and what a fit states beyond is rounding."""


def estimator_name(key: str) -> str:
    """Return what the pages call an estimator."""
    return ESTIMATOR_NAMES[key]


def capitalized(text: str) -> str:
    """Return a text with its first letter in upper case, the others as they are."""
    return text[:1].upper() + text[1:]


def decimals_for(stds: Array, unit: InertiaUnit) -> int:
    """Return how many decimals show two digits of the smallest standard deviation.

    Args:
        stds: kg·m², any shape; entries that are no positive number do not count.
        unit: in which they are shown.
    """
    known = stds[np.isfinite(stds) & (stds > 0.0)]
    if not known.size:
        return 3
    return min(max(1 - floor(log10(unit.per_SI * float(known.min()))), 0), _MOST_DECIMALS)


def figures(value: float, digits: int = 3) -> str:
    """Return a number with so many significant digits, in powers of ten where it is very large or small."""
    return f"{value:.{digits}g}"


def figures_to(value: float, std: float) -> str:
    """Return a number with as many significant digits as show two of its standard deviation's, three at least."""
    if not (isfinite(value) and isfinite(std) and value and std > 0.0):
        return figures(value)
    wanted = floor(log10(abs(value))) - floor(log10(std)) + 2
    return figures(value, min(max(wanted, 3), _MOST_DIGITS))


def chance_words(chance: float) -> str:
    """Return `p = ...`, or that it is too small for a number."""
    return f"p = {figures(chance, 2)}" if chance > 0.0 else "p < 1e-300"


def listed(items: Iterable[str]) -> str:
    """Return items as a list in a sentence: `a`, `a and b`, `a, b and c`."""
    *head, last = items
    return f"{', '.join(head)} and {last}" if head else last
