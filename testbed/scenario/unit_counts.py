"""Lists with one entry for each unit of the cluster: as long as there are units."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from testbed.scenario.cluster import Cluster
from testbed.scenario.section import Conflict, Section

_LISTS: Mapping[str, tuple[str, ...]] = {
    "truth": ("rotor_momentum_N_m_s", "gimbal_axis_misalignment_rad"),
    "initial": ("gimbal_angle_rad",),
    "encoder": ("zero_rad", "dead_zone_rad"),
    "tachometer": ("scale_factor_error",),
    "controller": ("steering.preferred_gimbal_angle_rad",),
}
"""Keys of such lists, by section; a maneuver's are rows of them."""
_ROWS = "gimbal_angle_rad"
"""Key of a maneuver's rows."""


def count_conflicts(name: str, section: Section, cluster: Cluster | None) -> Iterator[Conflict]:
    """Find lists that are longer or shorter than the cluster has units; an empty one stands for no entry.

    Args:
        name: of the section.
        section: as read.
        cluster: the units; None where it is wrong itself.
    """
    for key in _LISTS.get(name, ()):
        yield from _conflicts(f"{name}.{key}", _value(section, key), cluster)
    if name == "maneuver":
        for number, row in enumerate(getattr(section, _ROWS, ()), start=1):
            yield from _conflicts(f"{name}.{_ROWS}", row or (None,), cluster, f"row {number} ")


def _conflicts(key: str, value: object, cluster: Cluster | None, where: str = "") -> Iterator[Conflict]:
    if cluster is not None and isinstance(value, tuple) and len(value) not in {0, cluster.units}:
        text = f"{where}has {len(value)} entries instead of {cluster.units}, one for each unit"
        yield Conflict(key=key, text=text)


def _value(section: Section, key: str) -> Any:  # noqa: ANN401 - of any type that a key may have
    value: Any = section
    for part in key.split("."):
        value = getattr(value, part)
    return value
