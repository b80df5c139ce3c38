"""Evidence of flights and the choice of the next one: e-values of a hidden effect, expected growth, refined paths."""

from __future__ import annotations

from dataclasses import replace
from math import log

import numpy as np
import pytest

from support.diagnosed_records import nominal, records
from testbed.diagnosis.data import chosen, joined
from testbed.diagnosis.model import parameters_of_runs
from testbed.diagnosis.reading import data_set_of
from testbed.dynamics.inertia import theta_of
from testbed.effects.registry import EFFECTS
from testbed.next_experiment.forecast import blank_runs, forecast_columns
from testbed.next_experiment.sampling import largest_flight
from testbed.sequential.choosing import chosen_flight, most_gained
from testbed.sequential.evidence import candidates_of, evidence_of
from testbed.sequential.expected_gain import class_goal, goal_of, information_of
from testbed.sequential.forecasts import Forecasts
from testbed.sequential.refining import refinement_of
from testbed.sequential.robust import Case, RobustSpace, robust_space
from testbed.sequential.wanted import EffectWanted, InertiaWanted

FEW = {name: EFFECTS[name] for name in ("gyro_bias", "gyro_scale", "gimbal_zero")}
ZERO = np.array([0.02])
STEPS_OF_INERTIA = np.array([[0.02, 0.0212, 0.0258, 0.0, 0.0, 0.001]])
"""Whole steps of 2e-4 kg·m², to which forecasts round an inertia of this size."""
ON_A_STEP = np.full(3, 0.00166)
"""rad/s, of three digits, to which forecasts round the noise."""


def evidence_from(taken):
    scenario, platform = nominal()
    data = data_set_of(taken, scenario, platform)
    return evidence_of(joined(data.runs, data.heldout), FEW, theta_of(platform.inertia))


@pytest.fixture(scope="module")
def shifted():
    """Two flights of a platform whose second encoder is off by 20 mrad."""
    return evidence_from(records(2, hooks=[FEW["gimbal_zero"].hooks("cmg2")], values=[ZERO]))


@pytest.fixture(scope="module")
def space():
    """Two cases are enough here: each costs seconds."""
    return RobustSpace(nominal=robust_space(nominal()[0]).nominal, cases=(Case(), Case(failed=2)))


@pytest.fixture(scope="module")
def forecasts(space):
    return Forecasts(space=space)


@pytest.fixture(scope="module")
def flights(space):
    """A few flights within the limits."""
    paths = space.paths(np.random.default_rng(1))[:3]
    releases = list(space.releases())[:2]
    return [flight for release in releases for path in paths for flight in largest_flight(space, release, path)]


def test_the_hidden_effect_has_the_largest_e_value_and_the_mean_passes(shifted):
    candidates = candidates_of(shifted, None, None)
    assert candidates[0] == "gimbal_zero:cmg2"
    assert shifted.log_mean(candidates, len(candidates)) > log(1.0 / 0.05)
    assert candidates_of(shifted, "gimbal_zero", "cmg2") == ["gimbal_zero:cmg2"]
    assert sum(shifted.shares.values()) == pytest.approx(1.0)


def test_without_an_effect_the_e_values_stay_small():
    evidence = evidence_from(records(2, seed=3))
    candidates = candidates_of(evidence, None, None)
    assert evidence.log_mean(candidates, len(candidates)) < log(1.0 / 0.05)


def test_a_named_effect_does_not_share_the_prior_with_others(shifted):
    alone = candidates_of(shifted, "gimbal_zero", None)
    everything = candidates_of(shifted, None, None)
    assert shifted.log_mean(alone, len(alone)) > shifted.log_mean(everything, len(everything))


def test_of_an_effect_that_is_sure_to_the_last_bit_a_flight_still_shows_more(shifted, forecasts, flights):
    """Its rivals' shares are zero in numbers: their weights among one another had been 0/0."""
    sure = replace(shifted, by_key={key: 2000.0 * (key == "gimbal_zero:cmg2") for key in shifted.by_key})
    assert most_gained(goal_of(sure, EffectWanted()), shifted.runs, forecasts, flights) > 0.0


