"""Body-rate designs: limits on a grid ten times finer than the design's, every criterion, the paper's penalty."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from support.maneuvers import INERTIA, MOMENTUM_LIMIT, TORQUE_LIMIT, body_rate_limits, design_problem
from testbed.errors import InfeasibleDesignError
from testbed.maneuver.body_rate_design import body_rate_design
from testbed.maneuver.design import Search
from testbed.maneuver.information import maneuver_information
from testbed.maneuver.penalty import Penalty
from testbed.maneuver.profiles import basic_profile
from testbed.rotation.kinematics import integrate_attitude
from testbed.rotation.quaternion import quaternion_product, tilts

FINE = np.linspace(0.0, 5.0, 1601)  # the design's own grid has 161 instants
CRITERIA = ("D", "A", "E", "condition")


def designed(criterion="D", penalty=None, starts=2, control_points=16, **changes):
    return body_rate_design(
        design_problem(criterion, control_points, **changes), body_rate_limits(), Search(starts=starts, seed=4), penalty
    )


@pytest.fixture(scope="module")
def designs():
    return {criterion: designed(criterion) for criterion in CRITERIA}


@pytest.mark.parametrize("criterion", CRITERIA)
def test_limits_are_kept_between_the_samples(criterion, designs):
    reference = designs[criterion].maneuver.reference(FINE)
    slack = 1e-6  # share of a limit that the solver leaves
    assert np.abs(reference.body_rate).max() <= 0.3 * (1 + slack)
    assert np.all(np.abs(reference.body_rate @ INERTIA) <= MOMENTUM_LIMIT * (1 + slack))
    assert np.all(np.abs(reference.body_acceleration @ INERTIA) <= TORQUE_LIMIT * (1 + slack))


@pytest.mark.parametrize("criterion", CRITERIA)
def test_it_goes_from_rest_to_rest(criterion, designs):
    ends = designs[criterion].maneuver.reference(np.array([0.0, 5.0]))
    np.testing.assert_array_equal(ends.body_rate, 0.0)
    np.testing.assert_allclose(ends.body_acceleration, 0.0, atol=1e-12)


def test_every_criterion_improves_on_the_d_design_in_its_own_figure(designs):
    figures = {criterion: design.information for criterion, design in designs.items()}
    # Few points leave A and D the same optimum, held by the limits alone; the solver's tolerance decides.
    assert figures["A"].trace_inverse < figures["D"].trace_inverse * (1 + 1e-5)
    assert figures["E"].min_eigenvalue > figures["D"].min_eigenvalue
    assert figures["condition"].condition_number < figures["D"].condition_number


def test_the_cost_is_the_figure(designs):
    """What the slack bounds is the eigenvalue itself, and what is reported belongs to the maneuver."""
    figures = {criterion: design.information for criterion, design in designs.items()}
    costs = {criterion: min(start.cost for start in design.starts) for criterion, design in designs.items()}
    assert costs["D"] == pytest.approx(-np.log(figures["D"].determinant), abs=1e-9)
    assert costs["A"] == pytest.approx(np.log(figures["A"].trace_inverse), abs=1e-9)
    assert costs["E"] == pytest.approx(-np.log(figures["E"].min_eigenvalue), abs=1e-4)
    condition = np.log(figures["condition"].condition_number) - 0.3 / 6 * np.log(figures["condition"].determinant)
    assert costs["condition"] == pytest.approx(condition, abs=1e-4)


@pytest.mark.parametrize("criterion", CRITERIA)
def test_the_penalty_bends_the_limits_a_little(criterion):
    """Eqs. (27)-(29) trade information for overshoot; more than 3 % would mean that the weights are too small."""
    design = designed(criterion, Penalty(), starts=1)
    reference = design.maneuver.reference(FINE)
    overshoot = np.abs(reference.body_rate).max() / 0.3 - 1.0
    assert 0.0 < overshoot < 0.03
    assert np.abs(reference.body_rate[[0, -1]]).max() < 0.03 * 0.3
    assert np.all(np.abs(reference.body_acceleration @ INERTIA) <= 1.03 * TORQUE_LIMIT)
    assert design.information.trace_inverse < 2.4  # the paper's own D-opt maneuver has 2.43


def test_weaker_penalties_overshoot_more():
    weak, strong = (
        np.abs(designed("D", Penalty(rate=weight), starts=1).maneuver.body_rate.c).max() for weight in (1e5, 1e11)
    )
    assert weak > strong + 0.005


def test_a_start_is_the_same_whatever_the_number_of_starts(designs):
    alone, among = designed(starts=1), designs["D"]
    assert alone.starts[0].cost == among.starts[0].cost
    again = designed()
    np.testing.assert_array_equal(again.maneuver.body_rate.c, among.maneuver.body_rate.c)


def test_a_start_in_motion_is_brought_to_rest():
    initial = np.array([0.1, -0.05, 0.08])
    reference = designed(initial_body_rate=initial).maneuver.reference(FINE)
    np.testing.assert_allclose(reference.body_rate[0], initial, atol=1e-15)
    np.testing.assert_allclose(reference.body_rate[-1], 0.0, atol=1e-15)
    total = np.linalg.norm(INERTIA @ initial)
    assert np.all(np.abs(reference.body_rate @ INERTIA) <= MOMENTUM_LIMIT - total + 1e-8)


@pytest.mark.parametrize("penalty", [None, Penalty()])
def test_a_tilt_is_kept_and_taken_up(penalty):
    """By the attitude along the body rate: what a bearing allows holds between the design's instants, too."""
    limit, tilted = 0.12, np.array([0.0, np.sin(0.05), np.cos(0.05)])
    problem = design_problem("D", 16, initial_up_B=tilted)
    limits = replace(body_rate_limits(), tilt=limit)
    free, kept = (
        body_rate_design(problem, each, Search(starts=1, seed=4), penalty) for each in (body_rate_limits(), limits)
    )
    start = np.array([np.cos(0.025), np.sin(0.025), 0.0, 0.0])  # body z leans by 0.05 rad about x
    tilt = {
        name: tilts(quaternion_product(start, integrate_attitude(FINE, each.maneuver.reference(FINE).body_rate))).max()
        for name, each in (("free", free), ("kept", kept))
    }
    assert tilt["free"] > 1.5 * limit
    assert 0.9 * limit < tilt["kept"] < 1.01 * limit
    assert kept.information.determinant < free.information.determinant


