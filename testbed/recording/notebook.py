"""A recording inside a notebook: rerun's viewer as a widget."""

from __future__ import annotations

import os
from collections.abc import Callable
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, TypeAlias

from testbed.errors import InputError

if TYPE_CHECKING:
    import rerun_notebook

    Viewer: TypeAlias = rerun_notebook.Viewer

_ASSET, _FROM_HERE = "RERUN_NOTEBOOK_ASSET", "serve-local"
"""Where a page gets the viewer from: this process, on loopback. Left to itself, rerun takes a host of its own."""


def notebook_viewer(write: Callable[[Path], None], height: int) -> Viewer:
    """Return a viewer for a notebook's cell.

    Args:
        write: writes the recording to a path.
        height: of the viewer, pixels; it is as wide as the cell.

    Raises:
        InputError: rerun's notebook package is not installed.
    """
    os.environ.setdefault(_ASSET, _FROM_HERE)  # read when the package is imported first
    try:
        with redirect_stdout(StringIO()):  # it prints where it serves from
            import rerun_notebook  # noqa: PLC0415 - an optional extra
    except ImportError as error:
        raise InputError("a viewer inside a notebook needs rerun's: pip install 'testbed[notebook]'") from error
    viewer = rerun_notebook.Viewer(width="auto", height=height, theme="dark")  # recordings have colours for that
    with TemporaryDirectory() as place:
        path = Path(place) / "recording.rrd"
        write(path)
        viewer.send_rrd(path.read_bytes())
    return viewer
