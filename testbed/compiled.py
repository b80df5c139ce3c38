"""Loops as machine code: over time where they are long enough to be worth making it, and over many small vectors."""

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


@cache
def kept(loop: _Loop, *signatures: tuple[tuple[str, int], ...]) -> _Loop:
    """Return a function that fills the array given last, as machine code that is made once on a machine.

    It lies beside the source, or in the user's cache folder, and may be made by many processes at once; where neither
    can be written, every process makes its own, which takes a second. (Functions that broadcast by themselves,
    Numba's `guvectorize`, have two files each, of which one process may keep the first and another the second: what
    is loaded from them crashes.)

    Args:
        loop: plain Python on arrays; all but the last are read, whatever their strides.
        signatures: kind of number and number of axes of each array, as in ("f8", 3); the first that fits is used.
    """
    from numba import njit, types  # noqa: PLC0415 - 0.2 s, which most commands need not take

    def arrays(signature: tuple[tuple[str, int], ...]) -> Any:  # noqa: ANN401 - Numba has no types
        read = [types.Array(getattr(types, kind), axes, "A", readonly=True) for kind, axes in signature[:-1]]
        written = types.Array(getattr(types, signature[-1][0]), signature[-1][1], "C")
        return types.void(*read, written)

    compile_now: Any = njit
    made = [arrays(each) for each in signatures]
    try:
        fast: _Loop = compile_now(made, cache=True)(loop)
    except RuntimeError:  # no folder to keep it in
        fast = compile_now(made)(loop)
    return fast
