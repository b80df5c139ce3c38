"""Cases run: every command in a process of its own, forked from one that has the engines loaded."""

from __future__ import annotations

import multiprocessing
import os
import resource
import shutil
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

from tests.robustness.case import COMPLETED, Case, Ended, Scene, faults

_ENGINES = [
    "testbed.cli.app",
    *(f"testbed.cli.{name}" for name in ("check", "design", "diagnose", "estimate", "montecarlo", "run", "view")),
]
_CONTEXT = multiprocessing.get_context("forkserver")
_CONTEXT.set_forkserver_preload(_ENGINES)
_UNKNOWN = 255
"""Exit code that multiprocessing gives where its fork server did not hear of the process's end: once in 2,000 cases."""
_MOST = 8e9
"""Bytes of data of a process, beyond which the system refuses it more: no case may take the machine down."""


def failures(case: Case | Scene) -> list[str]:
    """Run a case in a folder of its own; return what went wrong."""
    folder = Path(tempfile.mkdtemp(prefix="robustness-"))
    try:
        work = folder / "work"
        work.mkdir()
        if isinstance(case, Scene):
            return [f"{case.name}: {fault}" for fault in case.play(work)]
        case.prepare(work)
        ended: list[Ended] = []
        for arguments in case.commands:
            ended.append(run(arguments, work, folder / "streams", case.seconds))
            if ended[-1].code != COMPLETED:
                break
        return list(faults(case, ended))
    except Exception as error:  # a case that cannot be played is a failure, and the others go on
        return [f"{case.name}: cannot be played: {error!r}"]
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def run(arguments: Sequence[str], folder: Path, streams: Path, seconds: float) -> Ended:
    """Run a command in a folder; kill it when its time is up."""
    before = _names(folder)
    streams.mkdir(exist_ok=True)
    for name in ("megabytes", "code"):
        (streams / name).unlink(missing_ok=True)
    process = _CONTEXT.Process(target=_command, args=(tuple(arguments), folder, streams))
    began = time.monotonic()
    process.start()
    process.join(seconds)
    code = process.exitcode
    if code is None:
        process.kill()
        process.join()
    taken = time.monotonic() - began
    process.close()
    if code == _UNKNOWN and (kept := streams / "code").exists():
        code = int(kept.read_text())
    output, complaints = ((streams / name).read_text(errors="replace") for name in ("output", "complaints"))
    measured = streams / "megabytes"
    return Ended(
        code=code,
        output=output,
        complaints=complaints,
        seconds=taken,
        megabytes=float(measured.read_text()) if measured.exists() else 0.0,
        left=_names(folder) - before,
    )


def _names(folder: Path) -> frozenset[str]:
    return frozenset(path.name for path in folder.iterdir())


def _command(arguments: tuple[str, ...], folder: Path, streams: Path) -> None:
    for number, name in ((1, "output"), (2, "complaints")):
        handle = os.open(streams / name, os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
        os.dup2(handle, number)
    os.chdir(folder)
    resource.setrlimit(resource.RLIMIT_DATA, (int(_MOST), int(_MOST)))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    sys.argv = ["testbed", *arguments]
    from testbed.cli import main

    try:
        main()
    except SystemExit as end:
        (streams / "code").write_text(str(end.code or 0))
        raise
    finally:
        used = (resource.getrusage(who).ru_maxrss for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
        (streams / "megabytes").write_text(str(max(used) / 1024))
