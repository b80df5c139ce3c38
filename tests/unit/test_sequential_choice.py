"""Evidence of flights and the choice of the next one: e-values of a hidden effect, expected growth, refined paths."""

from __future__ import annotations

from dataclasses import replace
from math import log

import numpy as np
import pytest

from support.diagnosed_records import nominal, records
from testbed.diagnosis.data import joined
from testbed.diagnosis.reading import data_set_of
from testbed.dynamics.inertia import theta_of
from testbed.effects.registry import EFFECTS
from testbed.next_experiment.sampling import largest_flight
from testbed.sequential.evidence import candidates_of, evidence_of
from testbed.sequential.expected_gain import class_goal, goal_of
from testbed.sequential.refining import refinement_of
from testbed.sequential.robust import Case, RobustSpace, chosen_flight, most_gained, robust_space
from testbed.sequential.wanted import EffectWanted, InertiaWanted

FEW = {name: EFFECTS[name] for name in ("gyro_bias", "gyro_scale", "gimbal_zero")}
ZERO = np.array([0.02])


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


def test_of_an_effect_that_is_sure_to_the_last_bit_a_flight_still_shows_more(shifted, space, flights):
    """Its rivals' shares are zero in numbers: their weights among one another had been 0/0."""
    sure = replace(shifted, by_key={key: 2000.0 * (key == "gimbal_zero:cmg2") for key in shifted.by_key})
    assert most_gained(goal_of(sure, EffectWanted()), shifted.runs, space, flights) > 0.0


def test_the_refined_flight_is_expected_to_show_more_and_keeps_all_limits(shifted, space, flights):
    goal = goal_of(shifted, EffectWanted())
    plain = chosen_flight(goal, shifted.runs, space, flights)
    better = chosen_flight(goal, shifted.runs, space, flights, refinement=refinement_of(shifted, goal, space, print))
    assert plain.worst <= plain.gain
    assert better.gain + better.worst >= plain.gain + plain.worst
    assert space.shares(better.flight.release, better.flight.control_points[None]).max() <= 1.0 + 1e-9
    assert most_gained(goal, shifted.runs, space, flights) >= plain.gain


def test_a_flight_for_the_inertia_makes_its_worst_ratio_smaller(shifted, space, flights):
    goal = goal_of(shifted, InertiaWanted(std={"J11": 1e-5, "J33": 1e-5}))
    chosen = chosen_flight(goal, shifted.runs, space, flights)
    assert chosen.gain > 0.0
    assert chosen.worst > 0.0


def test_flights_bring_members_of_a_class_apart(shifted, space, flights):
    goal = class_goal(shifted, ["gimbal_zero:cmg2", "gimbal_zero:cmg1"])
    assert most_gained(goal, shifted.runs, space, flights) > 1.0
    assert class_goal(shifted, ["gimbal_zero:cmg2"]) is None
    assert chosen_flight(goal, shifted.runs, space, []) is None
