"""What the name of a field of a log says: of what it is a component, in which unit, whether it is a time."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from string import ascii_lowercase

from testbed.logs.units import is_unit_of
from testbed.signals import AXES, QUATERNION, unit_numbers

SUFFIXES = {
    "rad_s": "rad/s", "rads": "rad/s", "radps": "rad/s", "mrad_s": "mrad/s", "deg_s": "deg/s", "degs": "deg/s",
    "dps": "deg/s", "mdps": "mdeg/s", "degps": "deg/s", "rpm": "rpm", "u_min": "rpm", "r_min": "rpm", "tr_min": "rpm",
    "1_min": "rpm", "min-1": "rpm", "rad": "rad",
    "mrad": "mrad", "deg": "deg", "n_m": "N*m",
    "nm": "N*m", "mn_m": "mN*m", "mnm": "mN*m", "un_m": "uN*m", "unm": "uN*m",
    "n.m": "N*m", "mn.m": "mN*m", "n_m_s": "N*m*s", "nms": "N*m*s", "mnms": "mN*m*s", "m_s2": "m/s^2",
    "mps2": "m/s^2", "g": "g_0", "mg": "mg_0", "s": "s", "sec": "s", "ms": "ms", "us": "us", "ns": "ns",
}  # fmt: skip
"""Unit that the end of a name states."""
NAMED_BY_UNIT = ("rpm", "dps", "mdps")
"""Units that are a field's whole name: no quantity has such a name."""
_OF_AXES = (("p", "q", "r"), ("roll", "pitch", "yaw"))
"""What components along x, y and z are called as well."""
_BRACKETS = re.compile(r"\s*[\[(]\s*((?:1/)?[^\])0-9][^\])]*)[\])]\s*$")
_INDEXED = re.compile(r"^(.*?)[_.\s]?\[(\d+)\]$")
_SINGLE = re.compile(r"(^|_)rw$", re.IGNORECASE)
"""Names that end in a letter of an axis and are whole words: a reaction wheel."""
_TIME = re.compile(
    r"^(t|time|timestamp|time_?stamp|stamp|epoch|clock|date[_ /]?time|utc|tow|elapsed|zeit|unix_?time"
    r"|met|mission[ _]?(elapsed[ _]?)?time"
    r"|(time|ms|us|seconds)?[ _]*since[ _]*(boot|start|power[ _]?up))$"
)
_SCALE = re.compile(r"\s*[\[(](utc|gmt|tai|gps|iso ?8601)[\])]$", re.IGNORECASE)
"""What names of clocks end with, in the place of a unit."""


@dataclass(frozen=True, kw_only=True)
class Part:
    """A field as one component of something.

    Attributes:
        stem: the name of all of it.
        component: x, 1, w and so on; empty where the name is that of a single number.
        unit: that the name states; empty where it states none.
        field: its own name.
    """

    stem: str
    component: str
    unit: str
    field: str


def parts_of(field: str, stated: str) -> Iterator[Part]:
    """Yield how a field's name may be read as one component of something.

    Args:
        field: its name.
        stated: unit that the format states; empty for none.
    """
    parts = list(_components_of(field, stated))
    if not parts:
        bare, unit = without_unit(field)
        parts = [Part(stem=bare, component="", unit=unit or stated, field=field)]
    yield from parts


