"""Where in a TOML text a key stands."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator, Mapping
from typing import Any, TypeAlias

Place: TypeAlias = tuple[str | int, ...]
"""Keys and list indices from the root of the file."""


def key_lines(text: str) -> dict[Place, int]:
    """Return the line at which each key or table is first written, counted from 1.

    The parser itself says where a statement ends: every line up to which the text is valid TOML ends one. So
    strings and arrays over several lines need no grammar of their own here.

    Args:
        text: valid TOML.
    """
    lines: dict[Place, int] = {}
    rows = text.split("\n")
    start = 1
    for number in range(1, len(rows) + 1):
        try:
            tree = tomllib.loads("\n".join(rows[:number]))
        except tomllib.TOMLDecodeError:
            continue
        for place in _places(tree):
            lines.setdefault(place, start)
        start = number + 1
    return lines


def line_of(place: Place, lines: Mapping[Place, int]) -> int | None:
    """Return the line of a place, or of the innermost table or list around it that is written; None for the file.

    Args:
        place: the keys from the root.
        lines: as from `key_lines`.
    """
    written = (place[:depth] for depth in range(len(place), 0, -1))
    return next((lines[part] for part in written if part in lines), None)


def _places(tree: Mapping[str, Any], above: Place = ()) -> Iterator[Place]:
    for key, value in tree.items():
        yield (*above, key)
        if isinstance(value, dict):
            yield from _places(value, (*above, key))
