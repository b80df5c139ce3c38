"""Hypotheses that are indistinguishable from the best: by evidence; where all models are wrong, by how runs agree."""

from __future__ import annotations

from dataclasses import replace
from math import exp
from types import SimpleNamespace

import numpy as np
import pytest

from testbed.diagnosis.candidates import NONE, Candidate, Screening, accepted, probabilities_of
from testbed.diagnosis.p_values import largest_log_odds
from testbed.diagnosis.settings import SETTINGS, PriorOdds
from testbed.effects.registry import EFFECTS
from testbed.report.diagnosis.ranking import ranking_rows

RUNS = 40


def candidate(evidence, by_run, effect=EFFECTS["gyro_latency"], value=0.01, torque_noise=None):
    return Candidate(
        placed=SimpleNamespace(key=f"{evidence}", size=1, effect=effect, component="gyro"),
        fit=SimpleNamespace(
            chi_square=float(np.sum(by_run)),
            freedom=3 * RUNS,
            placed=(SimpleNamespace(given=False),),
            effect_values=np.full(len(effect.parameters), value),
            own=lambda _: slice(None),
            torque_noise=torque_noise,
        ),
        chi_square_reduction=evidence,
        rank=1,
        trials_penalty=0.0,
        size_penalty=0.0,
        heldout_log_likelihood_gain=0.0,
        log_bayes_factor=evidence,
        by_run=by_run,
        p_value=0.0,
    )


class TestBesideHealthyRecords:
    """What healthy records differ by is part of no evidence, and known worse than which of two fits is better."""

    BEST = replace(candidate(850.0, np.zeros(RUNS)), nothing_new=160.0)

    def beside(self, nothing_new, value=0.01):
        other = candidate(620.0, np.zeros(RUNS), value=value)
        return close(self.BEST, replace(other, nothing_new=nothing_new))

    def test_one_that_explains_as_much_is_of_the_class(self):
        assert self.beside(850.0 + 160.0 - 620.0 - 5.0)

    def test_one_that_explains_less_is_not(self):
        assert not self.beside(850.0 + 160.0 - 620.0 - 7.0)

    def test_nor_is_one_that_no_hardware_has(self):
        assert not self.beside(850.0 + 160.0 - 620.0, value=50.0)

    def test_without_healthy_records_evidence_decides(self):
        assert not close(candidate(850.0, np.zeros(RUNS)), candidate(620.0, np.zeros(RUNS)))


def close(best, other):
    return len(Screening(signatures=(), tested=2, candidates=(best, other)).close) == 2


def test_evidence_tells_two_models_apart_where_one_of_them_is_right():
    left = np.full(RUNS, 3.0)
    other = left + np.random.default_rng(1).normal(1.0, 5.0, RUNS)
    assert not close(candidate(100.0, left), candidate(80.0, other))
    assert close(candidate(100.0, left), candidate(96.0, other))


def test_wrong_models_are_distinguished_by_what_runs_agree_on():
    left = np.full(RUNS, 300.0)
    scattered = left + np.random.default_rng(1).normal(20.0, 200.0, RUNS)
    agreed = left + np.random.default_rng(1).normal(200.0, 200.0, RUNS)
    assert close(candidate(8000.0, left), candidate(6000.0, scattered))
    assert not close(candidate(8000.0, left), candidate(6000.0, agreed))


def test_over_windows_no_model_is_right_however_well_it_fits():
    left = np.full(RUNS, 3.0)
    scattered = left + np.random.default_rng(1).normal(1.0, 5.0, RUNS)
    agreed = left + np.random.default_rng(1).normal(4.0, 5.0, RUNS)
    best = candidate(100.0, left, torque_noise=np.eye(3))
    assert close(best, candidate(70.0, scattered, torque_noise=np.eye(3)))
    assert not close(best, candidate(70.0, scattered, torque_noise=np.eye(3), value=50.0))  # as no hardware has
    assert not close(best, candidate(70.0, agreed, torque_noise=np.eye(3)))


def test_few_runs_do_not_tell_their_scatter():
    left, other = np.full(3, 300.0), np.array([0.0, 900.0, 900.0])
    assert not close(candidate(8000.0, left), candidate(2000.0, other))


def test_of_a_class_the_one_with_the_most_evidence_is_added_if_it_is_there():
    left = np.full(RUNS, 3.0)
    best = replace(candidate(100.0, left), chi_square_reduction=104.0)
    fitting = replace(candidate(97.0, left), chi_square_reduction=109.0)
    farther = replace(candidate(80.0, left + 1.0), chi_square_reduction=200.0)
    among = Screening(signatures=(), tested=2, candidates=(best, fitting, farther))
    assert accepted(among) is best
    implausible = replace(best, placed=SimpleNamespace(**vars(best.placed) | {"effect": EFFECTS["gyro_bandwidth"]}))
    implausible = replace(implausible, fit=SimpleNamespace(**vars(best.fit) | {"effect_values": np.array([0.5])}))
    assert not implausible.plausible
    assert accepted(replace(among, candidates=(implausible, fitting, farther))) is fitting
    assert accepted(replace(among, candidates=(replace(best, p_value=0.5), fitting))) is None


