"""Progress callbacks of a reproduction's parts."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

Advance: TypeAlias = Callable[[int], None]
"""Called with the number of further items of a part that are done."""

Progress: TypeAlias = Callable[[str, int], Advance]
"""Begins a part; called with its title and its number of items: runs, flights, designs."""


def silent(_part: str, _items: int) -> Advance:
    """Show nothing."""
    return lambda _done: None
