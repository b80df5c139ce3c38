"""From errors to messages and exit codes."""

from __future__ import annotations

import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType

from testbed.errors import InfeasibleDesignError, InputError

COMPLETED = 0
BAD_INPUT = 2
DIVERGED = 3
INTERRUPTED = 130
"""128 + SIGINT, as shells have it."""


def exit_code_of(command: Callable[[], object]) -> int:
    """Run a command and return its exit code; what a person can mend is printed without a traceback.

    Args:
        command: a Typer application; it ends with SystemExit, and reports what is wrong with its options by itself.
    """
    try:
        with _ended_as_interrupted():
            command()
    except InputError as error:
        print(f"error: {error}", file=sys.stderr)
        return BAD_INPUT
    except SystemExit as end:
        return end.code if isinstance(end.code, int) else COMPLETED
    return COMPLETED


@contextmanager
def _ended_as_interrupted() -> Iterator[None]:
    """Take a request to end, as batch systems and containers send it, for Ctrl-C: what was found so far is kept."""
    before = signal.signal(signal.SIGTERM, _interrupt)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)


def _interrupt(signum: int, frame: FrameType | None) -> None:
    """Do what is done at Ctrl-C; also where that is ignored, as of commands in a script's background."""
    handler = signal.getsignal(signal.SIGINT)
    (handler if callable(handler) else signal.default_int_handler)(signum, frame)


@contextmanager
def naming(path: Path) -> Iterator[None]:
    """Put the scenario's path before what is said of its maneuver."""
    try:
        yield
    except InfeasibleDesignError as error:
        raise InputError(f"{path}: [maneuver]: {error}") from error
