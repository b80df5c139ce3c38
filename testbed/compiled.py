"""Loops as machine code: over time where they are long enough to be worth making it, and over many small vectors."""

from __future__ import annotations

import sys
from collections.abc import Callable
from functools import cache
from types import FunctionType
from typing import Any, TypeVar

LONG = 5_000
"""Steps from which a loop is compiled: that takes 0.8 s, as long as 25 loops of 5,000 steps take without."""


def compiler_loaded() -> bool:
    """Return whether something has loaded the compiler: what was kept of a loop is then quicker however short it is."""
    return "numba" in sys.modules


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
        loop: plain Python on arrays; all but the last are read, whatever their strides. Functions of its own module
            that it calls, and those that these call, are compiled into it.
        signatures: kind of number and number of axes of each array, as in ("f8", 3); the first that fits is used.
    """
    from numba import njit, types  # noqa: PLC0415 - 0.2 s, which most commands need not take

    def arrays(signature: tuple[tuple[str, int], ...]) -> Any:  # noqa: ANN401 - Numba has no types
        read = [types.Array(getattr(types, kind), axes, "A", readonly=True) for kind, axes in signature[:-1]]
        written = types.Array(getattr(types, signature[-1][0]), signature[-1][1], "C")
        return types.void(*read, written)

    compile_now: Any = njit
    made = [arrays(each) for each in signatures]
    whole = _with_parts(loop)
    try:
        fast: _Loop = compile_now(made, cache=True, **_FREE)(whole)
    except RuntimeError:  # no folder to keep it in
        fast = compile_now(made, **_FREE)(whole)
    return fast


_FREE = {"nogil": True, "error_model": "numpy"}
"""Other threads go on meanwhile, and a division by zero gives what NumPy gives, which spares a look at every one: the
equations of a gyrostat take 1.3 in the place of 1.9 microseconds a step."""


def _with_parts(loop: Callable[..., Any]) -> Callable[..., Any]:
    """Return a function whose calls of functions of its own module go to what is compiled of these."""
    names = [name for name in loop.__code__.co_names if isinstance(loop.__globals__.get(name), FunctionType)]
    own = {name: loop.__globals__[name] for name in names if loop.__globals__[name].__module__ == loop.__module__}
    if not own:
        return loop
    whole = FunctionType(loop.__code__, loop.__globals__ | {name: _part(each) for name, each in own.items()})
    whole.__qualname__, whole.__module__ = loop.__qualname__, loop.__module__
    return whole


@cache
def _part(of_loop: Callable[..., Any]) -> Callable[..., Any]:
    """Return a function that loops call, compiled as soon as one of them is, and once for all."""
    from numba import njit  # noqa: PLC0415 - as above

    compile_later: Any = njit
    part: Callable[..., Any] = compile_later(_with_parts(of_loop), **_FREE)
    return part
