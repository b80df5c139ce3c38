"""Commands as processes: started as a script would, signalled at a certain moment, ended whatever happens."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
PATIENCE = 1200.0
"""s, after which something hangs: a hundred times what anything here takes, for machines that are busy otherwise.
No test waits for it."""
MAIN = "from testbed.cli import main; main()"
WAITING = """
import pathlib, time
import testbed.cli.{command} as command
def waiting(*_, **__):
    pathlib.Path("here").touch()
    while True:
        time.sleep(0.05)
command.{work} = waiting
"""
"""Makes a command wait where its work begins, and a file appear there.

It sleeps a little at a time: a signal that comes between Python's last look for one and the start of a sleep is heard
at the sleep's end.
"""


@contextmanager
def started(
    *arguments: object,
    cwd: Path,
    before: str = "",
    signals_ignored: bool = False,
    environment: dict[str, str] | None = None,
    **options: Any,
) -> Iterator[subprocess.Popen]:
    """Start the testbed command in a session of its own; kill what is left of it at the block's end.

    Args:
        arguments: of the command.
        cwd: its working folder.
        before: Python that is run before the command, such as one that makes it wait at some point.
        signals_ignored: whether it inherits SIGINT and SIGTERM ignored, as what a script starts in the background does.
        environment: of the process, beside this one's.
        options: of Popen; its output is kept unless they say otherwise.
    """

    def ignore() -> None:
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, signal.SIG_IGN)

    keep = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    process = subprocess.Popen(
        [sys.executable, "-c", f"{before}\n{MAIN}", *map(str, arguments)],
        cwd=cwd,
        env={**os.environ, "PYTHONPATH": str(ROOT), **(environment or {})},
        start_new_session=True,
        preexec_fn=ignore if signals_ignored else None,  # noqa: PLW1509 - no test has threads that matter here
        **(keep | options),
    )
    try:
        yield process
    finally:
        with suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        process.communicate()


def until(happened: Callable[[], object], process: subprocess.Popen) -> None:
    """Wait until something has happened; fail where the process ends before it, or patience does."""
    began = time.monotonic()
    while not happened():
        assert process.poll() is None, process.communicate()
        assert time.monotonic() - began < PATIENCE, "it never happened"
        time.sleep(0.02)


def outcome(process: subprocess.Popen) -> tuple[int, str, str]:
    """Return a process's exit code, output and complaints; how far it was is said on a slow machine only."""
    output, complaints = process.communicate(timeout=PATIENCE)
    if isinstance(complaints, str):
        complaints = re.sub(r"(?m)^(Designing|Flying|Testing|Reading).*\n", "", complaints)
    return process.returncode, output, complaints


def of_group(group: int) -> Sequence[int]:
    """Return the processes of a group that are alive."""
    return [
        int(entry.name)
        for entry in Path("/proc").iterdir()
        if entry.name.isdigit() and _group_and_state(entry) in {(group, state) for state in "RSD"}
    ]


def _group_and_state(entry: Path) -> tuple[int, str] | None:
    with suppress(OSError):
        fields = (entry / "stat").read_text(errors="replace").rpartition(")")[2].split()
        return int(fields[2]), fields[0]
    return None