def _components_of(field: str, stated: str) -> Iterator[Part]:
    bare, unit = without_unit(field)
    unit = unit or stated
    if indexed := _INDEXED.match(bare):
        stem, more = without_unit(indexed[1])
        yield Part(stem=stem, component=indexed[2], unit=unit or more, field=field)
        return
    head, _, tail = bare.replace(" ", "_").rpartition(".")
    prefix = f"{head}." if head else ""
    lower = tail.lower()
    if lower in (*AXES, *QUATERNION, "p", "q", "r", "roll", "pitch", "yaw"):
        yield Part(stem=head or ("pqr" if lower in "pqr" else ""), component=lower, unit=unit, field=field)
    if _SINGLE.search(tail):
        return
    for pattern in (r"^(.+?)_?([xyzw])$", r"^(.+?)_?(\d+)$", r"^(.+?)_(roll|pitch|yaw|[a-hpqr])$"):
        if found := re.match(pattern, tail, re.IGNORECASE):
            stem, more = without_unit(found[1])
            yield Part(stem=prefix + stem, component=found[2].lower(), unit=unit or more, field=field)
    for pattern in (
        r"^([xyzw])_(.+)$",
        r"^(roll|pitch|yaw)_?(.+)$",
        r"^(.+?)_([xyz]|\d+)_(.+)$",
        r"^([a-z]+)(\d+)_(.+)$",
        r"^(.*[^\x00-\x7f])(\d+)(\D+)$",  # as in ホイール1回転数: no letter of ASCII is next to its number
    ):
        if found := re.match(pattern, tail, re.IGNORECASE):
            axis, rest = (found[1], found[2]) if found.re.groups == 2 else (found[2], f"{found[1]}_{found[3]}")
            yield Part(stem=prefix + rest, component=axis.lower(), unit=unit, field=field)


def without_unit(name: str) -> tuple[str, str]:
    """Return a name without the unit at its end, and the unit as a map has it; empty where there is none."""
    if (bracket := _BRACKETS.search(name)) and (unit := _unit(bracket[1])):
        return name[: bracket.start()].strip(" _"), unit
    bare, space, last = name.rpartition(" ")
    if space and (len(last) > 1 or last == "s") and (unit := _unit(last)):  # "gyro x rpm", but not "position m"
        return bare.strip(" _"), unit
    for suffix in sorted(SUFFIXES, key=len, reverse=True):
        if name.lower().endswith(f"_{suffix}") and len(name) > len(suffix) + 1:
            return name[: -len(suffix) - 1], SUFFIXES[suffix]
    return name, ""


def _unit(text: str) -> str:
    """Return a unit as a map has it; empty where it is none."""
    known = SUFFIXES.get(text.strip().lower().replace("/", "_"), text.strip())
    targets = ("rad", "rad/s", "N·m", "N·m·s", "m/s²", "s", "m")
    return known if any(is_unit_of(known, target) for target in targets) else ""


def in_order(components: Sequence[str], fields: Mapping[str, str]) -> tuple[str, ...] | None:
    """Return fields in the order of components; None where one is missing."""
    count = len(components)
    names: list[Sequence[str]] = [components]
    if tuple(components) in (AXES, unit_numbers(count)):
        first = 0 if "0" in fields else 1
        names += [[str(index) for index in range(first, first + count)]] if len(fields) == count else []
    if tuple(components) == unit_numbers(count) and len(fields) == count:
        names += [AXES[:count], ascii_lowercase[:count]]
        names += [[""]] if count == 1 else []
    if tuple(components) == QUATERNION:
        names += [[str(index) for index in range(4)], [f"q{axis}" for axis in QUATERNION]]
    if tuple(components) == AXES:
        names += _OF_AXES
    for each in names:
        if all(name in fields for name in each):
            return tuple(fields[name] for name in each)
    return None


def about(axes: Sequence[str], fields: Mapping[str, str]) -> tuple[str, ...] | None:
    """Return the fields of a rig that turns about some body axes only, in their order; None where they are not these.

    Args:
        axes: of x, y, z.
        fields: by component; a single number may be about any axis.
    """
    if len(fields) != len(axes):
        return None
    for names in (AXES, *_OF_AXES):
        wanted = [names[AXES.index(axis)] for axis in axes]
        if all(name in fields for name in wanted):
            return tuple(fields[name] for name in wanted)
    return tuple(fields.values()) if "" in fields else None


def is_time(field: str) -> bool:
    """Return whether a field is called a time."""
    return bool(_TIME.match(without_unit(_SCALE.sub("", field))[0].lower()))
