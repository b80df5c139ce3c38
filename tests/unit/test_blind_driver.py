"""How the blind set is driven: shares of strata, what is kept, what stays locked."""

from __future__ import annotations

from dataclasses import asdict

import pytest

from benchmarks.blind import ALL, counts_of, locked
from benchmarks.blind_diagnosis import REFUSED, diagnose_case
from tests.concealing.blind_set import Counts
from tests.diagnosed_records import SCENARIO


@pytest.mark.parametrize("cases", [1, 12, 24, 80])
def test_a_part_has_every_stratum_in_its_share(cases):
    part, whole = asdict(counts_of(cases)), asdict(Counts())
    assert sum(part.values()) == cases
    assert all(abs(part[name] - count * cases / ALL) < 1.0 for name, count in whole.items())


def test_the_whole_is_what_was_ordered():
    assert counts_of(ALL) == Counts()


def test_a_refusal_is_kept_as_an_answer_and_not_tried_again(tmp_path):
    empty = tmp_path / "data"
    empty.mkdir()
    folder = diagnose_case(SCENARIO, empty, tmp_path / "diagnosis")
    assert str(empty) in (folder / REFUSED).read_text(encoding="utf-8")
    (folder / REFUSED).write_text("kept", encoding="utf-8")
    diagnose_case(SCENARIO, empty, folder)
    assert (folder / REFUSED).read_text(encoding="utf-8") == "kept"


def test_answers_are_locked_while_cases_are_diagnosed(tmp_path):
    answers = tmp_path / "answers"
    with locked(answers, 0o000):
        assert answers.stat().st_mode & 0o777 == 0
    assert answers.stat().st_mode & 0o777 == 0o700  # and given back to be scored