def test_the_refined_flight_is_expected_to_show_more_and_keeps_all_limits(shifted, space, forecasts, flights):
    goal = goal_of(shifted, EffectWanted())
    plain = chosen_flight(goal, shifted.runs, forecasts, flights)
    better = chosen_flight(
        goal, shifted.runs, forecasts, flights, refinement=refinement_of(shifted, goal, space, print)
    )
    assert plain.worst <= plain.gain
    assert better.gain + better.worst >= plain.gain + plain.worst
    assert space.shares(better.flight.release, better.flight.control_points[None]).max() <= 1.0 + 1e-9
    assert most_gained(goal, shifted.runs, forecasts, flights) >= plain.gain


def test_a_flight_for_the_inertia_makes_its_worst_ratio_smaller(shifted, forecasts, flights):
    goal = goal_of(shifted, InertiaWanted(std={"J11": 1e-5, "J33": 1e-5}))
    best = chosen_flight(goal, shifted.runs, forecasts, flights)
    assert best.gain > 0.0
    assert best.worst > 0.0


def test_flights_bring_members_of_a_class_apart(shifted, forecasts, flights):
    goal = class_goal(shifted, ["gimbal_zero:cmg2", "gimbal_zero:cmg1"])
    assert most_gained(goal, shifted.runs, forecasts, flights) > 1.0
    assert class_goal(shifted, ["gimbal_zero:cmg2"]) is None
    assert chosen_flight(goal, shifted.runs, forecasts, []) is None


def test_forecasts_are_those_of_each_flight_on_its_own_and_are_worked_out_once(shifted, space, flights, monkeypatch):
    goal, kept, runs = goal_of(shifted, EffectWanted()), Forecasts(space=space), shifted.runs.with_sigma(ON_A_STEP)
    model = replace(goal.model, values=replace(goal.model.values, theta=STEPS_OF_INERTIA))
    common = model.jacobian.shape[1] - parameters_of_runs(runs)
    for case in space.cases:
        flown = [space.flown_in(case, flight) for flight in flights]
        blank = blank_runs(flown, case.runs(chosen(runs, [0])), case.platform(space.platform))
        expected = information_of(forecast_columns(case.model(model), flown, blank), common)
        found = kept.information(model, runs, flights, case)
        np.testing.assert_allclose(found, expected, rtol=1e-7, atol=1e-9 * np.abs(expected).max())
    monkeypatch.setattr("testbed.sequential.forecasts.forecast_columns", None)
    np.testing.assert_array_equal(kept.information(model, runs, flights[::-1], space.cases[-1])[::-1], found)


def test_the_rounding_of_inertia_and_noise_moves_forecasts_by_less_than_a_tenth(shifted, space, flights):
    """Half a step each, as far as they can be off."""
    goal, kept, runs = goal_of(shifted, EffectWanted()), Forecasts(space=space), shifted.runs.with_sigma(ON_A_STEP)
    near = replace(goal.model, values=replace(goal.model.values, theta=STEPS_OF_INERTIA))
    off = replace(goal.model, values=replace(goal.model.values, theta=STEPS_OF_INERTIA + 0.9e-4))
    found = kept.information(off, runs.with_sigma(1.002 * ON_A_STEP), flights, Case())
    columns = forecast_columns(off, flights, blank_runs(flights, chosen(runs, [0]), space.platform))
    expected = information_of(columns, found.shape[1])
    scale = np.sqrt(np.einsum("fcc->fc", expected).max(axis=0))
    np.testing.assert_array_equal(found, kept.information(near, runs, flights, Case()))
    np.testing.assert_allclose(found / np.outer(scale, scale), expected / np.outer(scale, scale), atol=0.08)


def test_forecasts_of_a_further_hypothesis_are_those_that_it_has_among_all(shifted, space, flights):
    goal, kept = goal_of(shifted, EffectWanted()), Forecasts(space=space)
    some = replace(
        goal.model,
        placed=goal.model.placed[:2],
        values=replace(goal.model.values, effects=goal.model.values.effects[:2]),
    )
    kept.information(some, shifted.runs, flights[:2], Case())
    grown = kept.information(goal.model, shifted.runs, flights, Case())
    at_once = Forecasts(space=space).information(goal.model, shifted.runs, flights, Case())
    np.testing.assert_allclose(grown, at_once, rtol=1e-9, atol=1e-9 * np.abs(at_once).max())
