"""From a scenario's maneuver section to the maneuver that is flown."""

from __future__ import annotations

from dataclasses import dataclass

from testbed.maneuver.maneuver import Maneuver


@dataclass(frozen=True, kw_only=True)
class Plan:
    """A maneuver to fly.

    Attributes:
        maneuver: the reference.
        design: how it was found; None for a maneuver that was given.
    """

    maneuver: Maneuver