def test_what_is_less_likely_than_that_nothing_is_missing_is_not_added():
    """A priori nothing is missing, more probably than not; effects that are indistinguishable count together."""
    left, tested = np.full(RUNS, 3.0), 50
    even = 2.0 * np.log(SETTINGS.null_prior_odds * tested)
    one, twin = candidate(even - 0.5, left), candidate(even - 0.7, left)
    alone = Screening(signatures=(), tested=tested, candidates=(one,))
    assert one.significant
    assert alone.odds(one) > 0.0
    assert accepted(alone) is None
    assert accepted(replace(alone, candidates=(candidate(even + 0.1, left),))) is not None
    assert accepted(replace(alone, candidates=(one, twin))) is not None
    assert probabilities_of(alone)[NONE] > probabilities_of(alone)[one.key]


def test_a_scenario_may_state_how_often_nothing_is_missing():
    left, tested = np.full(RUNS, 3.0), 50
    one = candidate(2.0 * np.log(3.0 * tested), left)
    usual = Screening(signatures=(), tested=tested, candidates=(one,))
    often = replace(usual, prior_odds=PriorOdds.stated(2.0, None))
    assert accepted(usual) is None
    assert accepted(often) is one
    default, stated = probabilities_of(usual), probabilities_of(often)
    assert stated[NONE] / stated[one.key] == pytest.approx(0.4 * default[NONE] / default[one.key])
    assert often.prior_odds.entries["setting_null_prior_odds"] == "2.0"
    assert often.prior_odds.unmodelled == SETTINGS.unmodelled_prior_odds


def beside_another(one):
    return replace(one, fit=SimpleNamespace(**vars(one.fit) | {"placed": one.fit.placed * 2}))


def test_a_further_name_needs_odds_of_four_over_its_class():
    left, tested = np.full(RUNS, 3.0), 50
    needed = 2.0 * np.log(SETTINGS.further_name_odds * tested)
    likely = beside_another(candidate(needed + 0.1, left))
    doubtful, twin = (beside_another(candidate(needed - less, left)) for less in (0.5, 0.7))
    among = Screening(signatures=(), tested=tested, candidates=(likely,))
    assert accepted(among) is likely
    assert accepted(replace(among, candidates=(doubtful,))) is None
    assert accepted(replace(among, candidates=(doubtful, twin))) is doubtful


def test_what_no_hardware_is_gives_way_to_what_it_looks_like():
    """A gyro of half a hertz fits a slow wheel a little better than the wheel does."""
    left = np.full(RUNS, 3.0)
    gyro = replace(candidate(100.0, left, EFFECTS["gyro_bandwidth"], 0.3), chi_square_reduction=110.0)
    wheel = replace(candidate(99.5, left, EFFECTS["actuator_lag"], 0.3), chi_square_reduction=109.0)
    among = Screening(signatures=(), tested=50, candidates=(gyro, wheel))
    assert accepted(among) is wheel
    prompt = replace(candidate(100.0, left, EFFECTS["gyro_bandwidth"], 0.02), chi_square_reduction=110.0)
    assert accepted(replace(among, candidates=(prompt, wheel))) is prompt


def test_what_is_unusual_yields_to_what_fits_as_well():
    left = np.full(RUNS, 3.0)
    skew = replace(candidate(100.0, left, EFFECTS["telemetry_skew"], -0.01), chi_square_reduction=110.4)
    late = replace(candidate(99.5, left, EFFECTS["gyro_latency"], 0.01), chi_square_reduction=110.0)
    among = Screening(signatures=(), tested=50, candidates=(skew, late))
    assert accepted(among) is late
    better = replace(skew, chi_square_reduction=112.0)
    assert accepted(replace(among, candidates=(better, late))) is better


def test_a_case_of_an_effect_goes_before_it():
    """A weak actuator under constant commands is a constant torque of one free number."""
    left = np.full(RUNS, 3.0)
    torque = replace(candidate(100.0, left, EFFECTS["body_torque"], 1e-4), chi_square_reduction=125.0)
    weak = replace(candidate(98.0, left, EFFECTS["actuator_weak"], 0.2), chi_square_reduction=110.0)
    among = Screening(signatures=(), tested=50, candidates=(torque, weak))
    assert accepted(among) is weak
    worse = replace(weak, log_bayes_factor=100.0 - SETTINGS.indistinguishable - 1.0)
    assert accepted(replace(among, candidates=(torque, worse))) is torque


def test_a_class_that_is_larger_than_what_is_listed_is_ranked():
    """A step back adds a ninth candidate, and effects on the noise push others out: KeyError 'gyro_scale:z'."""
    left = np.full(RUNS, 3.0)
    many = tuple(candidate(100.0 - 0.1 * number, left) for number in range(SETTINGS.most_refits + 2))
    rows = list(ranking_rows(Screening(signatures=(), tested=50, candidates=many)))
    assert len(rows) == SETTINGS.most_refits
    assert rows[0][2] == "1.000"


def test_a_look_alike_that_cannot_be_tested_keeps_its_share():
    left = np.full(RUNS, 3.0)
    one = candidate(100.0, left)
    among = Screening(signatures=(), tested=50, candidates=(one,))
    probability = probabilities_of(among, others={"actuator_lag:untested": one.log_bayes_factor})
    assert probability[one.key] == pytest.approx(0.5, abs=1e-6)


def test_a_p_value_allows_odds_up_to_those_of_sellke_bayarri_and_berger():
    """p = 0.05 bounds the odds against the null hypothesis by 2.46, p = 0.001 by 53 (their table 1)."""
    assert exp(0.5 * largest_log_odds(0.05)) == pytest.approx(1.0 / 0.407, rel=2e-3)
    assert exp(0.5 * largest_log_odds(0.001)) == pytest.approx(1.0 / 0.0188, rel=2e-3)
    assert largest_log_odds(0.5) == 0.0
