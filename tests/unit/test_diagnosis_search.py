"""Steps back: what other effects made needless leaves the model, and several effects are judged together."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from support.diagnosed_records import nominal, records
from testbed.diagnosis.candidates import accepted
from testbed.diagnosis.fitting import refit
from testbed.diagnosis.method import check_residual, diagnosed
from testbed.diagnosis.p_values import largest_log_odds
from testbed.diagnosis.reading import data_set_of
from testbed.diagnosis.screening import refitted
from testbed.diagnosis.search import Search, odds_together, with_candidate, with_effect
from testbed.diagnosis.testable import hypotheses
from testbed.dynamics.inertia import theta_of
from testbed.effects.registry import EFFECTS
from testbed.errors import InputError

FEW = {name: EFFECTS[name] for name in ("viscous_drag", "rotor_speed", "body_torque")}
TRUE = "rotor_speed:cmg2"


@pytest.fixture(scope="module")
def start():
    scenario, platform = nominal()
    hidden = {"hooks": [FEW["rotor_speed"].hooks("cmg2")], "values": [np.array([0.03])]}
    data = data_set_of(records(4, **hidden), scenario, platform)
    return next(diagnosed(data.runs, data.heldout, FEW, theta_of(platform.inertia)))


@pytest.fixture(scope="module")
def search(start):
    return Search(
        testable=tuple(hypotheses(start.runs, FEW)[0]), progress=lambda _: None, in_own_noise=lambda state: state
    )


def added(search, state, key):
    screening = search.screened(state)
    placed = next(each for each in search.testable if each.key == key)
    return with_effect(state, refitted(state.runs, state.heldout, state.model, screening, placed), screening)


def test_all_effects_that_another_makes_needless_are_taken_out(start, search):
    state = start
    for key in ("body_torque:platform", "viscous_drag:platform", TRUE):
        state = added(search, state, key)
    left = search.reconsidered(state)
    assert [step.placed.key for step in left.steps] == [TRUE]
    assert [placed.key for placed in left.model.placed] == [TRUE]


def test_what_stands_stays(start, search):
    state = added(search, start, TRUE)
    assert search.reconsidered(state) is state


def test_an_effect_has_the_class_of_what_explains_as_much_beside_the_others(start, search):
    """One that was compared while another was missing has that one's class: it was the best of all then."""
    state = added(search, added(search, start, "body_torque:platform"), TRUE)
    first, second = state.steps
    assert [each.key for each in first.screening.close] == [TRUE]
    own, other = search._with_own_classes(state).steps
    assert other is second
    assert "body_torque:platform" in {each.key for each in own.screening.close}
    assert TRUE not in {each.key for each in own.look_alikes}


def test_with_classes_of_their_own_effects_are_added_again_to_the_bare_model(start, search):
    """The first one's comparison was beside all others then: what was taken out had come back with it, unseen."""
    state = search._with_own_classes(added(search, added(search, start, "body_torque:platform"), TRUE))
    rebuilt = search._rebuilt(state, [state.steps[0].placed])
    assert [step.placed.key for step in rebuilt.steps] == ["body_torque:platform"]
    assert [placed.key for placed in rebuilt.model.placed] == ["body_torque:platform"]


def test_without_an_effect_that_holds_the_motion_its_class_stays(start, search, monkeypatch):
    def runs_away(*_):
        raise InputError("the motion runs away")

    state = added(search, added(search, start, "body_torque:platform"), TRUE)
    monkeypatch.setattr(Search, "compared", runs_away)
    assert search.reconsidered(state) is state


def with_freedom(state, freedom):
    """Return a diagnosis without held-out runs whose noise is known with so many degrees of freedom."""
    return replace(state, heldout=None, runs=replace(state.runs, noise_freedom=freedom))


def test_what_little_known_noise_hides_is_tested_in_the_noise_that_it_leaves(start, search):
    """Of three degrees of freedom no effect is significant; what the larger model leaves is known with many more."""
    poorly = with_freedom(with_noise(start, 4.0), 3.0)
    known = replace(search, in_own_noise=lambda state: with_freedom(state, 500.0), known={})
    assert accepted(known.screened(poorly)).placed.key == TRUE


def test_in_noise_that_stays_little_known_evidence_is_no_larger_than_the_p_value_of_one_test_allows(start, search):
    poorly = with_freedom(with_noise(start, 4.0), 3.0)
    screening = replace(search, known={}).screened(poorly)
    (own,) = [each for each in screening.candidates if each.placed.key == TRUE]
    assert not own.significant
    assert own.log_bayes_factor == pytest.approx(largest_log_odds(own.p_value / screening.tested))
    assert screening.odds(own) < largest_log_odds(own.p_value)
    assert accepted(screening) is None


def test_what_runs_away_in_that_noise_has_no_more_evidence_either(start, search):
    def runs_away(_):
        raise InputError("the motion runs away")

    poorly = with_freedom(with_noise(start, 4.0), 3.0)
    screening = replace(search, in_own_noise=runs_away, known={}).screened(poorly)
    (own,) = [each for each in screening.candidates if each.placed.key == TRUE]
    assert own.log_bayes_factor == pytest.approx(largest_log_odds(own.p_value / screening.tested))


