"""The real flights that the project ships are taken as they are."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchmarks.crazypad import Kept, diagnosed
from testbed.assembly.platform import nominal_body
from testbed.diagnosis.reading import data_set_of
from testbed.records.reading import read_data_set
from testbed.scenario.reader import read_body_scenario
from testbed.scenario.shipped import shipped_scenario

DATA = Path(__file__).resolve().parents[2] / "data" / "crazypad"
SCENARIO = read_body_scenario(shipped_scenario("crazypad"))
FOLDERS = sorted(each.name for each in DATA.iterdir() if each.is_dir())


@pytest.mark.parametrize("folder", FOLDERS)
def test_flights_of_a_quadcopter_that_hardly_moves_are_in_the_units_that_they_state(folder):
    """Windows of half a second without motion were taken for a torque in mN·m, and the whole folder was refused."""
    data = data_set_of(read_data_set(DATA / folder), SCENARIO, nominal_body(SCENARIO))
    assert np.isfinite(data.runs.sigma).all()


def test_healthy_flights_show_nothing_that_other_healthy_flights_do_not():
    result = diagnosed("normal", Kept())
    assert result.verdict == "none"
    assert result.steps == ()
