"""Finished parts as JSON and back, to the last bit: numbers, arrays, splines, and records of a few known types."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, is_dataclass
from typing import Any

import numpy as np
from scipy.interpolate import BSpline


@dataclass(frozen=True, kw_only=True)
class Codec:
    """Writes and reads records.

    Attributes:
        types: frozen dataclasses and named tuples that may stand in a file; nothing else is ever made from one.
    """

    types: tuple[type, ...]

    def encoded(self, value: Any) -> bytes:  # noqa: ANN401 - whatever a part consists of
        """Return a value as JSON."""
        return json.dumps(self._plain(value)).encode()

    def decoded(self, content: bytes) -> Any:  # noqa: ANN401
        """Return the value that JSON holds.

        Raises:
            ValueError: the content is not of this codec.
        """
        try:
            return self._made(json.loads(content))
        except (ValueError, KeyError, TypeError, StopIteration, RecursionError) as error:
            raise ValueError(f"is not a finished part ({error})") from error

    def _plain(self, value: Any) -> Any:  # noqa: ANN401
        if value is None or isinstance(value, bool | int | float | str):
            return value
        if isinstance(value, np.generic):
            return value.item()
        kind, content = self._tagged(value)
        return {"kind": kind, "content": content}

    def _tagged(self, value: Any) -> tuple[str, Any]:  # noqa: ANN401
        if isinstance(value, np.ndarray):
            return "array", {"dtype": value.dtype.str, "shape": value.shape, "values": value.ravel().tolist()}
        if isinstance(value, BSpline):
            return "spline", [self._plain(value.t), self._plain(value.c), value.k]
        if isinstance(value, Mapping):
            return "mapping", [[self._plain(key), self._plain(each)] for key, each in value.items()]
        if type(value) in self.types:
            return type(value).__name__, [self._plain(getattr(value, name)) for name in _names(type(value))]
        if isinstance(value, list | tuple):
            return type(value).__name__, [self._plain(each) for each in value]
        raise TypeError(f"{type(value).__name__} cannot be kept; add it to the codec's types")

    def _made(self, plain: Any) -> Any:  # noqa: ANN401
        if not isinstance(plain, dict):
            return plain
        kind, content = plain["kind"], plain["content"]
        if kind == "array":
            return np.array(content["values"], dtype=content["dtype"]).reshape(content["shape"])
        parts = [[self._made(each) for each in pair] if kind == "mapping" else self._made(pair) for pair in content]
        if kind == "spline":
            return BSpline(*parts)
        if kind in _CONTAINERS:
            return _CONTAINERS[kind](parts)
        made = next(each for each in self.types if each.__name__ == kind)
        return made(**dict(zip(_names(made), parts, strict=True)))


_CONTAINERS: Mapping[str, Any] = {"list": list, "tuple": tuple, "mapping": dict}


def _names(kind: type) -> Sequence[str]:
    if is_dataclass(kind):
        return [field.name for field in fields(kind)]
    return list(getattr(kind, "_fields"))  # noqa: B009 - of a named tuple, whose type does not show it
