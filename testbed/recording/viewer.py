"""Opening a recording for a person: in the native viewer, or in a browser."""

from __future__ import annotations

import signal
import socket
import subprocess
import sys
import warnings
from pathlib import Path

from rerun.chunk import RrdReader
from rerun.error_utils import RerunWarning

from testbed.errors import InputError

LOOPBACK = "127.0.0.1"


def open_viewer(path: Path, *, web: bool) -> None:
    """Show a recording until the viewer is closed or, in a browser, until the command is interrupted.

    Args:
        path: of an .rrd file.
        web: serve the viewer to a browser on this machine, and print its address; nothing is served to others.

    Raises:
        InputError: the file is missing or no recording.
    """
    check_recording(path)
    _run(_web_command(path) if web else _command(path, "--port", "auto"))


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


def _run(command: list[str]) -> None:
    """Run a viewer; an interrupt reaches it once, from here: killed, its launcher would leave it running."""
    process = subprocess.Popen(command, start_new_session=True)
    try:
        process.wait()
    except KeyboardInterrupt:
        process.send_signal(signal.SIGINT)
        process.wait()


def _web_command(path: Path) -> list[str]:
    page, data = _free_port(), _free_port()
    source = f"rerun%2Bhttp%3A%2F%2F{LOOPBACK}%3A{data}%2Fproxy"
    print(f"http://{LOOPBACK}:{page}/?url={source}&renderer=webgl&persist=0", flush=True)
    print("Ctrl-C ends it.", flush=True)
    return _command(path, "--serve-web", "--web-viewer-port", str(page), "--port", str(data))


def _command(path: Path, *options: str) -> list[str]:
    return [sys.executable, "-m", "rerun", "--bind", LOOPBACK, *options, str(path)]


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind((LOOPBACK, 0))
        return int(probe.getsockname()[1])
