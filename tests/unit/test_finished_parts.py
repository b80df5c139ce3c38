"""An interrupted reproduction: its finished parts are kept, known by their checksums, and not made again."""

from __future__ import annotations

import json
import os
import signal
from pathlib import Path

import numpy as np
import pytest
from scipy.interpolate import BSpline

from support.campaigns import Pretended
from support.processes import outcome, started, until
from support.reproductions import reproduction, table1
from testbed.cli.app import app
from testbed.cli.failures import exit_code_of
from testbed.errors import InputError
from testbed.estimation.combine import CombinedEstimate
from testbed.maneuver.profiles import basic_profile
from testbed.reproduction.alignment_flights import Flight
from testbed.reproduction.codec import Codec
from testbed.reproduction.finished_parts import FinishedParts, finished_parts
from testbed.reproduction.progress import silent
from testbed.reproduction.table2 import table2
from testbed.reproduction.workers import Job, done_by_workers
from testbed.reproduction.zero_g_cuts import Cut
from testbed.reproduction.zero_g_outcome import CampaignOutcome

IDENTITY = {"seed": 1, "runs": 4, "versions": {"testbed": "0"}}
KEPT = ["first", "second", "third"]


def touched(folder: str, name: str) -> dict[str, object]:
    """A job that leaves a file, so that it is seen to have been done."""
    path = Path(folder) / f"{name}-{len(list(Path(folder).glob(name + '-*')))}"
    path.touch()
    return {"name": name, "values": np.arange(3) / 7.0}


def jobs(folder: Path) -> list[Job]:
    return [Job(name=name, part="Jobs", items=1, call=touched, arguments=(str(folder), name)) for name in KEPT]


def opened(out: Path, identity=IDENTITY, notices=None):
    return finished_parts(out, identity, (notices if notices is not None else []).append)


def results(out: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in (out / "parts" / "results").iterdir()}


def equal(one, other) -> bool:
    if isinstance(one, np.ndarray):
        return one.dtype == other.dtype and np.array_equal(one, other, equal_nan=True)
    if isinstance(one, BSpline):
        return equal(one.t, other.t) and equal(one.c, other.c) and one.k == other.k
    if isinstance(one, dict):
        return list(one) == list(other) and all(equal(one[key], other[key]) for key in one)
    if isinstance(one, list | tuple):
        return type(one) is type(other) and all(map(equal, one, other))
    if hasattr(one, "__dataclass_fields__"):
        return type(one) is type(other) and all(equal(getattr(one, each), getattr(other, each)) for each in vars(one))
    return bool(one == other)


def flight() -> Flight:
    rng = np.random.default_rng(4)
    error = rng.standard_normal(30)
    error[3] = np.nan
    return Flight(error, rng.random(30), 0.1, 1 / 3, np.pi, ("a scale", "π"))


def outcome_of_a_campaign() -> CampaignOutcome:
    rng = np.random.default_rng(5)
    one = CombinedEstimate(theta=rng.random(6), covariance=rng.random((6, 6)), considered=np.zeros((6, 0)))
    cut = Cut(usable=2.3, late=-1, touched=True)
    return CampaignOutcome(combined={"iv": one}, cuts=(cut, cut), usable=(2.3, np.float64(0.1)))


@pytest.mark.parametrize(
    "value",
    [flight(), [(flight(), flight())], outcome_of_a_campaign(), basic_profile(duration=5.0), table1(), 0.1 + 0.2],
    ids=lambda value: type(value).__name__,
)
def test_what_is_kept_comes_back_to_the_last_bit(tmp_path, value):
    with opened(tmp_path) as parts:
        parts.keep("part", value)
    with opened(tmp_path) as parts:
        assert equal(parts.result("part"), value)
        assert parts.result("another") is None


@pytest.mark.parametrize("content", [b"[", b'{"kind": "os.system", "content": []}', b'{"kind": 1}', b"[" * 100_000])
def test_nothing_but_known_types_is_made_of_a_file(content):
    with pytest.raises(ValueError, match="is not a finished part"):
        Codec(types=(Cut,)).decoded(content)


def test_what_no_codec_knows_is_refused():
    with pytest.raises(TypeError, match="object cannot be kept"):
        Codec(types=()).encoded([object()])


def test_finished_jobs_are_not_done_again_and_count_as_progress(tmp_path):
    counts: list[int] = []
    with opened(tmp_path / "out") as parts:
        first = done_by_workers(jobs(tmp_path)[:2], 1, silent, parts)
    with opened(tmp_path / "out") as parts:
        again = done_by_workers(jobs(tmp_path), 1, lambda *_: counts.append, parts)
    assert {path.name for path in tmp_path.glob("*-*")} == {"first-0", "second-0", "third-0"}
    assert equal(again[:2], first)
    assert sum(counts) == 3


