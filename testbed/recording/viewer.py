"""Opening a recording for a person: in the native viewer, or in a browser."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
import warnings
from contextlib import nullcontext, suppress
from pathlib import Path

import rerun_cli
from rerun.chunk import RrdReader
from rerun.error_utils import RerunWarning

from testbed.errors import InputError
from testbed.interrupts import HEARING
from testbed.recording import keeper
from testbed.recording.offline_page import LOOPBACK, offline_page

_NO_EXAMPLES = "hide_welcome_screen=1"
"""Of what the page asks the internet for, the list of examples is all that rerun 0.41 lets one switch off."""
_ASKS_OUTSIDE = "The page asks hosts of rerun, GitHub and Google for news and a font; --offline keeps it from that."


def open_viewer(path: Path, *, web: bool, offline: bool = False) -> None:
    """Show a recording until the viewer is closed or, in a browser, until the command is interrupted.

    Args:
        path: of an .rrd file.
        web: serve the viewer to a browser on this machine, and print its address; nothing is served to others.
        offline: whether the browser is kept from asking any other host; with `web` only.

    Raises:
        InputError: the file is missing or no recording.
    """
    check_recording(path)
    code = _serve(path, offline=offline) if web else _run(_command(path, "--port", "auto"))
    if code:
        elsewhere = "" if web else "; where there is no screen, `testbed view --web` serves it to a browser"
        raise InputError(f"{path}: the viewer ended with exit code {code}, see above{elsewhere}")


def check_recording(path: Path) -> None:
    """Read a recording's table of contents.

    Raises:
        InputError: the file is missing or no whole recording.
    """
    if not path.is_file():
        raise InputError(f"{path}: no such recording; `testbed run` writes recording.rrd into the run's folder")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RerunWarning)  # that a cut file has no footer is said by the error
            RrdReader(path).store()
    except RuntimeError as error:
        raise InputError(f"{path}: not a whole recording ({error}); run the scenario again") from error


def _run(command: list[str]) -> int | None:
    """Run a viewer; return its exit code, None where it was ended by Ctrl-C.

    It has a keeper, which ends it with this process, and both have a group of processes of their own: Ctrl-C reaches
    them from here alone, and nothing of the group is left behind.
    """
    started = [sys.executable, "-I", keeper.__file__, *command]
    environment = {"RUST_LOG": "warn", **os.environ}  # what the viewer logs of itself is no message of this command
    with subprocess.Popen(started, stdin=subprocess.PIPE, start_new_session=True, env=environment) as kept:
        try:
            while kept.poll() is None:
                with suppress(subprocess.TimeoutExpired):
                    kept.wait(HEARING)
        except KeyboardInterrupt:
            return None
        else:
            return kept.returncode
        finally:
            _end(kept)


def _end(kept: subprocess.Popen[bytes]) -> None:
    """Let go of the viewer, which its keeper then ends; kill what does not."""
    assert kept.stdin is not None
    try:
        kept.stdin.close()
        kept.wait(3.5 * keeper.PATIENCE)
    except subprocess.TimeoutExpired:
        pass
    finally:
        with suppress(ProcessLookupError):
            os.killpg(kept.pid, signal.SIGKILL)


def _serve(path: Path, *, offline: bool) -> int | None:
    page, data = _free_port(), _free_port()
    command = _command(path, "--serve-web", "--web-viewer-port", str(page), "--port", str(data))
    with offline_page(page, data) if offline else nullcontext(page) as shown:
        source = f"rerun%2Bhttp%3A%2F%2F{LOOPBACK}%3A{data}%2Fproxy"
        print(f"http://{LOOPBACK}:{shown}/?url={source}&renderer=webgl&persist=0&{_NO_EXAMPLES}", flush=True)
        print("Ctrl-C ends it." if offline else f"{_ASKS_OUTSIDE} Ctrl-C ends it.", flush=True)
        return _run(command)


def _command(path: Path, *options: str) -> list[str]:
    return [*_viewer(), "--bind", LOOPBACK, *options, str(path)]


def _viewer() -> list[str]:
    """Return how the viewer is called: itself where it lies, without the launcher, which would not pass signals on."""
    binary = Path(rerun_cli.__file__).with_name("rerun")
    return [str(binary)] if binary.is_file() else [sys.executable, "-m", "rerun_cli"]


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind((LOOPBACK, 0))
        return int(probe.getsockname()[1])
