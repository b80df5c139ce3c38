"""Results of the expensive parts of a diagnosis, kept so that an interrupted one can be resumed.

A part is a search for parameters, or a test of the residual. It is a function of its arguments alone, and its name is
their hash: whoever asks for it again, in the same order or in another, gets what was kept. What is kept is plain JSON,
in which numbers are exact; the rest (residuals, Jacobians) follows from it by one prediction.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import fields, is_dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any, Protocol, TypeVar, runtime_checkable

import numpy as np
from scipy.interpolate import PPoly

from testbed.arrays import Array
from testbed.diagnosis.data import Runs

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

Content = dict[str, Any]
"""What JSON can hold of a part."""

_T = TypeVar("_T")
_REMEMBERED = 32
"""Sets of runs whose hash is remembered: a diagnosis goes back and forth between few, at most two for each of the eight
hypotheses that are refitted, and a hash takes as long as its bytes are read."""


@runtime_checkable
class Store(Protocol):
    """Where parts are kept."""

    def get(self, name: str) -> Content | None:
        """Return what is kept under a name; None where nothing is."""

    def put(self, name: str, content: Content) -> None:
        """Keep content under a name."""


_STORE: ContextVar[Store | None] = ContextVar("store", default=None)


@contextmanager
def keeping(store: Store) -> Iterator[None]:
    """Keep the parts that are worked out in a block, and take those that are kept from the store.

    Args:
        store: of one diagnosis.
    """
    token = _STORE.set(store)
    try:
        yield
    finally:
        _STORE.reset(token)


def part(
    kind: str,
    deciding: Sequence[object],
    *,
    work: Callable[[], _T],
    to_content: Callable[[_T], Content],
    from_content: Callable[[Content], _T],
) -> _T:
    """Return a part, worked out or as it was kept.

    Args:
        kind: of part.
        deciding: all that decides it: runs, arrays, numbers, texts, dataclasses and tuples of these.
        work: works it out.
        to_content: returns the JSON content that is kept.
        from_content: rebuilds the part from that content.
    """
    store = _STORE.get()
    if store is None:
        return work()
    name = hash_of(kind, *deciding)
    content = store.get(name)
    if content is not None:
        return from_content(content)
    result = work()
    store.put(name, to_content(result))
    return result


def hash_of(*values: object) -> str:
    """Return a hash of values, arrays to the last bit.

    Raises:
        TypeError: a value is of a kind that says nothing of its content.
    """
    digest = hashlib.sha256()
    for piece in _pieces(values):
        digest.update(len(piece).to_bytes(8, "little") + piece)
    return digest.hexdigest()


def _pieces(value: object) -> Iterator[bytes]:
    if isinstance(value, Runs):
        yield _hash_of_runs(value)
    elif isinstance(value, np.ndarray):
        yield f"{value.dtype} {value.shape}".encode()
        yield np.ascontiguousarray(value).tobytes()
    elif isinstance(value, tuple | list):
        yield f"{len(value)} values".encode()
        for each in value:
            yield from _pieces(each)
    elif isinstance(value, PPoly):  # splines of what lies around a platform
        yield from _pieces((value.x, value.c))
    elif is_dataclass(value) and not isinstance(value, type):
        yield from _fields(value)
    elif value is None or isinstance(value, str | int | float):
        yield repr(value).encode()
    else:
        raise TypeError(f"{type(value)}: cannot be hashed by its content")


def _fields(value: DataclassInstance) -> Iterator[bytes]:
    yield type(value).__qualname__.encode()
    for field in fields(value):
        yield field.name.encode()
        yield from _pieces(getattr(value, field.name))


@lru_cache(maxsize=_REMEMBERED)
def _hash_of_runs(runs: Runs) -> bytes:
    digest = hashlib.sha256()
    for piece in _fields(runs):
        digest.update(len(piece).to_bytes(8, "little") + piece)
    return digest.digest()


def array_to_content(values: Array) -> Content:
    """Return an array as JSON holds it, exactly: its shape, and its numbers one after the other."""
    return {"shape": list(values.shape), "numbers": values.ravel().tolist()}


def array_from_content(content: Content) -> Array:
    """Return the array of what `array_to_content` returned."""
    return np.array(content["numbers"], dtype=float).reshape(content["shape"])