def test_a_total_momentum_beyond_the_cluster_is_refused():
    with pytest.raises(InfeasibleDesignError, match=r"total momentum of 0\.0264 N·m·s leaves -0\.0054 N·m·s"):
        designed(initial_body_rate=np.array([1.2, 0.0, 0.0]))


def test_limits_that_conflict_are_named():
    """A start at 0.4 rad/s cannot keep |ω| ≤ 0.3 rad/s: a third too much."""
    with pytest.raises(InfeasibleDesignError, match=r"body rate by 0\.33 of its limit"):
        designed(starts=1, initial_body_rate=np.array([0.4, 0.0, 0.0]))


def test_a_given_start_leads_to_an_optimum_near_it():
    """Each design is an optimum, so that started from itself it stays, to the solver's tolerance in the cost."""
    for penalty in (None, Penalty()):
        design = designed(penalty=penalty, starts=1)
        again = body_rate_design(
            design_problem("D", 16), body_rate_limits(), Search(starts=1, seed=9), penalty, initial=design.maneuver
        )
        np.testing.assert_allclose(again.maneuver.body_rate.c, design.maneuver.body_rate.c, atol=1e-3 * 0.3)
        assert again.starts[0].cost == pytest.approx(design.starts[0].cost, abs=1e-4)


def test_a_given_start_may_have_other_control_points():
    """What seeds draw does not matter then, and the paper's way improves on the profile it starts from."""
    first, second = (
        body_rate_design(
            design_problem("D", 8), body_rate_limits(), Search(starts=1, seed=seed), Penalty(), initial=basic_profile()
        )
        for seed in (1, 2)
    )
    np.testing.assert_array_equal(first.maneuver.body_rate.c, second.maneuver.body_rate.c)
    assert first.information.determinant > 1e4 * maneuver_information(basic_profile(), 16.0, 0.8).determinant
