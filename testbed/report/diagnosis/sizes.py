"""The smallest detectable sizes in words: a line for each effect, from its most to its least visible component."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from math import isclose

from testbed.diagnosis.detectable import Detectable, detectable_sizes, pairs_alike
from testbed.diagnosis.state import Diagnosis
from testbed.effects.contract import Quantity
from testbed.report.wording import figures

_CONFOUNDED_SHOWN = 3
_CALLED = {
    "applied_torque_or_cluster_momentum": "applied_torque or cluster_momentum",
    "thrust": "motor_thrust with [[thrusters]]",
}
"""What a user knows channels by that an effect needs."""
_OTHER_AXES = re.compile(r" [xyz]$")


@dataclass(frozen=True, kw_only=True)
class SizeLine:
    """What these data show of an effect.

    Attributes:
        effect: its id.
        components: how many it may act at.
        typical: its parameters at their typical size.
        smallest: those that make its size, at the smallest that is seen.
        multiple: of the typical size.
        confounded: with which other effects.
        seen: at how many of its components its typical size is seen.
    """

    effect: str
    components: int
    typical: str
    smallest: str
    multiple: str
    confounded: str
    seen: int


def lacking(diagnosis: Diagnosis) -> Mapping[str, list[str]]:
    """Return the effects that could not be tested for, by what the records lack for it, in words."""
    by_need: dict[str, list[str]] = {}
    for each in diagnosis.untestable:
        needs = " and ".join(_CALLED.get(need, need) for need in each.needs.split(" and "))
        named = each.effect if each.component is None else f"{each.effect} ({each.component})"
        by_need.setdefault(needs, []).append(named)
    return by_need


def size_lines(diagnosis: Diagnosis) -> Iterator[SizeLine]:
    """Yield a line for each effect that was looked at."""
    confounded = _confounded(diagnosis)
    for effect, group in groupby(detectable_sizes(diagnosis), key=lambda size: size.placed.effect.id):
        members = list(group)
        places = len(members)
        sizes = sorted(
            (one for size in members for one in size.by_frequency or (size,)), key=lambda size: size.multiple
        )
        yield SizeLine(
            effect=effect,
            components=places,
            typical=typical_words(sizes[0]),
            smallest=smallest_words(sizes),
            multiple=_multiple(sizes),
            confounded=confounded.get(effect, ""),
            seen=sum(size.seen_when_typical for size in members),
        )


def confounded_words(diagnosis: Diagnosis) -> str:
    """Return the effects that these data hardly distinguish, pair by pair, the closest first; empty where none."""
    pairs = dict.fromkeys(frozenset({one.effect.id, other.effect.id}) for one, other, _ in pairs_alike(diagnosis))
    return ", ".join(
        " and ".join(sorted(pair)) if len(pair) > 1 else f"components of {next(iter(pair))}" for pair in pairs
    )


def smallest_words(sizes: Sequence[Detectable]) -> str:
    """Return the parameters that make the size, from the most to the least visible component; equal ones once.

    Args:
        sizes: of the components of one effect, the most visible first.
    """
    seen = [size for size in sizes if size.smallest]
    if not seen:
        return "not by this motion"
    quantities = zip(seen[0].smallest, seen[-1].smallest, seen[0].typical, strict=True)
    own = seen[0].sized_by
    return _listed(
        [
            (least, most)
            for least, most, typical in quantities
            if (least.name in own if own else not isclose(least.value, typical.value))
        ]
    )


def typical_words(size: Detectable) -> str:
    """Return the parameters at their typical size, those that do not scale with it among them."""
    return _listed([(each, each) for each in size.typical])


def _listed(spans: Sequence[tuple[Quantity, Quantity]]) -> str:
    """Return parameters with their names; those of one value are named together."""
    names: dict[str, list[str]] = {}
    for least, most in spans:
        names.setdefault(_span(least, most), []).append(_name(least))
    return ", ".join(f"{_together(own)} {span}{' each' if len(own) > 1 else ''}" for span, own in names.items())


def _span(least: Quantity, most: Quantity) -> str:
    values = dict.fromkeys(figures(each.value) for each in (least, most))
    return f"{' to '.join(values)} {least.unit}".removesuffix(" 1")


def _name(quantity: Quantity) -> str:
    """Return a parameter's name without its unit, which stands behind the number."""
    unit = re.sub("[·/]", "_", quantity.unit).replace("²", "2")
    return re.sub(f"_{re.escape(unit)}$", "", quantity.name, flags=re.IGNORECASE).replace("_", " ")


def _together(names: Sequence[str]) -> str:
    """Return the name that components along the axes share; otherwise all names, one alone with its axis."""
    if len(names) == 1:
        return names[0]
    stems = {_OTHER_AXES.sub("", name) for name in names}
    return stems.pop() if len(stems) == 1 else ", ".join(names)


def _multiple(sizes: Sequence[Detectable]) -> str:
    if not sizes[0].smallest:
        return "-"
    return " to ".join(dict.fromkeys(f"{float(figures(size.multiple, 2)):g}" for size in (sizes[0], sizes[-1])))


def _confounded(diagnosis: Diagnosis) -> dict[str, str]:
    """Return the effects that each one is hard to distinguish from, by its id."""
    by_effect: dict[str, dict[str, None]] = {}
    for one, other, _ in pairs_alike(diagnosis):
        for this, that in ((one, other), (other, one)):
            name = "its other components" if this.effect.id == that.effect.id else that.effect.id
            by_effect.setdefault(this.effect.id, {})[name] = None
    return {effect: ", ".join(list(others)[:_CONFOUNDED_SHOWN]) for effect, others in by_effect.items()}
