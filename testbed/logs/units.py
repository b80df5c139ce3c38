"""Units of a log, converted to those of records by a units library (pint), never by a factor written here."""

from __future__ import annotations

import difflib
import re
from functools import cache
from typing import Any

from testbed.errors import InputError
from testbed.logs.extra import library

_EXPONENT = r"(?:(?:\^|\*\*)-?[1-4]|[²³])?"
_NAME = rf"[A-Za-zµμ°][A-Za-z_0-9]*{_EXPONENT}"
_UNIT = re.compile(rf"(?:1\s*/\s*)?{_NAME}(?:\s*[·*/ ]\s*{_NAME})*")
"""What is given to the library: names, products, quotients, small powers; it would raise 9 to the power 9 to the 9."""
_LONGEST = 60
_ALIASES = (
    "newton_meter = newton * meter = Nm",
    "newton_meter_second = newton * meter * second = Nms",
    "degree_per_second = degree / second = dps",
)
"""As loggers write them; the library takes Nm for a count per metre."""
_NEAR = (
    "rad/s", "mrad/s", "deg/s", "dps", "rpm", "rad", "mrad", "deg", "turn", "N*m", "mN*m", "N*m*s", "mN*m*s",
    "m/s^2", "g_0", "s", "ms", "us", "ns", "min", "h",
)  # fmt: skip
"""Units that are proposed for one that is not known."""
_HINTS = {
    "g": "g is the gram: write g_0 for standard gravity",
    "Hz": "Hz does not say of what: write turn/s for revolutions, rad/s for radians",
    "hertz": "hertz does not say of what: write turn/s for revolutions, rad/s for radians",
    "1/s": "1/s does not say of what: write rad/s, or turn/s",
}


def factor_to(unit: str, target: str) -> float:
    """Return what a number in one unit is multiplied by to be in another.

    Args:
        unit: as a map has it, such as `deg/s` or `mN*m`.
        target: of a signal, as in `testbed.signals`, or `s`; empty for a pure number.

    Raises:
        InputError: the unit is not known, or is of another quantity.
    """
    parsed = _parsed(unit)
    if not _converts(parsed, target):
        hint = f" ({_HINTS[unit]})" if unit in _HINTS else ""
        of = f"another quantity than {target}" if target else "no pure number"
        alike = [each for each in _NEAR if _converts(_parsed(each), target)] or [target or "percent"]
        raise InputError(f"unit {unit!r} is of {of}{hint}; such as {', '.join(alike)}")
    return float(_registry().Quantity(1.0, parsed).to(_unit_of(target)).magnitude)


def is_unit_of(unit: str, target: str) -> bool:
    """Return whether a text is a unit that converts to another.

    Raises:
        InputError: the units library is not installed.
    """
    _registry()  # before the block: without the library no text would be a unit
    try:
        return _converts(_parsed(unit), target)
    except InputError:
        return False


def _converts(unit: Any, target: str) -> bool:  # noqa: ANN401 - a unit of the library
    wanted = _unit_of(target)
    angle = _angle_power(wanted)  # only where an angle is measured does it distinguish units
    return bool(unit.dimensionality == wanted.dimensionality and (not angle or _angle_power(unit) == angle))


def _unit_of(target: str) -> Any:  # noqa: ANN401
    return _registry().Unit(target.replace("·", "*") or "dimensionless")


@cache
def _registry() -> Any:  # noqa: ANN401 - the library is optional
    registry = library("pint", "converting units").UnitRegistry(on_redefinition="ignore")
    for alias in _ALIASES:
        registry.define(alias)
    return registry


def _parsed(unit: str) -> Any:  # noqa: ANN401
    registry, pint = _registry(), library("pint", "converting units")
    if unit == "1":  # a pure number, as records.md writes it
        return registry.Unit("dimensionless")
    if len(unit) <= _LONGEST and _UNIT.fullmatch(unit):
        try:
            return registry.Unit(unit)
        except (pint.PintError, ValueError, AttributeError, TypeError):
            pass  # said below
    near = difflib.get_close_matches(unit, _NEAR, n=3, cutoff=0.4)
    meant = f"did you mean {', '.join(near)}?" if near else f"such as {', '.join(_NEAR[:4])}"
    raise InputError(f"unit {unit[:_LONGEST]!r} is not known; {meant}")


def _angle_power(unit: Any) -> float:  # noqa: ANN401
    """Return the power of the angle in a unit: 1 of deg/s, 0 of Hz; both have the dimension 1/time."""
    return float(dict(_registry().Quantity(1.0, unit).to_base_units().unit_items()).get("radian", 0))
