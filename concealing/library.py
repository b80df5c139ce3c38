"""All effects by id, and a craft with some of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from concealing import (
    actuator_effects,
    formula_effects,
    further_effects,
    gyro_effects,
    inner_effects,
    platform_effects,
    unit_effects,
    unlisted_effects,
)
from concealing.craft import Craft
from concealing.effect import EffectKind, HiddenEffect

LISTED: dict[str, EffectKind] = {
    **platform_effects.KINDS,
    **inner_effects.KINDS,
    **unit_effects.KINDS,
    **actuator_effects.KINDS,
    **gyro_effects.KINDS,
}
"""The effects of the published table."""
UNLISTED: dict[str, EffectKind] = unlisted_effects.KINDS
"""Effects that are in no library."""
FURTHER: dict[str, EffectKind] = further_effects.KINDS | gyro_effects.FURTHER
"""Effects of the published table that only a set which is asked for has."""
FORMULAS: dict[str, EffectKind] = formula_effects.KINDS
"""Torques by laws of the motion, which `benchmarks.formulas` hides."""
KINDS = LISTED | UNLISTED | FURTHER | FORMULAS


def with_effects(craft: Craft, effects: Sequence[HiddenEffect], kinds: Mapping[str, EffectKind] = KINDS) -> Craft:
    """Return the craft with effects in it."""
    for hidden in effects:
        craft = kinds[hidden.effect].apply(craft, hidden.component, hidden.parameters)
    return craft
