"""Which keys the schema knows at a place of a file, and what they mean."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, get_args

from pydantic.fields import FieldInfo

from testbed.scenario.places import Place
from testbed.scenario.section import Section

DISCRIMINATORS = ("kind", "parametrization", "law")
"""Keys whose value chooses between the forms of a table."""


@dataclass(frozen=True, kw_only=True)
class Parsed:
    """A file as parsed, and what it should be.

    Attributes:
        tree: its tables.
        form: the section that the whole of it should be.
    """

    tree: Mapping[str, Any]
    form: type[Section]


def keys_at(place: Place, parsed: Parsed) -> list[str]:
    """Return the keys that the table at a place may have, in the order of the schema.

    Args:
        place: of the table.
        parsed: the file; it tells which form of a table was chosen.
    """
    return list(dict.fromkeys(key for section in _sections_at(place, parsed) for key in _fields(section)))


def meaning(place: Place, parsed: Parsed) -> str:
    """Return the description of the key at a place, without its closing full stop; empty for an unknown key.

    Args:
        place: of the key, or of an entry of its list.
        parsed: the file.
    """
    keys = [part for part in place if isinstance(part, str)]
    found = (_fields(section).get(keys[-1]) for section in _sections_at(tuple(keys[:-1]), parsed))
    said = next((field.description or "" for field in found if field is not None), "")
    return " ".join(said.split()).removesuffix(".")


def choices_at(place: Place, parsed: Parsed) -> list[str]:
    """Return the values that a discriminator at a place may have."""
    sections = _sections_at(place[:-1], parsed)
    return list(dict.fromkeys(_literal(section, str(place[-1])) for section in sections))


def _sections_at(place: Place, parsed: Parsed) -> list[type[Section]]:
    sections: list[type[Section]] = [parsed.form]
    value: object = parsed.tree
    for part in place:
        if isinstance(part, int):  # an entry of a list of tables is of the list's own form
            value = value[part] if isinstance(value, list) and part < len(value) else None
            sections = [section for section in sections if _is_chosen(section, value)]
            continue
        value = value.get(part) if isinstance(value, dict) else None
        fields = (_fields(section).get(str(part)) for section in sections)
        sections = [form for field in fields if field is not None for form in _sections_in(field.annotation)]
        sections = [section for section in sections if _is_chosen(section, value)]
    return sections


def _fields(section: type[Section]) -> dict[str, FieldInfo]:
    return {field.alias or name: field for name, field in section.model_fields.items()}


def _sections_in(annotation: object) -> Iterator[type[Section]]:
    if isinstance(annotation, type) and issubclass(annotation, Section):
        yield annotation
    for part in get_args(annotation):
        yield from _sections_in(part)


def _is_chosen(section: type[Section], value: object) -> bool:
    given = value if isinstance(value, dict) else {}
    return all(
        given[key] == _literal(section, key) for key in DISCRIMINATORS if key in given and key in section.model_fields
    )


def _literal(section: type[Section], key: str) -> str:
    return str(get_args(section.model_fields[key].annotation)[0])
