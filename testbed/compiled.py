"""Loops over time as machine code, where they are long enough to be worth making it."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any, TypeVar

LONG = 5_000
"""Steps from which a loop is compiled: that takes 0.8 s, as long as 25 loops of 5,000 steps take without."""

_Loop = TypeVar("_Loop", bound=Callable[..., Any])


@cache
def compiled(loop: _Loop) -> _Loop:
    """Return a function of numbers and arrays as machine code; its results are the same to the last bit.

    Args:
        loop: plain Python on plain numbers; functions that it calls are compiled too, and given as arguments.
    """
    from numba import njit  # noqa: PLC0415 - 0.2 s, which short runs need not take

    fast: _Loop = njit(loop)
    return fast
