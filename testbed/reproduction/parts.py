"""Where a reproduction's finished parts are kept, for one that is interrupted."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any, Protocol

from testbed.assembly.platform import nominal_platform
from testbed.experiment.planning import plan_maneuver
from testbed.maneuver.maneuver import Maneuver
from testbed.scenario.scenario import Scenario


class Parts(Protocol):
    """Keeps what is finished under names."""

    @property
    def elapsed(self) -> float:
        """Time that the reproduction took until now, all starts together, s."""
        ...

    def result(self, name: str) -> Any:  # noqa: ANN401 - whatever a part consists of
        """Return what was kept; None where nothing was."""
        ...

    def keep(self, name: str, result: Any) -> None:  # noqa: ANN401
        """Keep what is finished."""
        ...

    def campaign(self, name: str) -> Path | None:
        """Return the folder in which a campaign keeps its own parts; None where it is to keep none."""
        ...


class Nowhere:
    """Keeps nothing."""

    def __init__(self) -> None:
        """Remember the time."""
        self._began = time.monotonic()

    @property
    def elapsed(self) -> float:
        """Time since this was made, s."""
        return time.monotonic() - self._began

    def result(self, _name: str) -> None:
        """Return nothing."""

    def keep(self, _name: str, _result: object) -> None:
        """Forget."""

    def campaign(self, _name: str) -> None:
        """Return no folder."""


NOWHERE: Parts = Nowhere()


def kept_maneuver(scenario: Scenario, parts: Parts) -> Maneuver:
    """Return a scenario's maneuver, designed once: all seeds and all starts of a reproduction fly the same.

    Args:
        scenario: with its maneuver or the task to design one.
        parts: of the reproduction.
    """
    name = f"maneuver-{scenario.name}"
    kept: Maneuver | None = parts.result(name)
    if kept is None:
        kept = plan_maneuver(scenario, nominal_platform(scenario)).maneuver
        parts.keep(name, kept)
    return kept
