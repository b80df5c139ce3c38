"""Entry point of the command: output streams that accept any text, one BLAS thread, then the application."""

from __future__ import annotations

import os
import sys
import warnings
from pathlib import Path

from testbed.cli.failures import exit_code_of
from testbed.cli.streams import sturdy_streams
from testbed.errors import InputError


def main() -> None:
    """Run the command; what a person can mend ends it with a message and exit code 2."""
    for library in ("OMP", "OPENBLAS", "MKL"):  # matrices of this size gain nothing from threads, and lose time to them
        os.environ.setdefault(f"{library}_NUM_THREADS", "1")
    for size in ("COLUMNS", "LINES"):
        if set(os.environ.get(size, "")) == {"0"}:  # it is not known; taken for a width, nothing would be printed
            del os.environ[size]
    if not sys.warnoptions:  # Python's own warnings are for programmers, who ask for them
        warnings.simplefilter("ignore")
    with sturdy_streams() as lost_output:
        code = exit_code_of(_application)
        code = lost_output() or code
    sys.exit(code)


def _application() -> None:
    if not _working_folder_exists():  # importing a library would fail on it first
        raise InputError("the working folder has been removed; change to another one and repeat the command")
    from testbed.cli.app import app  # noqa: PLC0415 - here Ctrl-C is already heard

    app()


def _working_folder_exists() -> bool:
    try:
        Path.cwd()
    except FileNotFoundError:
        return False
    return True
