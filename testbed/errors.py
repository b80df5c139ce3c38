"""Errors that a person reads: each message says what was wrong, where, and what to do."""

from __future__ import annotations


class InputError(Exception):
    """Input that cannot be used: a file, a scenario, a record, a limit. The command exits with code 2."""


class InfeasibleDesignError(InputError):
    """No start of a maneuver design satisfied its constraints."""


class UnidentifiableError(InputError):
    """The data do not determine all parameters; the message names the directions that they leave open."""
