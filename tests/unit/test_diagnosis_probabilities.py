"""Evidence, classes and probabilities of what was compared, and how two effects are found one after the other."""

from __future__ import annotations

from math import log

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from support.diagnosed_records import nominal, records
from testbed.diagnosis.candidates import NONE, UNKNOWN, by_class, mean_over_scan, probabilities_of, scale_evidence
from testbed.diagnosis.method import diagnosed
from testbed.diagnosis.reading import data_set_of
from testbed.dynamics.inertia import theta_of
from testbed.effects.registry import EFFECTS
from testbed.report.diagnosis.ranking import ranking_rows

FEW = {name: EFFECTS[name] for name in ("gyro_latency", "gyro_bandwidth", "viscous_drag", "rotor_speed", "body_torque")}
LATE = (EFFECTS["gyro_latency"].hooks("gyro"), np.array([8e-3]))
STRONG = (EFFECTS["rotor_speed"].hooks("cmg2"), np.array([0.03]))


def diagnosis(*hidden):
    scenario, platform = nominal()
    hooks, values = [hook for hook, _ in hidden], [value for _, value in hidden]
    data = data_set_of(records(4, hooks=hooks, values=values), scenario, platform)
    (*_, last) = diagnosed(data.runs, data.heldout, FEW, theta_of(platform.inertia))
    return last


@pytest.fixture(scope="module")
def late():
    return diagnosis(LATE)


def class_of(found):
    return [candidate.key for candidate in found.steps[0].screening.close]


@pytest.mark.parametrize(("square", "freedom"), [(12.0, 1), (40.0, 3), (900.0, 5)])
def test_evidence_is_the_likelihood_ratio_at_the_best_scale(square, freedom):
    worst = minimize_scalar(
        lambda scale: freedom * np.log1p(np.exp(scale)) - square / (1.0 + np.exp(-scale)), bounds=(-20, 20)
    )
    assert scale_evidence(square, freedom) == pytest.approx(-worst.fun, rel=1e-6)


def test_what_is_too_small_to_be_seen_is_not_excluded():
    assert scale_evidence(2.0, 3) == scale_evidence(0.0, 0) == 0.0


def test_odds_of_what_is_sought_at_many_places_are_their_mean():
    everywhere = [2.0 * np.log(odds) for odds in (500.0, 20.0, 4.0)]
    assert mean_over_scan(everywhere[0], everywhere[1:], 100) == pytest.approx(2.0 * np.log((524.0 + 97.0) / 100))
    assert mean_over_scan(everywhere[0], [], 1) == pytest.approx(everywhere[0])
    nowhere = mean_over_scan(-40.0, [0.0] * 99, 100)
    assert nowhere == pytest.approx(2.0 * np.log(0.99), abs=1e-3), "one place that is excluded leaves the others"


def test_probabilities_sum_to_one_with_and_without_classes(late):
    screening = late.steps[0].screening
    apart = probabilities_of(screening, unmodelled=3.0)
    assert sum(apart.values()) == pytest.approx(1.0)
    together = by_class(apart, class_of(late))
    assert sum(together.values()) == pytest.approx(1.0)
    (name, *_) = together
    assert set(name.split("|")) == {candidate.placed.key for candidate in screening.close}


def test_odds_are_those_of_the_evidence(late):
    screening = late.steps[0].screening
    best, second = screening.candidates[:2]
    apart = probabilities_of(screening)
    odds = log(apart[best.placed.key] / apart[second.placed.key])
    assert odds == pytest.approx(0.5 * (best.log_bayes_factor - second.log_bayes_factor))


def test_a_late_gyro_is_named_and_bandwidth_beside_it(late):
    assert late.steps[0].placed.effect.id in {"gyro_latency", "gyro_bandwidth"}
    assert len(late.steps) == 1
    assert not late.left_over


def test_two_effects_are_found_one_after_the_other_and_nothing_else():
    last = diagnosis(LATE, STRONG)
    found = {step.placed.effect.id for step in last.steps}
    assert "rotor_speed" in found
    assert len(last.steps) == 2
    assert last.gap.heldout < 1.1
    probability = last.probabilities
    assert max(probability, key=lambda key: probability[key]) not in {NONE, UNKNOWN}


def test_nothing_is_said_of_nothing():
    last = diagnosis()
    assert last.verdict == "none"
    assert max(last.probabilities, key=last.probabilities.get) == NONE


def test_a_class_is_ranked_with_one_probability(late):
    screening = late.steps[0].screening
    rows = list(ranking_rows(screening))
    assert len(rows) == len(screening.candidates)
    members = [row for row in rows if row[2] == "same class"]
    assert len(members) == len(screening.close) - 1 > 0
    numbers = [float(row[2]) for row in rows if row not in members]
    together = by_class(probabilities_of(screening), class_of(late))
    assert numbers[0] == pytest.approx(next(iter(together.values())), abs=1e-3)