def test_damaged_and_foreign_parts_are_set_aside_and_made_again(tmp_path):
    with opened(tmp_path / "out") as parts:
        done_by_workers(jobs(tmp_path), 1, silent, parts)
    whole = results(tmp_path / "out")
    folder = tmp_path / "out" / "parts" / "results"
    flipped = bytearray(whole["second.json"])
    flipped[len(flipped) // 2] ^= 1
    (folder / "second.json").write_bytes(flipped)
    (folder / "junk.json").write_bytes(b"junk")
    notices: list[str] = []
    with opened(tmp_path / "out", notices=notices) as parts:
        done_by_workers(jobs(tmp_path), 1, silent, parts)
    assert results(tmp_path / "out") == whole
    aside = {path.name: path.read_bytes() for path in (folder.parent / "set_aside").iterdir()}
    assert aside == {"second.json": bytes(flipped), "junk.json": b"junk"}
    assert all(any(name in text for text in notices) for name in aside)
    assert len(list(tmp_path.glob("second-*"))) == 2


def test_another_reproduction_is_refused_with_the_differences(tmp_path):
    with opened(tmp_path) as parts:
        parts.keep("part", 1.0)
    whole = results(tmp_path)
    other = {"seed": 2, "runs": 4, "versions": {"testbed": "1"}}
    with pytest.raises(InputError, match=r'seed 1, now 2\n +versions.testbed "0", now "1"'), opened(tmp_path, other):
        pass
    assert results(tmp_path) == whole


@pytest.mark.parametrize("content", ["[" * 100_000, "{}", "[1]", '{"seconds": 1, "reproduction": 3, "parts": []}'])
def test_a_damaged_manifest_is_a_message(tmp_path, content):
    with opened(tmp_path):
        pass
    (tmp_path / "parts" / "reproduction.json").write_text(content, encoding="utf-8")
    with pytest.raises(InputError, match=r"reproduction\.json cannot be read"), opened(tmp_path):
        pass


def test_time_adds_up_over_all_starts(tmp_path):
    with opened(tmp_path) as parts:
        first = parts.elapsed
    with opened(tmp_path) as parts:
        assert parts.elapsed > first > 0.0


def test_campaigns_of_table_2_go_on_where_they_were(tmp_path, monkeypatch):
    maneuvers = ("basic", "scaled")  # which the scenario gives: a design takes half a minute
    monkeypatch.setattr("testbed.reproduction.table2.SCENARIOS", maneuvers)
    straight = table2(60, 3, Pretended())

    def twice(parts: FinishedParts):
        with pytest.raises(KeyboardInterrupt):
            table2(60, 3, Pretended(most=2), parts=parts)
        rest = Pretended()
        return table2(60, 3, rest, parts=parts), rest

    with opened(tmp_path) as parts:
        resumed, rest = twice(parts)
    blocks = len(maneuvers) * (3 + 1)  # of 60 runs and of 20 with the drift
    assert len(rest.flown) == blocks - 2
    for one, other in zip(straight, resumed, strict=True):
        assert equal(dict(one.errors), dict(other.errors))


def run(*arguments: object) -> int:
    return exit_code_of(lambda: app([str(argument) for argument in arguments]))


STUBBED = """
import pathlib, time
import testbed.cli.reproduce as command
def interrupted(extent, progress, parts):
    parts.keep("part", 1.0)
    pathlib.Path("here").touch()
    while True:
        time.sleep(0.05)
command.reproduce = interrupted
"""


def test_ctrl_c_keeps_what_is_finished_and_resume_goes_on_with_it(tmp_path, monkeypatch, capsys):
    arguments = ("reproduce", "--quick", "--out", "out")
    with started(*arguments, cwd=tmp_path, before=STUBBED, signals_ignored=True) as process:
        until((tmp_path / "here").exists, process)
        os.killpg(process.pid, signal.SIGINT)
        code, printed, complaints = outcome(process)
    assert (code, complaints) == (130, ""), printed
    assert "--out out --resume" in printed
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["parts"]
    found = []

    def finished(_extent, _progress, parts):
        found.append(parts.result("part"))
        return reproduction()

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("testbed.cli.reproduce.reproduce", finished)
    assert run(*arguments, "--seed", 2, "--resume") == 2
    refusal = capsys.readouterr().err
    assert "seed 1, now 2" in refusal
    assert "repeat the command" not in refusal  # which is what was refused
    assert run(*arguments, "--resume") == 0
    assert found == [1.0]
    assert {"parts", "reproduction.html", "reproduce.json"} < {path.name for path in (tmp_path / "out").iterdir()}


def test_resuming_what_is_no_reproduction(tmp_path, capsys):
    (tmp_path / "notes.txt").write_text("mine", encoding="utf-8")
    assert run("reproduce", "--out", tmp_path, "--resume") == 2
    assert "holds no reproduction" in capsys.readouterr().err
    assert run("reproduce", "--resume") == 2
    assert "--out" in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["notes.txt"]


def test_the_claims_over_seeds_stand_in_terminal_page_and_file(tmp_path, monkeypatch, capsys):
    seeds = []

    def flown(extent, _progress, _parts):
        seeds.append(extent.seed)
        return reproduction()

    monkeypatch.setattr("testbed.cli.reproduce.reproduce", lambda *_: reproduction())
    monkeypatch.setattr("testbed.reproduction.seeds.flown_of", flown)
    assert run("reproduce", "--seeds", 3, "--out", tmp_path / "out") == 0
    assert seeds == [2, 3]
    assert "Over 3 seeds" in capsys.readouterr().out
    content = json.loads((tmp_path / "out" / "reproduce.json").read_text(encoding="utf-8"))
    bias = next(each for each in content["seeds"] if each["subject"] == "Table 2, bias")
    assert (bias["met"], bias["missed"], bias["undecided"]) == (3, 0, 0)
    assert list(bias["by_seed"]) == ["1", "2", "3"]
    assert "seeds 1 to 3" in (tmp_path / "out" / "reproduction.html").read_text(encoding="utf-8")
