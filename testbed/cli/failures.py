"""From errors to messages and exit codes."""

from __future__ import annotations

import sys
from collections.abc import Callable

import click

from testbed.errors import DivergedError, InputError

COMPLETED = 0
BAD_INPUT = 2
DIVERGED = 3
_INTERRUPTED = 130


def exit_code_of(command: Callable[[], object]) -> int:
    """Run a command and return its exit code; what a person can mend is printed without a traceback.

    Args:
        command: returns nothing, or an exit code of its own.
    """
    try:
        code = command()
    except (InputError, click.ClickException) as error:
        _say(error.format_message() if isinstance(error, click.ClickException) else str(error))
        return BAD_INPUT
    except DivergedError as error:
        _say(str(error))
        return DIVERGED
    except (KeyboardInterrupt, click.Abort):
        _say("interrupted; nothing half-written was left behind")
        return _INTERRUPTED
    return code if isinstance(code, int) else COMPLETED


def _say(message: str) -> None:
    print(f"error: {message}", file=sys.stderr)
