"""testbed view: open a recording."""

from __future__ import annotations

from pathlib import Path

from testbed.errors import InputError
from testbed.recording.viewer import open_viewer


def view_run(run: Path, *, web: bool, offline: bool) -> None:
    """Open the recording of a run folder, or a recording itself.

    Raises:
        InputError: there is no recording, or it cannot be opened.
    """
    if offline and not web:
        raise InputError(
            "--offline goes with --web: a browser can be held to this machine. The native viewer reports its use to "
            "rerun until `rerun analytics disable` has been run once"
        )
    try:
        recording = run / "recording.rrd" if run.is_dir() else run
        found = recording.is_file()
        if not run.exists():
            raise InputError(f"{run}: there is no such folder or file")
    except OSError as error:
        raise InputError(f"{run}: cannot be read ({error.strerror})") from error
    if not found:
        raise InputError(
            f"{run}: no recording there; name the folder of a run, a diagnosis or a reproduction, or an .rrd file"
        )
    open_viewer(recording, web=web, offline=offline)
