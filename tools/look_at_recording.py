"""Take a picture of every tab of a recording in a real viewer without a window.

    python tools/look_at_recording.py RECORDING.rrd OUT_FOLDER [--time SECONDS]

Exits with 1 if a view reports an error. The viewer draws with Vulkan; a machine without a graphics card needs a
software driver for it, on Debian the package mesa-vulkan-drivers.
"""

from __future__ import annotations

import argparse
import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path

from rerun.experimental import ViewerClient

SOFTWARE_DRIVER = Path("/usr/share/vulkan/icd.d/lvp_icd.x86_64.json")
SETTLING_TIME = 1.5  # s, between two pictures of a tab; it has come to rest when they are the same
MOST_PICTURES = 40  # of a tab, if something in it never comes to rest
START_TIME = 600.0  # s, that a viewer may take to answer on a machine that is busy with other things


def main() -> int:
    """Take the pictures and print their paths and what the views complain of."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("recording", type=Path)
    parser.add_argument("out", type=Path)
    parser.add_argument("--time", type=float, help="of the flight, s; its middle where absent")
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    with headless_viewer() as viewer:
        complaints = photograph(viewer, arguments.recording, arguments.out, arguments.time)
    print("\n".join(complaints) or "no view reports an error")
    return 1 if complaints else 0


@contextmanager
def headless_viewer() -> Iterator[ViewerClient]:
    """Start a viewer without a window that listens to this machine alone."""
    port = free_port()
    command = [sys.executable, "-m", "rerun", "--headless", "--bind", "127.0.0.1", "--port", str(port)]
    process = subprocess.Popen(
        [*command, "--hide-welcome-screen"],
        env=graphics_environment(),
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )
    try:
        yield connect(port)
    finally:
        # All of its group: the launcher alone would leave the viewer running, and an ignored SIGINT is inherited.
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()


def graphics_environment() -> dict[str, str]:
    """Return the environment, pointing at the software driver where it is installed."""
    return dict(os.environ) | ({"VK_ICD_FILENAMES": str(SOFTWARE_DRIVER)} if SOFTWARE_DRIVER.is_file() else {})


def free_port() -> int:
    """Return a port that nothing listens on."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def connect(port: int) -> ViewerClient:
    """Connect as soon as the viewer answers."""
    patience = time.monotonic() + START_TIME
    while True:
        try:
            return ViewerClient.connect(f"rerun+http://127.0.0.1:{port}/proxy")
        except ConnectionError as error:
            if time.monotonic() > patience:
                raise SystemExit(f"no viewer: {error}. Is mesa-vulkan-drivers installed?") from error
            time.sleep(0.2)


def photograph(viewer: ViewerClient, recording: Path, out: Path, moment: float | None) -> list[str]:
    """Save one picture per tab and return what the views report."""
    viewer.open(str(recording.resolve()))
    viewer.set_time("sim_time", duration=middle(viewer) if moment is None else moment, play_state="paused")
    complaints: set[str] = set()
    for name, show in reversed(tabs(viewer).items()):  # the first last: for some seconds a notice covers its corner
        show()
        picture = out / f"{name.lower()}.png"
        picture.write_bytes(settled(viewer))
        print(picture)
        complaints |= {f"{view.name}: {report}" for view in viewer.get_state().views for report in view.reports}
    return sorted(complaints)


def settled(viewer: ViewerClient) -> bytes:
    """Return a picture of what the viewer shows once layout, camera and text have come to rest."""
    before = b""
    for _ in range(MOST_PICTURES):
        time.sleep(SETTLING_TIME)
        picture = viewer.take_screenshot()
        if picture == before:
            break
        before = picture
    return picture


def middle(viewer: ViewerClient) -> float:
    """Return the middle of the flight, s."""
    (timeline,) = viewer.get_state().recordings[0].timelines
    return (timeline.start + timeline.end) / 2e9


def tabs(viewer: ViewerClient) -> dict[str, Callable[[], None]]:
    """Return what brings each tab to the front, by the tab's name."""
    layout = viewer.get_blueprint("recording").blueprint
    containers = {path: parts["ContainerBlueprint"] for path, parts in layout.items() if "ContainerBlueprint" in parts}
    (root,) = (container for container in containers.values() if container["container_kind"] == "Tabs")

    def show(tab: str) -> None:
        root["active_tab"] = tab
        viewer.set_blueprint(layout, "recording")

    return {containers[f"/{tab}"]["display_name"]: partial(show, tab) for tab in root["contents"]}


if __name__ == "__main__":
    sys.exit(main())
