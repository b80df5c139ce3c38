"""The zero-g story: one campaign with a rotor that has more momentum than it shows, and what its page says."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.zero_g_story import outcome_of, situations
from benchmarks.zero_g_story_page import Outcome, draw, held_share, page
from concealing.guidance import planned_maneuver
from testbed.reproduction.zero_g import FLIGHTS, SCENARIO
from testbed.reproduction.zero_g_cuts import SHORTEST
from testbed.scenario.reader import read_scenario
from testbed.scenario.shipped import shipped_scenario

OUTCOME = Outcome(
    hidden="a leak",
    key="body_torque:platform",
    campaign=0,
    verdict="ambiguous",
    named=("inertial_torque:platform",),
    look_alikes=("body_torque:platform",),
    gap=(2.0, 1.0),
    heldout_gap=(2.5, 1.1),
    without=(9.0, -9.0, 9.0, 1.0, 1.0, 1.0),
    with_named=(1.0, -1.0, 1.0, 1.0, 3.0, -1.0),
    usable=(2.2, 3.1),
)


@pytest.fixture(scope="module")
def rotor():
    """One campaign, on a maneuver that needs no design."""
    path = shipped_scenario(SCENARIO)
    scenario = read_scenario(path)
    _, hidden, _ = situations(scenario)
    return outcome_of(scenario, planned_maneuver(path, 0, (0.0, 0.0, 0.0)), hidden, campaign=0)


def test_the_hidden_rotor_is_named_and_the_gap_closes(rotor):
    assert rotor.first
    assert rotor.gap[1] < 1.05 < rotor.gap[0]


def test_leaving_it_out_moves_the_inertia_beyond_its_intervals(rotor):
    assert held_share([rotor.without]) <= 0.5
    assert held_share([rotor.with_named]) >= 5 / 6
    assert np.abs(rotor.with_named).max() < 4.0  # standard deviations


def test_every_flight_is_used_up_to_its_contact(rotor):
    assert len(rotor.usable) == FLIGHTS
    assert all(SHORTEST <= usable < 5.0 for usable in rotor.usable)  # s; the maneuver is longer than any flight


def test_a_look_alike_counts_as_in_the_set_but_not_as_first():
    assert OUTCOME.in_set
    assert not OUTCOME.first
    assert not replace(OUTCOME, look_alikes=()).in_set
    assert replace(OUTCOME, key="", verdict="none", named=(), look_alikes=()).first
    assert not replace(OUTCOME, key="", verdict="unexplained", named=(), look_alikes=()).first


def test_the_page_counts(tmp_path):
    right = replace(OUTCOME, campaign=1, named=("body_torque:platform",))
    text = page([OUTCOME, right], "today", "picture.png")
    assert "| a leak | 1 of 2 | 2 of 2 | 2.00 → 1.00 | 2.50 → 1.10 | 50%; 6.4 σ | 83%; 1.5 σ |" in text
    draw([OUTCOME, right], tmp_path / "picture.png")
    assert (tmp_path / "picture.png").stat().st_size > 1000
