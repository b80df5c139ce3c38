"""Formulas as physics in words."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from testbed.formulas.law import Law
from testbed.formulas.pattern import Pattern

_LETTERS = {"x": "x", "y": "y", "z": "z"}


def law_words(pattern: Pattern) -> str:
    """Return what a torque follows, e.g. `ω_x ω_y`."""
    if len(pattern.laws) > 1:
        return "a sine of the time, of one frequency and phase from the start of every run"
    return of_law(pattern.laws[0])


def of_law(law: Law) -> str:
    """Return one law in words."""
    if not law.recurs:
        return "a pulse in one of the runs laid end to end, a second between them"
    product = " ".join(_factor(str(factor)) for factor in law.factors) or "nothing: it is constant"
    constant = law.memory_constant
    size = f" of {constant:.3g} s" if isinstance(constant, float) else ""
    match law.memory:
        case "lag":
            return f"{product} with a first-order lag{size}"
        case "delay":
            return f"{product} with a delay{size}"
        case "hysteresis":
            return f"the sign of {product}, with a hysteresis"
    return product


def place_words(pattern: Pattern) -> str:
    """Return where it points, e.g. `about z`."""
    if pattern.placement in _LETTERS:
        return f"about {pattern.placement}"
    return "in a direction fixed in the body" if pattern.placement == "B" else "in a direction fixed in space"


def measured_words(pattern: Pattern, values: Sequence[float], stds: Sequence[float]) -> str:
    """Return a formula with its sizes, e.g. `A torque about z of (1.31 ± 0.08)e-3 N·m·s²/rad² times ω_x ω_y`.

    Args:
        pattern: the formula.
        values: constants, then the coefficients of each law along each axis, SI.
        stds: their standard errors.
    """
    count = len(pattern.names)
    sizes, errors = np.array(values[count:]), np.array(stds[count:])
    size = float(np.linalg.norm(sizes))
    error = float(np.linalg.norm(sizes * errors) / size) if size > 0.0 else float(np.linalg.norm(errors))
    if len(sizes) == 1:
        size, error = float(sizes[0]), float(errors[0])
    unit = f"{with_error(size, error)} {pattern.laws[0].coefficient_unit}"
    constants = listed_constants(pattern.names, values[:count], stds[:count])
    direction = ""
    if len(pattern.axes) > 1 and len(pattern.laws) == 1 and size > 0.0:
        direction = f", along ({', '.join(f'{part:.2f}' for part in sizes / size)})"
    if len(pattern.laws) > 1:
        return f"A torque {place_words(pattern)} of {unit} times a sine of the time{constants}"
    return f"A torque {place_words(pattern)}{direction} of {unit} times {of_law(pattern.laws[0])}{constants}"


_CONSTANTS = {
    "f": "frequency {} Hz",
    "tau": "{} s",
    "late": "{} s",
    "at": "at {} s",
    "width": "width {} s",
    "stretch": "stretch {} rad",
}


def listed_constants(names: Sequence[str], values: Sequence[float], stds: Sequence[float]) -> str:
    """Return the values of constants in brackets; empty where there are none."""
    shown = [
        _CONSTANTS[name].format(with_error(value, std)) for name, value, std in zip(names, values, stds, strict=True)
    ]
    return f" ({', '.join(shown)})" if shown else ""


def with_error(value: float, std: float) -> str:
    """Return a value and its standard error with one exponent, the error with two digits."""
    if not (math.isfinite(value) and math.isfinite(std)) or value == 0.0 or std <= 0.0:
        return f"{value:.3g} ± {std:.2g}"
    exponent = math.floor(math.log10(max(abs(value), std)))
    exponent = exponent if abs(exponent) > _PLAIN else 0
    value, std = value / 10.0**exponent, std / 10.0**exponent
    digits = max(0, 1 - math.floor(math.log10(std)))
    shown = f"{value:.{digits}f} ± {std:.{digits}f}"
    return f"({shown})e{exponent}" if exponent else shown


_PLAIN = 1
"""Exponents of ten up to which a number is written without one."""


def _factor(text: str) -> str:
    for plain, symbol in (("gimbal_rate_", "ḋ"), ("gimbal_", "d"), ("norm(w)", "|ω|"), ("2*pi*", "2π ")):
        text = text.replace(plain, symbol)
    text = text.replace("abs(", "|").replace(")", "|") if text.startswith("abs(") else text
    return text.replace("w_", "ω_").replace("torque_", "τ_").replace("*t", " t")
