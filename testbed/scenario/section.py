"""What all sections of a scenario share: strict validation, and reports of inconsistent keys."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from pydantic import BaseModel, ConfigDict


class Section(BaseModel):
    """One table of the file. Unknown keys, text for numbers, NaN and infinity are refused.

    The text below a field becomes its description in the JSON Schema, in docs/scenarios.md and in messages.
    """

    model_config = ConfigDict(
        frozen=True, extra="forbid", strict=True, allow_inf_nan=False, use_attribute_docstrings=True
    )


@dataclass(frozen=True, kw_only=True)
class Conflict:
    """A key whose value is inconsistent with the rest of the scenario.

    Attributes:
        key: the key to mend, dotted; from the section being checked, or from the root of the file.
        text: what was wrong and what to do.
    """

    key: str
    text: str


class ConflictError(ValueError):
    """All conflicts that one check found; `from_root` as in `refuse`."""

    def __init__(self, conflicts: tuple[Conflict, ...], from_root: bool) -> None:
        super().__init__("; ".join(f"{conflict.key}: {conflict.text}" for conflict in conflicts))
        self.conflicts = conflicts
        self.from_root = from_root


def refuse(conflicts: Iterable[Conflict], *, from_root: bool = False) -> None:
    """Raise all conflicts at once.

    Args:
        conflicts: what a check found.
        from_root: whether their keys count from the root of the file, not from the section being checked.

    Raises:
        ConflictError: there is at least one.
    """
    found = tuple(conflicts)
    if found:
        raise ConflictError(found, from_root)
