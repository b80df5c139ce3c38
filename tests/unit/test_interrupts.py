"""Ctrl-C and requests to end: heard whatever was inherited, said in one sentence, nothing left behind."""

from __future__ import annotations

import os
import signal
from contextlib import suppress
from pathlib import Path

import pytest

from support.campaigns import small_scenario
from support.processes import ROOT, WAITING, outcome, started, until
from testbed.cli.failures import exit_code_of
from testbed.interrupts import Interrupted, raised_interrupts

BASIC = ROOT / "scenarios" / "basic.toml"
DESIGN = ROOT / "scenarios" / "gimbal_weighted.toml"
NOTHING = "Interrupted; nothing was written.\n"


@pytest.mark.parametrize(
    ("command", "work", "arguments", "sent", "signals_ignored"),
    [
        ("run", "fly", (BASIC, "--out", "out"), signal.SIGINT, False),
        ("run", "fly", (BASIC, "--out", "out"), signal.SIGTERM, True),
        ("design", "design", (DESIGN, "--out", "out"), signal.SIGINT, True),
        ("estimate", "read_records", (BASIC, "--data", ".", "--out", "out"), signal.SIGINT, True),
        ("check", "true_platform", (BASIC,), signal.SIGTERM, False),
    ],
)
def test_an_interrupted_command_says_so_and_leaves_nothing(tmp_path, command, work, arguments, sent, signals_ignored):
    waiting = WAITING.format(command=command, work=work)
    with started(command, *arguments, cwd=tmp_path, before=waiting, signals_ignored=signals_ignored) as process:
        until((tmp_path / "here").exists, process)
        process.send_signal(sent)
        code, output, complaints = outcome(process)
    said = "Interrupted.\n" if command == "check" else NOTHING
    assert (code, output, complaints) == (130, "", said)
    assert [path.name for path in tmp_path.iterdir()] == ["here"]


def test_an_interruption_while_results_get_their_names_waits_until_they_have_them(tmp_path):
    between = """
import os, signal, pathlib
rename = pathlib.Path.rename
def renamed(path, target):
    os.kill(os.getpid(), signal.SIGINT)
    return rename(path, target)
pathlib.Path.rename = renamed
"""
    with started("run", BASIC, "--out", "out", cwd=tmp_path, before=between) as process:
        code, _, complaints = outcome(process)
    assert code == 130
    assert complaints == "Interrupted.\n"
    assert {path.name for path in (tmp_path / "out").iterdir()} >= {"result.json", "record.parquet", "report.html"}
    assert not (tmp_path / "out" / ".part").exists()


def test_an_optimiser_that_keeps_ctrl_c_to_itself_is_interrupted_all_the_same():
    before = signal.getsignal(signal.SIGINT)

    def stop_quietly():
        with raised_interrupts(), suppress(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)

    with pytest.raises(KeyboardInterrupt):
        stop_quietly()
    assert signal.getsignal(signal.SIGINT) is before


def test_what_a_library_makes_of_ctrl_c_is_ctrl_c():
    """CasADi keeps the exception for itself until the next call comes upon it: a SystemError, one time in many."""

    def kept_and_found():
        with raised_interrupts():
            with suppress(KeyboardInterrupt):
                signal.raise_signal(signal.SIGINT)
            raise SystemError("<built-in function zeros> returned a result with an exception set")

    def of_its_own():
        with raised_interrupts():
            raise SystemError("of its own")

    with pytest.raises(KeyboardInterrupt):
        kept_and_found()
    with pytest.raises(SystemError, match="of its own"):
        of_its_own()


def test_handlers_are_given_back():
    before = [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)]
    assert exit_code_of(lambda: None) == 0
    assert [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)] == before


@pytest.mark.parametrize(
    ("interrupt", "said"),
    [
        (KeyboardInterrupt(), "Interrupted.\n"),
        (Interrupted("nothing was written"), NOTHING),
    ],
)
def test_what_an_interrupt_says(interrupt, said, capsys):
    def command():
        raise interrupt

    assert exit_code_of(command) == 130
    assert capsys.readouterr().err == said


@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="looks at the kernel's table of blocked signals")
def test_every_worker_leaves_ctrl_c_to_its_parent_the_first_one_too(tmp_path):
    """The first process makes multiprocessing start its resource tracker, which unblocks the signal in this one."""
    looking = """
import os, sys
from pathlib import Path
import testbed.cli.montecarlo
from testbed.campaign import worker
class Seen(worker.Worker):
    def __init__(self, *arguments):
        super().__init__(*arguments)
        blocked = Path(f"/proc/{self._process.pid}/status").read_text().split("SigBlk:")[1].split()[0]
        print("blocked", int(blocked, 16) >> 1 & 1, flush=True)
import testbed.campaign.local
testbed.campaign.local.Worker = Seen
"""
    path = small_scenario(tmp_path)
    arguments = ("montecarlo", path, "--runs", 2, "--out", "out", "--workers", 1)
    with started(*arguments, cwd=tmp_path, before=looking) as process:
        code, output, _ = outcome(process)
    assert code == 0
    assert "blocked 1" in output


def test_ctrl_c_while_workers_start_prints_no_traceback_of_theirs(tmp_path):
    here = """
import pathlib
from testbed.campaign import worker
give = worker.Worker.give
def given(self, block):
    give(self, block)
    pathlib.Path("here").touch()
worker.Worker.give = given
"""
    path = small_scenario(tmp_path)
    arguments = ("montecarlo", path, "--runs", 50, "--out", "out", "--workers", 2)
    with started(*arguments, cwd=tmp_path, before=here) as process:
        until((tmp_path / "here").exists, process)
        os.killpg(process.pid, signal.SIGINT)  # as a terminal does it: the workers get it too
        code, output, complaints = outcome(process)
    assert code == 130
    assert complaints == ""
    assert "What was flown is kept in out" in output
