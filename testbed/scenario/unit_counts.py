"""Lists with one entry for each unit of the cluster, or for each wheel: as long as there are units."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from testbed.scenario.actuators import ReactionWheels, wheel_count
from testbed.scenario.gyros import Gyros
from testbed.scenario.section import Conflict, Section

_LISTS: Mapping[str, tuple[str, ...]] = {
    "truth": ("rotor_momentum_N_m_s", "gimbal_axis_misalignment_rad"),
    "initial": ("gimbal_angle_rad",),
    "encoder": ("zero_rad", "dead_zone_rad"),
    "tachometer": ("scale_factor_error",),
    "controller": ("steering.preferred_gimbal_angle_rad",),
}
"""Keys of such lists, by section; a maneuver's are rows of them."""
_WHEEL_LISTS: Mapping[str, tuple[str, ...]] = {
    "truth": (
        "wheel_spin_inertia_factor",
        "wheel_axis_misalignment_rad",
        "wheel_viscous_friction_N_m_s_rad",
        "wheel_coulomb_friction_N_m",
        "wheel_torque_factor",
        "wheel_motor_lag_s",
        "wheel_imbalance_kg_m",
    ),
    "initial": ("wheel_momentum_N_m_s",),
    "wheel_tachometer": ("bias_rad_s", "scale_factor_error"),
    "controller": ("wheels.preferred_momentum_N_m_s",),
}
"""The same of the reaction wheels."""
_ROWS, _WHEEL_ROWS = "gimbal_angle_rad", "wheel_momentum_N_m_s"
"""Keys of a maneuver's rows."""


def count_conflicts(
    name: str, section: Section, gyros: Gyros | None, wheels: Sequence[ReactionWheels] | None
) -> Iterator[Conflict]:
    """Find lists that are longer or shorter than there are units or wheels; an empty one stands for no entry.

    Args:
        name: of the section.
        section: as read.
        gyros: the units; None where they are wrong themselves.
        wheels: likewise.
    """
    units = None if gyros is None else gyros.units
    wheel_units = None if wheels is None else wheel_count(wheels)
    for key in _LISTS.get(name, ()):
        yield from _conflicts(f"{name}.{key}", _value(section, key), units, "unit")
    for key in _WHEEL_LISTS.get(name, ()):
        yield from _conflicts(f"{name}.{key}", _value(section, key), wheel_units, "wheel")
    if name == "maneuver":
        for number, row in enumerate(getattr(section, _ROWS, ()), start=1):
            yield from _conflicts(f"{name}.{_ROWS}", row or (None,), units, "unit", f"row {number} ")
        for number, row in enumerate(getattr(section, _WHEEL_ROWS, ()), start=1):
            yield from _conflicts(f"{name}.{_WHEEL_ROWS}", row or (None,), wheel_units, "wheel", f"row {number} ")


def _conflicts(key: str, value: object, units: int | None, kind: str, where: str = "") -> Iterator[Conflict]:
    if units is not None and isinstance(value, tuple) and len(value) not in {0, units}:
        yield Conflict(key=key, text=f"{where}has {len(value)} entries instead of {units}, one for each {kind}")


def _value(section: Section, key: str) -> Any:  # noqa: ANN401 - of any type that a key may have
    value: Any = section
    for part in key.split("."):
        value = getattr(value, part)
    return value
