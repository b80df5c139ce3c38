"""Whether records have one trim of the actuators or own ones: by which of the two is more probable."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
from scipy.stats import chi2

from concealing.files import record
from concealing.flown import fly_case
from support.blind_cases import blind_case
from support.diagnosed_records import SCENARIO
from testbed.assembly.platform import nominal_platform
from testbed.diagnosis.findings import additions
from testbed.diagnosis.fitting import fitted
from testbed.diagnosis.method import diagnosed
from testbed.diagnosis.model_notices import model_notices
from testbed.diagnosis.reading import data_set_of
from testbed.diagnosis.trims import log_odds_of_own_trims, with_one_trim
from testbed.dynamics.inertia import theta_of
from testbed.effects.registry import EFFECTS
from testbed.scenario.reader import read_scenario

WITHOUT = np.zeros((5, 3))
TESTED = ("viscous_drag", "inertial_torque", "gyro_bias")


def records(trims=WITHOUT, effect=None):
    """Return five short records of applied torque, of which trims are not recorded."""
    case = blind_case(3, effect, "platform" if effect else "", size=6.0, actuation="applied_torque")
    flights = [replace(run, maneuver=index) for index, run in enumerate((*case.runs, *case.runs)[: len(trims)])]
    flown = fly_case(replace(case, runs=tuple(flights)))
    found = []
    for index, trim in enumerate(trims):
        each = record(flown, index)
        torque = each.channels["applied_torque"] - trim
        found.append(replace(each, channels=each.channels | {"applied_torque": torque}))
    return found


def stages_of(found):
    scenario = read_scenario(SCENARIO)
    platform = nominal_platform(scenario)
    data = data_set_of(found, scenario, platform)
    effects = {name: EFFECTS[name] for name in TESTED}
    return list(diagnosed(data.runs, data.heldout, effects, theta_of(platform.inertia)))


def test_a_drag_is_not_explained_away_by_a_trim_of_every_record():
    *_, state = stages_of(records(effect="viscous_drag"))
    assert state.runs.trim_group
    assert [added.effect.id for added in additions(state)] == ["viscous_drag"]
    assert len(state.model.trims) == 1


def test_trims_that_differ_from_record_to_record_are_no_effect():
    trims = 2e-4 * np.random.default_rng(4).standard_normal((5, 3))
    stages = stages_of(records(trims))
    state = stages[-1]
    assert stages[0].runs.trim_group  # what is known with one trim is shown until that gives way
    assert sum(after.begins_again(before) for before, after in pairwise(stages)) == 1
    assert not state.runs.trim_group
    assert not additions(state)
    shown = {each.details.name: trim for each, trim in zip(records(trims), trims, strict=True)}
    expected = np.array([shown[name] for name in state.runs.trim_names])
    np.testing.assert_allclose(state.model.trims, expected, atol=3e-5)
    missed = (state.model.trims - expected) / state.model.trim_std
    low, high = chi2.ppf([1e-3, 1.0 - 1e-3], missed.size)
    assert low < np.sum(missed**2) < high
    note = next(text for text in model_notices(state) if "their trim" in text)
    assert f"{state.model.trims[0, 0]:.3g} ± {state.model.trim_std[0, 0]:.1g}" in note


def test_own_trims_are_worth_less_than_the_chi_square_that_they_gain_and_cost_where_there_are_none():
    trims = 1e-4 * np.random.default_rng(5).standard_normal((5, 3))
    scenario = read_scenario(SCENARIO)
    platform = nominal_platform(scenario)
    data = data_set_of(records(trims), scenario, platform)
    together = with_one_trim(data.runs)
    model = fitted(together, [], theta_of(platform.inertia), [])
    apart = log_odds_of_own_trims(together, model)
    own = fitted(data.runs, [], theta_of(platform.inertia), [])
    assert 0.0 < apart < model.chi_square - own.chi_square
    none = with_one_trim(data_set_of(records(), scenario, platform).runs)
    assert log_odds_of_own_trims(none, fitted(none, [], theta_of(platform.inertia), [])) < -20.0
