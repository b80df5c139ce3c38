"""What a folder of a diagnosis says of the model in it."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from testbed.assembly.platform import nominal_platform
from testbed.diagnosis.model import Hypothesis
from testbed.dynamics.inertia import theta_of
from testbed.effects.registry import EFFECTS
from testbed.outputs.diagnosis_folder import _write_model
from testbed.scenario.reader import read_scenario
from testbed.scenario.shipped import shipped_scenario


@pytest.mark.parametrize(
    ("effect", "component", "said"),
    [
        ("gyro_clock_drift", "gyro", ("extended/ flies without gyro_clock_drift:gyro: no simulated platform has it",)),
        ("gyro_scale", "z", ()),
    ],
)
def test_effects_that_no_flight_has_are_named(tmp_path, effect, component, said):
    scenario = read_scenario(shipped_scenario("diagnose"))
    placed = Hypothesis(effect=EFFECTS[effect], component=component)
    values = np.array([[each.typical for each in placed.effect.parameters]])
    model = SimpleNamespace(
        placed=(placed,),
        values=SimpleNamespace(effects=(values,)),
        theta=theta_of(nominal_platform(scenario).inertia),
    )
    written, notices = _write_model(tmp_path, scenario, SimpleNamespace(model=model, scatter=()))
    assert notices == said
    assert (tmp_path / written["scenario"]).is_file()
