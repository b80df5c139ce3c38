import os
import re
import signal
import subprocess
import sys
import time
import urllib.request
from pathlib import Path

import pytest

from testbed.errors import InputError
from testbed.plant.scene import scene_of
from testbed.recording.viewer import check_recording, open_viewer
from testbed.recording.writer import write_recording
from tests.flights import content, flown

ROOT = Path(__file__).parents[2]
SOFTWARE_DRIVER = Path("/usr/share/vulkan/icd.d/lvp_icd.x86_64.json")


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    flight, path = flown(41), tmp_path_factory.mktemp("viewer") / "recording.rrd"
    write_recording(
        path,
        recording_id="viewer",
        time=flight.time,
        channels=flight.channels,
        scene=scene_of(flight.model),
        content=content(41),
    )
    return path


def test_a_missing_recording_is_named(tmp_path):
    with pytest.raises(InputError, match=r"nothing\.rrd: no such recording"):
        open_viewer(tmp_path / "nothing.rrd", web=False)


@pytest.mark.parametrize("kept", [0, 100, 5_000, -2_000])
def test_a_cut_recording_is_refused(recording, tmp_path, kept):
    cut = tmp_path / "cut.rrd"
    cut.write_bytes(recording.read_bytes()[:kept])
    with pytest.raises(InputError, match=r"cut\.rrd: not a whole recording"):
        check_recording(cut)


def test_another_file_is_refused(tmp_path):
    (tmp_path / "notes.rrd").write_text("these are notes")
    with pytest.raises(InputError, match=r"notes\.rrd: not a whole recording"):
        check_recording(tmp_path / "notes.rrd")


def listening_addresses(port):
    """Return the local addresses, as the kernel prints them, that accept connections on a port."""
    tables = [Path("/proc/net") / name for name in ("tcp", "tcp6")]
    fields = [line.split() for table in tables if table.exists() for line in table.read_text().splitlines()[1:]]
    return {field[1].split(":")[0] for field in fields if field[3] == "0A" and int(field[1].split(":")[1], 16) == port}


@pytest.mark.skipif(not Path("/proc/net/tcp").exists(), reason="looks at the kernel's table of sockets")
def test_the_browser_viewer_is_served_to_this_machine_alone(recording):
    code = (
        "import sys; from pathlib import Path; from testbed.recording.viewer import open_viewer; "
        "open_viewer(Path(sys.argv[1]), web=True)"
    )
    process = subprocess.Popen(
        [sys.executable, "-c", code, str(recording)],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
    )
    try:
        url = process.stdout.readline().strip()
        page = int(re.match(r"http://127\.0\.0\.1:(\d+)/", url).group(1))
        data = int(re.search(r"127\.0\.0\.1%3A(\d+)%2Fproxy", url).group(1))
        assert b"<html" in fetched(f"http://127.0.0.1:{page}/").lower()
        assert listening_addresses(page) == listening_addresses(data) == {"0100007F"}
    finally:
        os.kill(process.pid, signal.SIGINT)
        process.stdout.close()
    assert process.wait(timeout=10) == 0
    assert listening_addresses(page) | listening_addresses(data) == set()  # the viewer has gone too


def fetched(url):
    """Fetch a page as soon as it is served."""
    patience = time.monotonic() + 20.0
    while True:
        try:
            with urllib.request.urlopen(url, timeout=5.0) as response:
                return response.read()
        except OSError:
            if time.monotonic() > patience:
                raise
            time.sleep(0.1)


@pytest.mark.skipif(not SOFTWARE_DRIVER.exists(), reason="needs a Vulkan driver: Debian's mesa-vulkan-drivers")
def test_a_real_viewer_draws_every_tab_without_a_complaint(recording, tmp_path):
    look = [sys.executable, "tools/look_at_recording.py", str(recording), str(tmp_path)]
    seen = subprocess.run(look, cwd=ROOT, capture_output=True, text=True, timeout=120, check=False)
    assert seen.returncode == 0, seen.stdout + seen.stderr
    pictures = {picture.stem: picture.stat().st_size for picture in tmp_path.glob("*.png")}
    assert set(pictures) == {"flight", "actuators", "estimates", "provenance"}
    assert min(pictures.values()) > 20_000  # an empty window compresses to less
