"""From errors to messages and exit codes."""

from __future__ import annotations

import sys
import tempfile
import traceback
from collections.abc import Callable

from testbed.errors import DivergedFlightError, InputError, OwnEffectError
from testbed.interrupts import Interrupted, heard_interrupts

COMPLETED = 0
BAD_INPUT = 2
DIVERGED = 3
BUG = 70
"""EX_SOFTWARE of sysexits.h: an internal software error has been detected."""
INTERRUPTED = 130
"""128 + SIGINT, as shells have it."""


def exit_code_of(command: Callable[[], object]) -> int:
    """Run a command and return its exit code; what a person can mend is printed without a traceback.

    Args:
        command: a Typer application; it ends with SystemExit, and reports what is wrong with its options by itself.
    """
    try:
        with heard_interrupts():
            command()
    except (InputError, OwnEffectError) as error:
        return _ended(f"error: {error}", DIVERGED if isinstance(error, DivergedFlightError) else BAD_INPUT)
    except (Interrupted, KeyboardInterrupt) as interrupt:
        return _ended("; ".join(["Interrupted", *map(str, interrupt.args)]) + ".", INTERRUPTED)
    except SystemExit as end:
        return end.code if isinstance(end.code, int) else COMPLETED
    except MemoryError:
        return _ended("error: memory ran out; give it more, or a smaller scenario or record", BAD_INPUT)
    except Exception as bug:  # the last line of defence: that anything gets here is a bug of ours
        return _ended(_bug_message(bug), BUG)
    return COMPLETED


def _ended(message: str, code: int) -> int:
    print(message, file=sys.stderr)
    return code


def _bug_message(bug: Exception) -> str:
    """Return what to say of an error that nobody expected, its traceback kept where it disturbs nobody."""
    said = f"error: testbed failed on a bug of its own ({type(bug).__name__}), nothing that you did wrong"
    details = "".join(traceback.format_exception(bug))
    try:
        with tempfile.NamedTemporaryFile(
            "w", prefix="testbed-", suffix=".log", encoding="utf-8", errors="backslashreplace", delete=False
        ) as log:
            log.write(f"{' '.join(sys.argv)}\n\n{details}")
    except OSError:
        return f"{said}; please report it with these lines:\n{details}"
    return f"{said}; please report it with {log.name}"
