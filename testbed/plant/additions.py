"""Torques and parts that effects add to a platform: plain data, each of which writes itself into an MjSpec."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable

import mujoco


class Addition(ABC):
    """Something that is added to a platform; a subclass is a frozen dataclass of numbers."""

    @abstractmethod
    def write(self, spec: mujoco.MjSpec, name: str) -> None:
        """Write it into a platform's specification.

        Args:
            spec: with the parts that `require_parts` asks for.
            name: that whatever is added begins with.

        Raises:
            InputError: the platform cannot carry it.
        """


def add(spec: mujoco.MjSpec, additions: Iterable[Addition]) -> None:
    """Write additions into a platform's specification, in order.

    Args:
        spec: with the parts that `require_parts` asks for.
        additions: names of what they add begin with `added1`, `added2` and so on.

    Raises:
        InputError: the platform cannot carry one of them.
    """
    for number, addition in enumerate(additions, start=1):
        addition.write(spec, f"added{number}")
