"""Where in a TOML text a key stands."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator, Mapping
from contextlib import suppress
from typing import Any, TypeAlias

Place: TypeAlias = tuple[str | int, ...]
"""Keys and list indices from the root of the file."""


_MOST_PARSED = 5_000_000
"""Characters that are parsed, a second's work: a value of thousands of lines is parsed once for each of them."""


def key_lines(text: str) -> dict[Place, int]:
    """Return the line at which each key or table is first written, counted from 1.

    The parser itself says where a statement ends: at the first line at which what began is valid TOML. So strings and
    arrays over several lines need no grammar of their own here. Beyond what takes too long to parse no line is known.

    Args:
        text: valid TOML.
    """
    lines: dict[Place, int] = {}
    table: Place = ()
    last: dict[Place, int] = {}
    statement, start, parsed = "", 1, 0
    for number, row in enumerate(text.split("\n"), start=1):
        statement += f"{row}\n"
        parsed += len(statement)
        if parsed > _MOST_PARSED:
            break
        with suppress(tomllib.TOMLDecodeError):
            tree = tomllib.loads(statement)
            is_header = statement.lstrip().startswith("[")
            places = list(_places(tree, () if is_header else table))
            if is_header:
                places = _entries(places, last, is_next=statement.lstrip().startswith("[["))
                table = places[-1]
            for place in places:
                lines.setdefault(place, start)
            statement, start = "", number + 1
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


def _entries(places: list[Place], last: dict[Place, int], *, is_next: bool) -> list[Place]:
    """Return the places of a header with the entry of every array of tables on their way.

    Args:
        places: of the header, outermost first.
        last: of every array of tables its last entry so far, from 0; the next one is added.
        is_next: whether the header, in double brackets, begins the next entry of its array.
    """
    found: list[Place] = []
    above: Place = ()
    for place in places:
        above = (*above, place[-1])
        found.append(above)
        if is_next and place == places[-1]:
            last[above] = last.get(above, -1) + 1
        if above in last:
            above = (*above, last[above])
            found.append(above)
    return found
