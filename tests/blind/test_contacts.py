"""When the platform was touched: between two samples of the gyro, which do not show at which instant."""

from __future__ import annotations

import numpy as np
import pytest

from concealing.files import conceal
from support.blind_cases import RUNS, blind_case
from support.diagnosed_records import SCENARIO
from testbed.assembly.platform import nominal_platform
from testbed.diagnosis.findings import additions
from testbed.diagnosis.method import diagnosed
from testbed.diagnosis.model_notices import model_notices
from testbed.diagnosis.reading import data_set_of
from testbed.dynamics.inertia import theta_of
from testbed.effects.registry import EFFECTS
from testbed.records.reading import read_data_set
from testbed.scenario.reader import read_scenario


@pytest.mark.parametrize("seed", range(641, 647))
def test_the_interval_of_a_blow_holds_its_instant_and_names_its_run(seed, tmp_path):
    case = blind_case(seed, "contact", "platform", size=8.0)
    scenario = read_scenario(SCENARIO)
    nominal = nominal_platform(scenario)
    conceal(case, tmp_path / "data", tmp_path / "answer")
    data = data_set_of(read_data_set(tmp_path / "data"), scenario, nominal)
    *_, found = diagnosed(data.runs, data.heldout, {"contact": EFFECTS["contact"]}, theta_of(nominal.inertia))
    (added,) = additions(found)
    time = added.quantities[0]
    hidden = case.effects[0].parameters
    record = f"run_{int(hidden['run']) + 1}"
    assert hidden["run"] < RUNS
    (notice,) = (each for each in model_notices(found) if "on the clock of" in each)
    assert notice.endswith(record)
    on_its_clock = float(notice.split(" is ")[1].split(" ± ")[0])
    assert abs(on_its_clock - hidden["time"]) < 1.96 * time.std
    assert time.std > 1.0 / case.telemetry.gyro_rate / np.sqrt(12.0)