def with_noise(state, times):
    """Return a diagnosis whose noise is known to be so many times as large."""
    runs, heldout = (each.with_sigma(times * each.sigma) for each in (state.runs, state.heldout))
    return replace(state, runs=runs, heldout=heldout, model=refit(runs, state.model))


def test_what_does_not_stand_out_of_the_noise_in_the_end_is_taken_out(start, search):
    state = added(search, start, TRUE)
    assert search.standing(state) is state
    larger = with_noise(state, 1.3)
    assert search.standing(larger) is larger
    left = search.standing(with_noise(state, 1000.0))
    assert not left.steps
    assert not left.model.placed
    assert accepted(left.remaining) is None


def test_of_two_effects_the_one_that_does_not_stand_out_is_taken_out(start, search):
    state = added(search, added(search, start, TRUE), "body_torque:platform")
    left = search.standing(state)
    assert [step.placed.key for step in left.steps] == [TRUE]
    assert [placed.key for placed in left.model.placed] == [TRUE]
    assert not left.unnamed


def test_one_effect_is_as_likely_as_the_screening_says(start, search):
    state = added(search, start, TRUE)
    (step,) = state.steps
    known = (start.heldout, start.model), (state.heldout, state.model)
    together = odds_together(*known, step.screening.tested, [step.candidate])
    assert together == pytest.approx(step.screening.odds(step.candidate), rel=1e-3)


def test_effects_together_are_less_likely_for_each_that_adds_nothing(start, search):
    alone = added(search, start, TRUE)
    more = added(search, alone, "body_torque:platform")
    tested = alone.steps[0].screening.tested
    bare = (start.heldout, start.model)
    odds = [
        odds_together(bare, (each.heldout, each.model), tested, [step.candidate for step in each.steps])
        for each in (alone, more)
    ]
    assert odds[1] < odds[0]


def test_an_effect_in_the_model_is_asked_of_however_little_it_promised(start, search):
    state = added(search, start, TRUE)
    screening = search.screened(start)
    (own,) = [each for each in screening.candidates if each.placed.key == TRUE]
    others = replace(screening, candidates=tuple(each for each in screening.candidates if each is not own))
    assert accepted(others) is None or accepted(others).placed.key != TRUE
    again = with_candidate(start, others, state.steps[0].placed, state.model)
    assert accepted(again).placed.key == TRUE
    assert with_candidate(start, screening, own.placed, state.model) is screening
    masked = replace(others, signatures=tuple(each for each in others.signatures if each.placed.key != TRUE))
    assert with_candidate(start, masked, own.placed, state.model) is masked


def test_two_effects_that_cancel_are_no_explanation(start, search):
    """A constant torque that a drag takes away again: of each as much is added as nobody sees of both."""
    state = added(search, start, "body_torque:platform")
    candidate = refitted(state.runs, state.heldout, state.model, search.screened(state), _placed(search, TRUE))
    assert not candidate.cancels
    own, other = (candidate.fit.own(_placed(search, key)) for key in (TRUE, "body_torque:platform"))
    jacobian = candidate.fit.jacobian.copy()
    columns = slice(6 + other.start, 6 + other.stop)
    sizes = candidate.fit.effect_values
    wanted = -candidate.fit.contribution(candidate.placed)
    jacobian[:, columns] = np.outer(wanted, sizes[other]) / (sizes[other] @ sizes[other])
    assert replace(candidate, fit=replace(candidate.fit, jacobian=jacobian)).cancels
    jacobian[:, columns] *= 0.5
    assert not replace(candidate, fit=replace(candidate.fit, jacobian=jacobian)).cancels
    assert own != other


def test_over_windows_an_effect_that_has_no_size_of_its_own_beside_another_is_blurred(start, search):
    state = added(search, start, "body_torque:platform")
    candidate = refitted(state.runs, state.heldout, state.model, search.screened(state), _placed(search, TRUE))
    windows = replace(candidate, fit=replace(candidate.fit, torque_noise=np.eye(3)))
    own = windows.fit.own(candidate.placed)
    hardly_shown = windows.fit.jacobian.copy()
    hardly_shown[:, 6 + own.start : 6 + own.stop] *= 1e-3
    assert not windows.blurred
    assert replace(windows, fit=replace(windows.fit, jacobian=hardly_shown)).blurred
    assert not replace(candidate, fit=replace(candidate.fit, jacobian=hardly_shown)).blurred


def _placed(search, key):
    return next(each for each in search.testable if each.key == key)


def test_what_stands_in_the_place_of_an_effect_that_does_not_takes_it_beside_a_walk(start, search):
    """It stayed, as something is there without it: a drift was named, as without it a gyro seemed late."""
    known = replace(search, known={})
    state = added(known, with_noise(start, 4.0), "viscous_drag:platform")
    assert known.standing(state) is state
    walking = replace(state, scatter=(SimpleNamespace(walks=True),))
    assert [step.placed.key for step in known.standing(walking).steps] == [TRUE]


def test_effects_that_take_each_others_place_do_not_go_on_for_ever(start, search, monkeypatch):
    one = added(search, start, TRUE)
    other = added(search, one, "body_torque:platform")
    seen = []

    def the_other(_, state):
        seen.append(len(state.steps))
        return other if len(state.steps) == 1 else one

    monkeypatch.setattr(Search, "standing", the_other)
    as_it_is = SimpleNamespace(explained=lambda state, **_: state)
    check_residual(one, as_it_is, search)
    assert seen == [1, 2]
