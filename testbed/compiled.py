"""Loops as machine code: over time where they are long enough to be worth making it, and over elements of arrays."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any, TypeVar

import numpy as np

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
def elementwise(loop: Callable[..., None], layout: str, types: tuple[str, ...]) -> np.ufunc:
    """Return a function of arrays that broadcasts as NumPy's own do, from plain Python on the elements' numbers.

    It is compiled once on a machine and kept beside the source, or in the user's cache folder; where neither can be
    written, once in every process, which takes a second.

    Args:
        loop: takes the elements, then the array of the result.
        layout: of an element's axes, as in "(n),(n,n)->(n)".
        types: of the numbers, in Numba's words, the first that fits being used.
    """
    from numba import guvectorize  # noqa: PLC0415 - 0.2 s, which most commands need not take

    vectorize: Any = guvectorize
    try:
        function: np.ufunc = vectorize(types, layout, cache=True)(loop)
    except RuntimeError:  # no folder to keep it in
        function = vectorize(types, layout)(loop)
    return function
