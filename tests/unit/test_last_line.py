"""What no command may do however it goes wrong: print a traceback, lose its results for want of a terminal."""

from __future__ import annotations

import ast
import os
from pathlib import Path

import pytest
from rich.console import Console
from rich.table import Table

import testbed.cli.check
from support.processes import ROOT, outcome, started
from testbed.cli.app import app
from testbed.cli.console import say, show, warn
from testbed.cli.failures import BUG, exit_code_of
from testbed.cli.streams import transliterated
from testbed.cli.table_layout import fitted

BASIC = ROOT / "scenarios" / "basic.toml"


@pytest.fixture
def bug(monkeypatch, tmp_path):
    """Put a bug into `testbed check`, and its log into a folder of the test."""

    def broken(_):
        raise ZeroDivisionError("a bug of ours")

    monkeypatch.setattr(testbed.cli.check, "nominal_body", broken)
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    return tmp_path


def test_a_bug_ends_with_one_sentence_a_log_and_a_code_of_its_own(bug, capsys):
    assert exit_code_of(lambda: app(["check", str(BASIC)])) == BUG == 70
    printed = capsys.readouterr()
    (log,) = bug.glob("testbed-*.log")
    assert printed.out == ""
    assert printed.err.count("\n") == 1
    assert "bug of its own (ZeroDivisionError)" in printed.err
    assert printed.err.rstrip().endswith(str(log))
    kept = log.read_text(encoding="utf-8")
    assert "Traceback" in kept
    assert "a bug of ours" in kept


def test_a_bug_is_reported_in_full_where_there_is_no_room_for_a_log(bug, capsys, monkeypatch):
    monkeypatch.setattr("tempfile.tempdir", str(bug / "nowhere"))
    assert exit_code_of(lambda: app(["check", str(BASIC)])) == BUG
    assert "a bug of ours" in capsys.readouterr().err


def test_memory_that_ran_out_is_no_bug(monkeypatch, capsys):
    def full(_):
        raise MemoryError

    monkeypatch.setattr(testbed.cli.check, "nominal_body", full)
    assert exit_code_of(lambda: app(["check", str(BASIC)])) == 2
    assert "memory ran out" in capsys.readouterr().err


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a device that is always full")
def test_a_run_whose_output_is_lost_keeps_its_files_and_says_so(tmp_path):
    with (
        Path("/dev/full").open("w") as full,
        started("run", BASIC, "--out", "out", cwd=tmp_path, stdout=full) as process,
    ):
        code, _, complaints = outcome(process)
    assert code == 2
    assert complaints.startswith("error: standard output: cannot be written (No space left on device)")
    assert complaints.count("\n") == 1
    assert (tmp_path / "out" / "result.json").is_file()


def test_a_reader_that_has_gone_is_no_error(tmp_path):
    reading, writing = os.pipe()
    os.close(reading)
    with started("check", BASIC, cwd=tmp_path, stdout=writing) as process:
        assert outcome(process) == (0, None, "")
    os.close(writing)


def test_standard_output_that_is_closed_does_not_end_up_in_a_file(tmp_path):
    """The next file that is opened would get its number, and what libraries print would go into it."""
    closed = "import os; os.close(1); os.close(2)\nimport sys; sys.stdout = sys.stderr = None"
    numbers = "import testbed.cli.entry as entry, os\ndef ended(): print(os.open('first', os.O_CREAT | os.O_WRONLY))"
    check = "\nentry._application = lambda: exit(0 if os.open('first', os.O_CREAT | os.O_WRONLY) > 2 else 1)"
    with started(cwd=tmp_path, before=f"{closed}\n{numbers}{check}") as process:
        assert outcome(process)[0] == 0


@pytest.mark.parametrize("locale", [{"PYTHONIOENCODING": "ascii"}, {"PYTHONUTF8": "0", "LC_ALL": "C", "LANG": "C"}])
def test_a_terminal_that_knows_ascii_alone_shows_every_result_and_files_stay_utf_8(tmp_path, locale):
    scenario = tmp_path / "ünlogisch.toml"
    text = BASIC.read_text(encoding="utf-8").replace('description = "', 'description = "∫±²→ω ')
    scenario.write_text(text, encoding="utf-8")
    environment = {"PYTHONCOERCECLOCALE": "0", **locale}
    with started("run", scenario, "--out", "out", cwd=tmp_path, environment=environment) as process:
        code, output, complaints = outcome(process)
    assert (code, complaints) == (0, "")
    assert output.isascii()
    assert "Cramer-Rao bound" in output
    assert (tmp_path / "out" / "scenario.toml").read_text(encoding="utf-8") == text
    assert "∫±²→ω" in (tmp_path / "out" / "report.html").read_text(encoding="utf-8")


def test_what_ascii_lacks_is_written_in_other_words():
    assert transliterated("Cramér ±2 kg·m² → Ψ_f ω ─ \udce9 ☃") == r"Cramer +-2 kg*m2 -> Psi_f omega - \xe9 ?"


def test_no_text_is_read_as_markup(capsys):
    say("[red]a[/] [maneuver] :smile:")
    warn("[x]", "[/y] :ok:")
    table = Table("[a]", title="[b]")
    table.add_row("[/c]")
    show(table)
    printed = capsys.readouterr().out
    for text in ("[red]a[/] [maneuver] :smile:", "[x]: [/y] :ok:", "[a]", "[b]", "[/c]"):
        assert text in printed


def test_every_table_and_line_goes_through_the_console_that_reads_no_markup():
    """Whoever prints by another console than the two of console.py, or lets rich read a text, is named here."""
    for path in (ROOT / "testbed").rglob("*.py"):
        tree = ast.parse(path.read_text(encoding="utf-8"))
        for call in (node for node in ast.walk(tree) if isinstance(node, ast.Call)):
            name = ast.unparse(call.func)
            keywords = {keyword.arg: ast.unparse(keyword.value) for keyword in call.keywords}
            if name in {"Console", "rich.print"}:
                assert keywords.get("markup") == keywords.get("emoji") == "False", path
            if name == "TextColumn" and "{" in ast.unparse(call):
                assert keywords.get("markup") == "False", path
            assert name not in {"Text.from_markup", "render_markup"}, path


WIDE = ["20.0462", "-21.2563", "±25.7449", "0.1000", "1.0e+04", "1.0815"]


@pytest.mark.parametrize("width", [10, 30, 45, 60, 74, 79, 200])
def test_a_narrow_terminal_loses_no_digit(width):
    console = Console(width=width, markup=False, highlight=False, soft_wrap=True)
    table = Table(title="Inertia", padding=(0, 1, 0, 0))
    table.add_column(no_wrap=True)
    for name in ("J11", "J22", "J33", "J23", "J13"):
        table.add_column(name, justify="right", no_wrap=True)
    table.add_column("in words", overflow="fold")
    table.add_row("instrumental variable", *WIDE[:5], "1.0815 and more")
    with console.capture() as capture:
        for part in fitted(table, console):
            console.print(part)
    shown = capture.get()
    assert "…" not in shown
    for text in ("instrumental variable", *WIDE, "J13", "words", "more"):
        assert text in shown
    assert shown.count("Inertia") == 1
    fits = max(len(line) for line in shown.splitlines()) <= width
    assert fits or width < 40  # what a label and one column need
