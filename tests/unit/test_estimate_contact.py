"""`testbed estimate` on a record that goes on after the platform met the wall, and does not say where."""

from pathlib import Path

import numpy as np
import pytest

from testbed.campaign.flights import fly_seeds
from testbed.cli.app import app
from testbed.cli.failures import exit_code_of
from testbed.maneuver.profiles import basic_profile
from testbed.scenario.reader import read_scenario
from testbed.scenario.shipped import shipped_scenario
from testbed.signals import SIGNALS

SCENARIO = shipped_scenario("zero_g_campaign")
CHANNELS = ("body_rate", "gimbal_angle", "rotor_speed")


@pytest.fixture(scope="module")
def flown(tmp_path_factory) -> tuple[Path, float]:
    """A folder with one record of a flight into the wall, as CSV and nothing beside it, and the time of the contact."""
    scenario = read_scenario(SCENARIO)
    steering = scenario.controller.steering.model_copy(update={"preferred_gimbal_angle_rad": "zero"})
    controller = scenario.controller.model_copy(update={"steering": steering})
    (flight,) = fly_seeds(scenario.model_copy(update={"controller": controller}), basic_profile(), [7])
    record = flight.flown.record
    rows = np.isfinite(record.channels["gimbal_angle"]).all(axis=1)
    header = ["time_s", *(column for name in CHANNELS for column in SIGNALS[name].columns)]
    table = np.column_stack([record.time[rows], *(record.channels[name][rows] for name in CHANNELS)])
    folder = tmp_path_factory.mktemp("data")
    np.savetxt(folder / "parabola.csv", table, delimiter=",", header=",".join(header), comments="")
    return folder, flight.flown.first_contact


def run(scenario: Path, data: Path, capsys) -> str:
    assert exit_code_of(lambda: app(["estimate", str(scenario), "--data", str(data)])) == 0
    printed = capsys.readouterr()
    return " ".join((printed.out + printed.err).split())


def test_the_record_is_cut_where_the_scenario_asks_for_it(flown, capsys):
    folder, contact = flown
    text = run(SCENARIO, folder, capsys)
    found = float(text.split("contact found at ")[1].split()[0])
    cut = float(text.split("record cut at ")[1].split()[0])
    assert found - 1 / 16 - 1e-3 <= cut < found  # printed in milliseconds
    assert cut < contact <= found + 1 / 16


def test_a_stated_end_is_believed(flown, capsys):
    folder, _ = flown
    (folder / "parabola.toml").write_text("usable_to_s = 2.0\n")
    assert "contact found" not in run(SCENARIO, folder, capsys)
    (folder / "parabola.toml").unlink()


def test_without_the_option_nothing_is_cut(flown, tmp_path, capsys):
    folder, _ = flown
    scenario = tmp_path / "scenario.toml"
    scenario.write_text(SCENARIO.read_text(encoding="utf-8").replace("cut_at_contact = true", "cut_at_contact = false"))
    code = exit_code_of(lambda: app(["estimate", str(scenario), "--data", str(folder)]))
    printed = capsys.readouterr()
    assert code in (0, 2)  # what follows the wall fits no model; whether an estimator notices is not the question here
    assert "contact found" not in printed.out + printed.err
