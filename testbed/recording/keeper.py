"""Runs a viewer for a command, and ends it with that command, whatever ended it.

A process of its own that needs nothing but the standard library. Its standard input is a pipe that the command holds:
the system closes it also where the command was killed.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Sequence
from contextlib import suppress
from threading import Thread

PATIENCE = 3.0
"""s, that the viewer has to end after each request; it takes 0.1 s where it is well."""


def keep(command: Sequence[str]) -> int:
    """Run a viewer until it ends or standard input does; return its exit code."""
    for request in (signal.SIGINT, signal.SIGTERM):
        signal.signal(request, signal.SIG_DFL)  # a viewer that inherits them ignored hears neither
    viewer = subprocess.Popen(command, stdin=subprocess.DEVNULL)
    for request in (signal.SIGINT, signal.SIGTERM):
        signal.signal(request, lambda *_: _end(viewer))
    Thread(target=_end_with_input, args=(viewer,), daemon=True).start()
    return viewer.wait()


def _end_with_input(viewer: subprocess.Popen[bytes]) -> None:
    os.read(sys.stdin.fileno(), 1)  # returns at its end; a read that locks it would spoil the end of this process
    _end(viewer)


def _end(viewer: subprocess.Popen[bytes]) -> None:
    """End a viewer, politely first."""
    for request in (signal.SIGINT, signal.SIGTERM, signal.SIGKILL):
        viewer.send_signal(request)
        with suppress(subprocess.TimeoutExpired):
            viewer.wait(PATIENCE)
            return


if __name__ == "__main__":
    sys.exit(keep(sys.argv[1:]))
