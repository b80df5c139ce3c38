"""Errors that a person reads: each message says what was wrong, where, and what to do."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TypeVar

_Given = TypeVar("_Given")
_Made = TypeVar("_Made")


class InputError(Exception):
    """Input that cannot be used: a file, a scenario, a record, a limit. The command exits with code 2."""


class OutputError(InputError):
    """A result that cannot be written: no room, no permission, no such place."""


class UnphysicalPlatformError(InputError):
    """The mass properties of a platform that no rigid body can have."""

    def __init__(self, key: str, text: str) -> None:
        """Say which key of the platform is wrong, and how; the section before it is the caller's to know."""
        super().__init__(key, text)
        self.key, self.text = key, text

    def __str__(self) -> str:
        """Return the message."""
        return f"{self.key}{self.text}"


class DivergedFlightError(InputError):
    """A simulated flight on which something depends left the finite numbers. The command exits with code 3."""


class InfeasibleDesignError(InputError):
    """No start of a maneuver design satisfied its constraints."""


class UnidentifiableError(InputError):
    """The data do not determine all parameters; the message names the directions that they leave open."""


class OwnEffectError(Exception):
    """A mistake in an effect from outside the library, met in a prediction.

    No `InputError`: a diagnosis takes that for a motion that runs away, and goes on. Users read it as one.
    """


def made_of_each(work: Callable[[_Given], _Made], items: Iterable[_Given]) -> list[_Made]:
    """Return what is made of every item.

    Args:
        work: makes it, or refuses the item.
        items: to make it of.

    Raises:
        InputError: some are refused; all of these are named, a line each.
    """
    made, refused = list[_Made](), list[str]()
    for item in items:
        try:
            made.append(work(item))
        except InputError as error:
            refused.append(str(error))
    if refused:
        raise InputError("\n".join(refused))
    return made


def words_of(error: Exception) -> str:
    """Return what is wrong with a file's content, of an error that reading it raised: of a key, that it is missing."""
    return f"{error.args[0]} is missing" if isinstance(error, KeyError) else str(error)
