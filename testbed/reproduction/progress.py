"""How the parts of a reproduction tell how far they are."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

Advance: TypeAlias = Callable[[int], None]
"""Told how many more items of a part are done."""

Progress: TypeAlias = Callable[[str, int], Advance]
"""Begins a part, told what a person calls it and of how many items it consists: runs, flights, designs."""


def silent(_part: str, _items: int) -> Advance:
    """Show nothing."""
    return lambda _done: None
