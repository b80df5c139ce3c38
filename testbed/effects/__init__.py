"""The named effects that a model may be missing: one file each, one shared contract."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from testbed.effects.contract import NamedEffect


def registered() -> Mapping[str, NamedEffect]:
    """Return all effects that a diagnosis tests for, by id, those of other packages included.

    Example:
        >>> import testbed as tb
        >>> tb.effects.registered()["viscous_drag"].parameters[0].unit
        'N·m·s/rad'
    """
    from testbed.effects.registry import EFFECTS, NOISE_EFFECTS  # noqa: PLC0415 - the contract is imported without it

    return {**EFFECTS, **NOISE_EFFECTS}
