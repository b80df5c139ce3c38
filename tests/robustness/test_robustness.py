"""The fast part of `make robustness`, and files with bytes changed at random."""

from __future__ import annotations

import tomllib
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from testbed.errors import InputError
from testbed.records.reading import read_record
from testbed.scenario.reader import read_scenario
from tests.robustness.case import Case, Ended, faults, written
from tests.robustness.records import as_csv, as_parquet, good_table
from tests.robustness.running import failures
from tests.robustness.scenario_files import TEXT
from tests.robustness.table import CASES

FAST = [case for case in CASES if case.fast]
CHANGES = st.lists(st.tuples(st.integers(0, 10**9), st.binary(min_size=0, max_size=4)), min_size=1, max_size=6)
"""Places, as far as the file goes round and round, and what stands there instead of one byte."""
EACH_TIME = settings(
    max_examples=60, deadline=None, derandomize=True, suppress_health_check=[HealthCheck.function_scoped_fixture]
)


def test_the_table_is_as_long_as_promised_and_every_case_has_its_name():
    assert len(CASES) >= 800
    assert len({case.name for case in CASES}) == len(CASES)


@pytest.mark.parametrize("case", FAST, ids=lambda case: case.name)
def test_the_command_knows_what_to_do(case):
    assert failures(case) == []


def changed(content: bytes, changes: list[tuple[int, bytes]]) -> bytes:
    for place, other in changes:
        at = place % max(len(content), 1)
        content = content[:at] + other + content[at + 1 :]
    return content


def refusal(read, path: Path) -> str | None:
    """Return what was said of a file that was refused."""
    try:
        read(path)
    except InputError as error:
        return str(error)
    return None


@EACH_TIME
@given(changes=CHANGES)
def test_a_scenario_with_other_bytes_is_read_or_refused(tmp_path, changes):
    path = tmp_path / "scenario.toml"
    path.write_bytes(changed(TEXT.encode(), changes))
    said = refusal(read_scenario, path)
    assert "scenario.toml" in said if said is not None else tomllib.loads(path.read_text(encoding="utf-8-sig"))


@pytest.mark.parametrize("suffix", ["csv", "parquet"])
@EACH_TIME
@given(changes=CHANGES)
def test_a_record_with_other_bytes_is_read_or_refused(tmp_path, suffix, changes):
    path = tmp_path / f"run.{suffix}"
    path.write_bytes(changed((as_csv if suffix == "csv" else as_parquet)(good_table()), changes))
    said = refusal(read_record, path)
    assert said is None or f"run.{suffix}" in said


def ended(**changes: object) -> Ended:
    good = {"code": 2, "output": "", "complaints": "error: no", "seconds": 1.0, "megabytes": 300.0}
    return Ended(**{**good, **changes})


CASE = Case(name="case", prepare=written({}), commands=(("run", "scenario.toml", "--out", "out"),), says=("no",))


def test_a_command_that_refuses_with_a_reason_has_no_fault():
    assert list(faults(CASE, [ended()])) == []


@pytest.mark.parametrize(
    ("change", "fault"),
    [
        ({"code": 70}, "exit code 70"),
        ({"code": -11}, "exit code -11"),
        ({"code": 0}, "exit code 0, not one of (2,)"),
        ({"code": None}, "did not end in 120.0 s"),
        ({"complaints": "Traceback: no"}, "prints what is for programmers"),
        ({"complaints": ""}, "refused without a word"),
        ({"complaints": "error: yes"}, "none of ('no',) was said"),
        ({"megabytes": 5000.0}, "took 5000 MB"),
        ({"left": frozenset({"out"})}, "left out"),
    ],
)
def test_every_fault_is_reported(change, fault):
    assert any(fault in reported for reported in faults(CASE, [ended(**change)]))


def test_what_a_case_leaves_behind_is_removed(tmp_path, monkeypatch):
    case = Case(name="empty", prepare=written({"scenario.toml": ""}), commands=(("check", "scenario.toml"),))
    failures(case)  # with its first process, multiprocessing makes a folder that it keeps
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    assert failures(case) == []
    assert list(Path(tmp_path).iterdir()) == []
