"""From pydantic's errors to problems that a person can mend: the place, what was wrong, what to do."""

from __future__ import annotations

import difflib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from pydantic import ValidationError
from pydantic_core import ErrorDetails

from testbed.scenario.keys import DISCRIMINATORS, Parsed, choices_at, keys_at, meaning
from testbed.scenario.places import Place
from testbed.scenario.section import ConflictError

_LONGEST_SHOWN = 60
_WORDS = {
    "tuple_type": "should be a list",
    "model_type": "should be a table",
    "model_attributes_type": "should be a table",
}
"""What is said in place of pydantic's own words, which speak of Python."""


@dataclass(frozen=True, kw_only=True)
class Problem:
    """One thing wrong with a scenario.

    Attributes:
        place: the keys from the root of the file.
        text: what was wrong and what to do.
    """

    place: Place
    text: str

    def __str__(self) -> str:
        parts = (f"[{part + 1}]" if isinstance(part, int) else f".{part}" for part in self.place)
        return f"{''.join(parts).removeprefix('.')}: {self.text}"


def problems_of(error: ValidationError, parsed: Parsed) -> list[Problem]:
    """Return every problem that a validation found; list entries count from 1.

    Args:
        error: pydantic's.
        parsed: the file, in which the places are looked up.
    """
    details = [(detail, _place(detail["loc"], parsed.tree)) for detail in error.errors()]
    unknown = [place for detail, place in details if detail["type"] == "extra_forbidden"]
    mistyped = {(*place[:-1], _nearest(place, parsed)) for place in unknown}
    within = {place[:length] for _, place in details for length in range(len(place))}
    kept = [
        (detail, place)
        for detail, place in details
        # A list whose entries are wrong counts as without these.
        if (detail["type"] != "missing" or place not in mistyped)
        and (detail["type"] != "too_short" or place not in within)
    ]
    return [problem for detail, place in kept for problem in _problems(detail, place, parsed)]


def _problems(detail: ErrorDetails, place: Place, parsed: Parsed) -> Iterator[Problem]:
    cause = detail.get("ctx", {}).get("error")
    if isinstance(cause, ConflictError):
        above = () if cause.from_root else place
        for conflict in cause.conflicts:
            yield Problem(place=(*above, *conflict.key.split(".")), text=conflict.text)
    elif detail["type"].startswith("union_tag"):
        yield _formless(detail, place, parsed)
    else:
        yield Problem(place=place, text=_text(detail, place, parsed))


def _formless(detail: ErrorDetails, place: Place, parsed: Parsed) -> Problem:
    """The key that chooses between the forms of a table is missing or mistyped, or its value names none."""
    key, tag = detail["ctx"]["discriminator"].strip("'"), detail["ctx"].get("tag")
    choices = detail["ctx"].get("expected_tags") or str(choices_at((*place, key), parsed)).strip("[]")
    if tag is not None:
        return Problem(place=(*place, key), text=f"is '{tag}', which is unknown; use one of {choices}")
    for typo in difflib.get_close_matches(key, detail["input"], n=1):
        return Problem(place=(*place, typo), text=f"unknown key; did you mean {key}? It is one of {choices}")
    return Problem(place=(*place, key), text=f"is missing; use one of {choices}")


def _text(detail: ErrorDetails, place: Place, parsed: Parsed) -> str:
    match detail["type"]:
        case "extra_forbidden":
            return f"unknown key; {_suggestion(place, parsed)}"
        case "missing":
            return f"is missing; add it: {meaning(place, parsed)}"
        case "value_error":
            wrong = str(detail["ctx"]["error"])
        case "greater_than_equal":
            wrong = f"should be at least {detail['ctx']['ge']:g}, not {_shown(detail['input'])}"
        case "less_than_equal":
            wrong = f"should be at most {detail['ctx']['le']:g}, not {_shown(detail['input'])}"
        case "too_long":
            wrong = f"should have at most {detail['ctx']['max_length']} entries, not {detail['ctx']['actual_length']}"
        case "too_short":
            least, given = detail["ctx"]["min_length"], detail["ctx"]["actual_length"]
            wrong = f"should have at least {least} {'entry' if least == 1 else 'entries'}, not {given}"
        case "string_pattern_mismatch":
            wrong = f"should match {detail['ctx']['pattern']}, not {_shown(detail['input'])}"
        case _:
            expected = _WORDS.get(detail["type"], detail["msg"].removeprefix("Input "))
            wrong = f"{expected}, not {_shown(detail['input'])}"
    return f"{wrong}; give: {meaning(place, parsed)}"


def _suggestion(place: Place, parsed: Parsed) -> str:
    near = _nearest(place, parsed)
    if near == place[-1]:  # known where the scenario describes a flight
        return "it is part of a flight, which nothing else here describes: take it out, or add what a flight needs"
    if near is None:
        return f"the keys here are {', '.join(keys_at(place[:-1], parsed))}"
    return f"did you mean {near}? It gives: {meaning((*place[:-1], near), parsed)}"


def _nearest(place: Place, parsed: Parsed) -> str | None:
    return next(iter(difflib.get_close_matches(str(place[-1]), keys_at(place[:-1], parsed), n=1)), None)


def _place(location: tuple[str | int, ...], tree: Mapping[str, Any]) -> Place:
    """Drop from pydantic's location what names a form of a union instead of a key."""
    place: list[str | int] = []
    value: object = tree
    for part in location:
        if not _names_form(part, value):
            place.append(part)
            value = _entry(value, part)
    return tuple(place)


def _names_form(part: str | int, value: object) -> bool:
    if isinstance(value, dict):
        return part not in value and part in [value.get(key) for key in DISCRIMINATORS]
    return isinstance(part, str)


def _entry(value: object, part: str | int) -> object:
    if isinstance(value, dict):
        return value.get(part)
    return value[part] if isinstance(value, list) and isinstance(part, int) else None


def _shown(value: object) -> str:
    try:
        text = repr(value)
    except ValueError:  # Python writes none of more than 4,300 digits
        return "an integer of thousands of digits"
    return text if len(text) <= _LONGEST_SHOWN else f"{text[:_LONGEST_SHOWN]}..."
