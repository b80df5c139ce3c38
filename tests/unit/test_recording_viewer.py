import os
import re
import signal
import subprocess
import sys
import time
import urllib.request
from contextlib import contextmanager
from pathlib import Path

import pytest

from support.flights import content, flown
from support.processes import PATIENCE, ROOT, of_group, started, until
from testbed.cli.app import app
from testbed.cli.failures import exit_code_of
from testbed.errors import InputError
from testbed.plant.scene import scene_of
from testbed.recording.viewer import check_recording, open_viewer
from testbed.recording.writer import write_recording

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


@contextmanager
def served(recording, *arguments, **options):
    """Serve a recording to a browser; give the process and the ports of page and data, once the page is there."""
    with started("view", "--web", *arguments, recording, cwd=ROOT, **options) as process:
        url = process.stdout.readline().strip()
        page = int(re.match(r"http://127\.0\.0\.1:(\d+)/", url).group(1))
        data = int(re.search(r"127\.0\.0\.1%3A(\d+)%2Fproxy", url).group(1))
        assert b"<html" in fetched(f"http://127.0.0.1:{page}/").lower()
        yield process, page, data


def viewer_of(process):
    """Return the group of processes that a command's viewer lives in."""
    children = Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text(encoding="ascii").split()
    (keeper,) = [int(child) for child in children if os.getpgid(int(child)) == int(child)]
    return keeper


@pytest.mark.skipif(not Path("/proc/net/tcp").exists(), reason="looks at the kernel's tables of sockets and processes")
@pytest.mark.parametrize(
    ("sent", "signals_ignored", "code"),
    [(signal.SIGINT, False, 0), (signal.SIGTERM, True, 0), (signal.SIGKILL, True, -signal.SIGKILL)],
)
def test_the_viewer_is_served_to_this_machine_alone_and_ends_with_its_command(recording, sent, signals_ignored, code):
    with served(recording, signals_ignored=signals_ignored) as (process, page, data):
        assert listening_addresses(page) == listening_addresses(data) == {"0100007F"}
        group = viewer_of(process)
        assert len(of_group(group)) == 2  # the keeper and the viewer
        process.send_signal(sent)
        assert process.wait(timeout=PATIENCE) == code
        gone(group)
    assert listening_addresses(page) | listening_addresses(data) == set()


def gone(group):
    """Wait until no process of a group is left; a killed command does not wait for its viewer's end itself."""
    patience = time.monotonic() + PATIENCE
    while of_group(group):
        assert time.monotonic() < patience, "the viewer goes on"
        time.sleep(0.05)


STUBBORN = """
import pathlib, signal, sys, time
for number in (signal.SIGINT, signal.SIGTERM):
    signal.signal(number, lambda number, _: pathlib.Path(f"heard-{number}").touch())
pathlib.Path("here").touch()
while True:
    time.sleep(1)
"""


def test_a_viewer_that_hears_nothing_is_killed_after_both_requests(tmp_path):
    patience = (
        f"from testbed.recording import keeper; keeper.PATIENCE = 0.2; keeper.keep({[sys.executable, '-c', STUBBORN]})"
    )
    with subprocess.Popen([sys.executable, "-c", patience], stdin=subprocess.PIPE, cwd=tmp_path) as kept:
        until((tmp_path / "here").exists, kept)
        kept.stdin.close()
        assert kept.wait(timeout=PATIENCE) == 0
    assert {path.name for path in tmp_path.iterdir()} == {"here", "heard-2", "heard-15"}


def test_offline_the_browser_may_reach_this_machine_alone(recording):
    with served(recording, "--offline") as (process, page, data):
        with urllib.request.urlopen(f"http://127.0.0.1:{page}/?renderer=webgl", timeout=PATIENCE) as answer:
            policy, html = answer.headers["Content-Security-Policy"], answer.read().decode()
        with urllib.request.urlopen(f"http://127.0.0.1:{page}/re_viewer_bg.wasm", timeout=PATIENCE) as answer:
            assert len(answer.read()) == int(answer.headers["rerun-final-length"])
        assert set(re.findall(r"https?://[^ ;]+", policy)) == {f"http://127.0.0.1:{data}"}
        assert not re.findall(r"<link[^>]*https?://", html)
        assert listening_addresses(page) == {"0100007F"}
        process.send_signal(signal.SIGINT)
        assert process.wait(timeout=PATIENCE) == 0
    assert listening_addresses(page) | listening_addresses(data) == set()


def test_offline_without_a_browser_is_refused(recording, capsys):
    assert exit_code_of(lambda: app(["view", str(recording), "--offline"])) == 2
    assert "--offline goes with --web" in capsys.readouterr().err


def test_a_viewer_that_cannot_be_opened_is_an_error(recording, monkeypatch):
    monkeypatch.setattr("testbed.recording.viewer._viewer", lambda: [sys.executable, "-c", "raise SystemExit(7)"])
    with pytest.raises(InputError, match=r"exit code 7.*view --web"):
        open_viewer(recording, web=False)


def fetched(url):
    """Fetch a page as soon as it is served."""
    patience = time.monotonic() + PATIENCE
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
    seen = subprocess.run(look, cwd=ROOT, capture_output=True, text=True, timeout=PATIENCE, check=False)
    assert seen.returncode == 0, seen.stdout + seen.stderr
    pictures = {picture.stem: picture.stat().st_size for picture in tmp_path.glob("*.png")}
    assert set(pictures) == {"flight", "actuators", "estimates", "residuals", "provenance"}
    assert min(pictures.values()) > 20_000  # an empty window compresses to less
