"""A time base that cannot be the scenario's is refused, with the factor, before anything is made of it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from support.processes import ROOT
from testbed.assembly.time_base import require_time_in_seconds
from testbed.cli.app import app
from testbed.cli.failures import exit_code_of
from testbed.errors import InputError
from testbed.records.record import Record, RunDetails


def record(period: float) -> Record:
    return Record(
        time=period * np.arange(50.0), channels={"body_rate": np.ones((50, 3))}, details=RunDetails(name="run")
    )


@pytest.mark.parametrize("period", [1 / 16, 1 / 100, 1 / 1000, 1 / 2, 1 / 16 / 60])
def test_records_that_are_slower_or_faster_than_the_scenario_pass(period):
    require_time_in_seconds(record(period), 16.0)


@pytest.mark.parametrize(
    ("period", "rate", "remedy"),
    [
        (10.0, 100.0, "1e+03 times the 0.01 s of gyro.sample_rate_hz = 100: divide it by 1000 if it is in ms"),
        (10.0, 16.0, "160 times the 0.0625 s of gyro.sample_rate_hz = 16: divide it by 1000 if it is in ms"),
        (62.5e3, 16.0, "divide it by 1e+06 if it is in us"),
        (1e7, 100.0, "divide it by 1e+09 if it is in ns"),
        (1.25e-5, 100.0, "multiply it by 1000 if it is in thousands of seconds"),
        (0.01 / 3600.0, 100.0, "multiply it by 3600 if it is in hours; if it is in seconds, set"),
    ],
)
def test_another_unit_of_time_is_refused_with_the_factor(period, rate, remedy):
    with pytest.raises(InputError, match=r"^run: time_s grows by .* a gyro sample at the median") as caught:
        require_time_in_seconds(record(period), rate)
    assert remedy in str(caught.value)


@pytest.mark.parametrize("command", ["estimate", "diagnose"])
def test_both_commands_refuse_milliseconds_at_100_hz(command, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    milliseconds = 10.0 * np.arange(200.0)
    rates = 0.1 * np.sin(milliseconds[:, None] / 1e3 * [3.0, 4.0, 5.0])
    header = ",".join(
        [
            "time_s",
            *(f"body_rate_{axis}_rad_s" for axis in "xyz"),
            *(f"cluster_momentum_{axis}_N_m_s" for axis in "xyz"),
        ]
    )
    Path("data").mkdir()
    np.savetxt(
        "data/run.csv",
        np.column_stack([milliseconds, rates, -0.02 * rates]),
        delimiter=",",
        header=header,
        comments="",
    )
    scenario = ROOT / "scenarios" / "diagnose.toml"
    assert exit_code_of(lambda: app([command, str(scenario), "--data", "data", "--out", "out"])) == 2
    printed = capsys.readouterr().err
    assert "divide it by 1000 if it is in ms" in printed
    assert not Path("out").exists()
