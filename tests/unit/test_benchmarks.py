"""The pure parts of the benchmarks: pairing, the step search, the table."""

from __future__ import annotations

import sys
from itertools import count
from math import inf

import pytest

from benchmarks import basilisk, sysid
from benchmarks.__main__ import LONG_PARTS, PARTS
from benchmarks.environments import UnavailableError
from benchmarks.flight_worker import TOLERANCE, largest_step
from benchmarks.paired import paired, workers
from benchmarks.ratios import Ratio
from benchmarks.table import PAGE, PartRows, page, read_parts, write_parts

ORDER = [*PARTS, *LONG_PARTS]


def a_row(ratio: float | None = 2.0, note: str = "") -> Ratio:
    return Ratio(what="a", ours="1 s", theirs="b 2 s", ratio=ratio, target="", command="c", note=note)


def test_pairs_take_turns_and_the_first_round_does_not_count():
    turns = count()
    ours, theirs = [], []

    def slow_first(kept: list[int], time: float) -> float:
        kept.append(next(turns))
        return 100.0 if len(kept) == 1 else time

    times = paired(lambda: slow_first(ours, 1.0), lambda: slow_first(theirs, 3.0), 3)
    assert (ours, theirs) == ([0, 2, 4, 6], [1, 3, 5, 7])
    assert (times.ours, times.theirs, times.ratio) == (1.0, 3.0, 3.0)


def test_a_pair_keeps_its_own_ratio_when_the_machine_slows_down():
    """Both twice as slow in one pair of three: the medians of the pair's ratios do not see it."""
    ours, theirs = iter([0.0, 1.0, 2.0, 1.0]), iter([0.0, 4.0, 8.0, 4.0])
    assert paired(lambda: next(ours), lambda: next(theirs), 3).ratio == 4.0


WORKER = "import sys; print('ready', flush=True)\nfor _ in sys.stdin: print({answer!r}, flush=True)"


def test_workers_work_once_per_call():
    command = [sys.executable, "-c", WORKER.format(answer="done")]
    with workers([command, command]) as work:
        assert all(work() > 0.0 for _ in range(2))


def test_a_worker_that_fails_is_named():
    command = [sys.executable, "-c", WORKER.format(answer="oops")]
    with workers([command]) as work, pytest.raises(RuntimeError, match="oops"):
        work()


def test_the_largest_step_holds_with_every_smaller_one():
    """A coarse step that happens to agree does not count when a finer one does not."""
    assert largest_step({0.004: 1e-9, 0.002: inf, 0.001: TOLERANCE / 2, 0.0005: 1e-9}) == 0.001


def test_no_step_is_an_error():
    with pytest.raises(ValueError, match="no step"):
        largest_step({0.001: TOLERANCE})


@pytest.mark.parametrize(
    ("module", "measure"), [(basilisk, basilisk.ratios), (sysid, sysid.ratios), (sysid, sysid.scatter_ratios)]
)
def test_what_cannot_be_installed_is_not_measured(monkeypatch, module, measure):
    def unavailable(_name: str, requirement: str) -> None:
        raise UnavailableError(f"{requirement} cannot be installed: no network")

    monkeypatch.setattr(module, "environment", unavailable)
    rows = measure()
    assert rows
    assert all(row.ratio is None and "no network" in row.note for row in rows)


def test_a_row_that_was_not_measured_says_so():
    text = page({"basilisk": PartRows(measured="then", rows=(a_row(None, "not measured: no network"),))}, ORDER)
    assert "| a | not measured |" in text
    assert "no network" in text


def test_parts_stand_in_their_order_whenever_they_were_measured():
    parts = {"recording": PartRows(measured="now", rows=(a_row(88.67),))}
    parts |= {"flight": PartRows(measured="then", rows=(a_row(0.6981),))}
    text = page(parts, ORDER)
    assert text.index("0.698") < text.index("88.7")


def test_rows_come_back_as_they_were_written(tmp_path, monkeypatch):
    monkeypatch.setattr("benchmarks.table.ROWS", tmp_path / "rows.json")
    monkeypatch.setattr("benchmarks.table.PAGE", tmp_path / "page.md")
    parts = {"flight": PartRows(measured="then", rows=(a_row(), a_row(None)))}
    write_parts(parts, ORDER)
    assert read_parts(tmp_path / "rows.json") == parts
    assert (tmp_path / "page.md").read_text(encoding="utf-8") == page(parts, ORDER)


def test_the_shipped_page_is_the_shipped_rows():
    assert PAGE.read_text(encoding="utf-8") == page(read_parts(), ORDER)
