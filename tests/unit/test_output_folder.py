"""Output folders: one command each, also among processes, filled whole or not at all, kept elsewhere if need be."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from support.processes import PATIENCE
from testbed.errors import InputError, OutputError
from testbed.outputs.folder import SCRATCH, reserved_folder

ROOT = Path(__file__).resolve().parents[2]

HOLD = """
import sys, time
from pathlib import Path
from testbed.outputs.folder import reserved_folder
with reserved_folder(Path(sys.argv[1]) if sys.argv[1] else None, "run") as folder:
    print(folder.path, flush=True)
    sys.stdin.read()
    folder.deliver(lambda place: (place / "result").write_text(str(folder.path)))
"""


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def holder(out: str) -> subprocess.Popen:
    """Start a process that reserves a folder and holds it until its input ends."""
    return subprocess.Popen(
        [sys.executable, "-c", HOLD, out],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={"PYTHONPATH": str(ROOT)},
    )


def write(place: Path) -> None:
    (place / "result").write_text("mine")


def names(folder: Path) -> list[str]:
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("*"))


def test_processes_at_once_each_get_a_folder_of_their_own(here):
    holders = [holder("") for _ in range(4)]
    paths = {process.stdout.readline().strip() for process in holders}
    for process in holders:
        process.communicate("", timeout=PATIENCE)
    assert paths == {"runs/run", "runs/run-2", "runs/run-3", "runs/run-4"}
    assert {(here / path / "result").read_text() for path in paths} == paths


def test_of_processes_with_one_out_one_gets_it_and_the_others_are_refused(here):
    holders = [holder("out") for _ in range(3)]
    granted = [process for process in holders if process.stdout.readline()]
    assert len(granted) == 1
    ends = [process.communicate("", timeout=PATIENCE) for process in holders]
    assert sum("another command is writing to it" in errors for _, errors in ends) == 2
    assert names(here) == ["out", "out/result"]


def test_what_a_killed_process_left_is_removed_by_the_next_one(here):
    process = holder("out")
    process.stdout.readline()
    (here / "out" / SCRATCH / "half").write_text("half of it")
    process.kill()
    process.communicate(timeout=PATIENCE)
    assert names(here) == ["out", f"out/{SCRATCH}", f"out/{SCRATCH}/half"]
    with reserved_folder(Path("out"), "run") as folder:
        folder.deliver(write)
    assert names(here) == ["out", "out/result"]


@pytest.mark.usefixtures("here")
def test_a_killed_process_frees_its_number():
    process = holder("")
    assert process.stdout.readline() == "runs/run\n"
    process.kill()
    process.communicate(timeout=PATIENCE)
    with reserved_folder(None, "run") as folder:
        assert folder.path == Path("runs/run")


def test_nothing_is_left_of_a_folder_that_was_not_filled(here):
    def broken(place: Path) -> None:
        write(place)
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError), reserved_folder(Path("new/deep/out"), "run") as folder:
        folder.deliver(broken)
    assert names(here) == []


def test_a_folder_that_a_person_made_stays(here):
    (here / "out").mkdir()
    with reserved_folder(Path("out"), "run"):
        pass
    assert names(here) == ["out"]


def test_what_has_appeared_meanwhile_is_not_replaced(here):
    (here / "runs" / "run").mkdir(parents=True)
    (here / "runs" / "run" / "result").write_text("another's")
    with reserved_folder(None, "run") as folder:
        folder.deliver(write)
    assert folder.path == Path("runs/run-2")
    assert (here / "runs" / "run" / "result").read_text() == "another's"


@pytest.mark.parametrize("name", ["file/out", "x" * 300, "nul\0byte"])
def test_a_folder_that_cannot_be_made_is_refused_before_any_work(here, name):
    (here / "file").write_text("")
    with pytest.raises(OutputError, match="cannot be written"), reserved_folder(Path(name), "run"):
        pytest.fail("no work may begin")


def test_a_full_disk_is_found_before_any_work(here, monkeypatch):
    monkeypatch.setattr("testbed.outputs.folder.LEAST_SPACE", 2**60)
    with pytest.raises(OutputError, match="out: cannot be written"), reserved_folder(Path("out"), "run"):
        pytest.fail("no work may begin")
    assert names(here) == []


def test_results_that_cannot_be_written_in_the_end_are_kept_elsewhere(here, monkeypatch, tmp_path_factory):
    elsewhere = tmp_path_factory.mktemp("elsewhere")
    monkeypatch.setattr("tempfile.tempdir", str(elsewhere))

    def full(place: Path) -> None:
        write(place)
        if place.is_relative_to("out"):
            raise OSError(28, "No space left on device")

    with pytest.raises(InputError) as caught, reserved_folder(Path("out"), "run") as folder:
        folder.deliver(full)
    (kept,) = elsewhere.iterdir()
    assert str(caught.value) == f"out: cannot be written (No space left on device); the results were kept in {kept}"
    assert names(kept) == ["result"]
    assert names(here) == []
