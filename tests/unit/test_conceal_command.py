"""testbed conceal: what it writes, and what it says where it cannot."""

from __future__ import annotations

import json

import pytest
from typer.testing import CliRunner

import testbed.cli.conceal
from concealing.sealing import is_sealed
from support.diagnosed_records import SCENARIO
from testbed.cli.app import app
from testbed.cli.conceal import conceal_effects
from testbed.errors import InputError


def conceal(out, *options):
    result = CliRunner().invoke(app, ["conceal", str(SCENARIO), "--out", str(out), *options], catch_exceptions=False)
    assert result.exit_code == 0


def test_it_writes_as_many_runs_as_asked_for_and_seals_what_it_hid(tmp_path):
    conceal(tmp_path / "one", "--effect", "gyro_latency", "--size", "2", "--runs", "2", "--seed", "7")
    data, answer = tmp_path / "one" / "data", tmp_path / "one" / "answer"
    assert sorted(path.name for path in data.glob("*.csv")) == ["run_1.csv", "run_2.csv"]
    assert is_sealed(data, answer)
    answer_file = json.loads((answer / "answer.json").read_text(encoding="utf-8"))
    assert [each["effect"] for each in answer_file["effects"]] == ["gyro_latency"]
    assert answer_file["notes"]["detectable_sizes"] == 2.0
    conceal(tmp_path / "same", "--effect", "gyro_latency", "--size", "2", "--runs", "2", "--seed", "7")
    assert (tmp_path / "same" / "data" / "run_2.csv").read_bytes() == (data / "run_2.csv").read_bytes()


def test_without_an_effect_it_hides_none(tmp_path):
    conceal(tmp_path / "null", "--runs", "1", "--seed", "1")
    answer_file = json.loads((tmp_path / "null" / "answer" / "answer.json").read_text(encoding="utf-8"))
    assert (answer_file["stratum"], answer_file["effects"]) == ("null", [])


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--effect", "gremlins"), "gremlins: cannot be hidden; what can: viscous_drag"),
        (("--effect", "inertia"), "cannot be hidden"),
        (("--effect", "gyro_bias", "--effect", "gyro_bias"), "each effect once"),
        (("--effect", "rotor_speed", "--effect", "actuator_lag"), "other actuators"),
        (("--effect", "gyro_bias", "--random"), "leave --effect out"),
        (("--size", "4"), "--size: of which effect"),
    ],
)
def test_what_cannot_be_hidden_is_refused_and_nothing_is_written(tmp_path, options, message):
    with pytest.raises(InputError, match=message):
        conceal(tmp_path / "out", "--seed", "1", *options)
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("scenario", ["cubesat_wheels", "mixed", "pyramid4"])
def test_platforms_that_the_engine_does_not_fly_are_refused(tmp_path, scenario):
    with pytest.raises(InputError, match="flies platforms with 6 control moment gyros in a pyramid"):
        conceal_effects(scenario, tmp_path / "out", ("viscous_drag",), 7, drawn=False, size=8.0, runs=2)
    assert not (tmp_path / "out").exists()


def test_without_a_checkout_it_says_what_to_do(tmp_path, monkeypatch):
    def missing(name):
        raise ModuleNotFoundError(f"No module named {name!r}", name="concealing")

    monkeypatch.setattr(testbed.cli.conceal, "import_module", missing)
    with pytest.raises(InputError, match="run this in a checkout"):
        conceal(tmp_path / "out", "--seed", "1")
