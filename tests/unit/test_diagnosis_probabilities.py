"""Evidence, classes and probabilities of what was compared, and how two effects are found one after the other."""

from __future__ import annotations

from math import log

import numpy as np
import pytest
from scipy.stats import norm

from support.diagnosed_records import nominal, records
from testbed.diagnosis.candidates import NONE, UNKNOWN, by_class, mean_over_scan, probabilities_of
from testbed.diagnosis.method import diagnosed
from testbed.diagnosis.reading import data_set_of
from testbed.diagnosis.settings import SETTINGS
from testbed.diagnosis.size_prior import SizePrior, evidence_of_power
from testbed.dynamics.inertia import theta_of
from testbed.effects.contract import TYPICAL_INERTIA
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


def prior(typical, positive=False):
    size = np.atleast_1d(typical)
    return SizePrior(typical=size, positive=np.full(len(size), positive), searched=np.zeros(len(size), dtype=bool))


def integrated(typical, information, slope, positive):
    """Return 2 ln B of one parameter, its prior integrated over factor and parameter one after the other."""
    places, step = np.linspace(-6.0, 6.0, 601, retstep=True)
    spreads = typical * 10.0 ** (SETTINGS.size_decades * places)
    peak, width = slope / information, information**-0.5
    values = np.linspace(0.0 if positive else peak - 12.0 * width, peak + 12.0 * width, 24_001)
    values = np.where(values == 0.0, 1e-9 * width, values)
    parts = zip(norm.pdf(places), spreads, strict=True)
    prior = sum(weight * norm.pdf(values / spread) / spread for weight, spread in parts)
    likelihood = np.exp(slope * values - 0.5 * information * values**2)
    return 2.0 * np.log(np.trapezoid(likelihood * prior * step * (1.0 + positive), values))


@pytest.mark.parametrize("positive", [False, True])
@pytest.mark.parametrize(("typical", "slope"), [(0.05, 12.0), (0.3, 40.0), (1.0, -8.0)])
def test_evidence_is_the_integral_over_sizes(typical, slope, positive):
    taken = prior(typical, positive).evidence(np.array([[100.0]]), np.array([slope]))
    assert taken == pytest.approx(integrated(typical, 100.0, slope, positive), abs=0.02)


def test_noise_has_a_bayes_factor_of_finite_mean_and_below_one():
    """Of noise it is one in the mean; a maximised size has an infinite mean, and a factor that is never below one.

    Taken over slopes by quadrature: rare ones, of ten standard deviations, make up a tenth of it.
    """
    information, places = 30.0, np.linspace(-30.0, 30.0, 1201)
    evidence = np.array(
        [prior(0.05).evidence(np.array([[information]]), np.sqrt(information) * place) for place in places[None].T]
    )
    assert np.trapezoid(np.exp(0.5 * evidence + norm.logpdf(places)), places) == pytest.approx(1.0, abs=0.02)
    assert np.median(evidence[np.abs(places) < 1.0]) < 0.0


def test_what_data_would_show_many_times_over_is_excluded():
    little, much = (prior(0.1).evidence(np.array([[power]]), np.zeros(1)) for power in (1.0, 1e10))
    assert -0.5 < little < 0.0
    assert much < -10.0


def test_laplace_about_the_fit_is_the_integral_of_a_linear_model():
    information, slope = np.array([[30.0, 10.0], [10.0, 60.0]]), np.array([12.0, 20.0])
    values = np.linalg.solve(information, slope)
    sizes = prior([0.2, 0.1])
    fitted = sizes.evidence_of_fit(float(slope @ values), values, information, np.zeros(2))
    assert fitted == pytest.approx(sizes.evidence(information, slope))
    at_absence = prior(0.2, positive=True).evidence_of_fit(0.0, np.zeros(1), np.array([[30.0]]), np.array([-9.0]))
    assert at_absence == pytest.approx(prior(0.2, positive=True).evidence(np.array([[30.0]]), np.array([-9.0])))


def test_evidence_of_noise_is_that_of_directions_that_are_all_alike():
    sizes = prior([0.1, 0.1, 0.1])
    slope = np.array([8.0, -5.0, 3.0])
    alike = evidence_of_power(float(slope @ slope) / 40.0, 3, 40.0 * 3.0 * 0.1**2)
    assert alike == pytest.approx(sizes.evidence(40.0 * np.eye(3), slope))
    assert evidence_of_power(0.0, 0, 1.0) == 0.0


def test_forces_are_as_large_as_the_platform_is():
    torque, angle = EFFECTS["body_torque"].parameters[0], EFFECTS["gimbal_zero"].parameters[0]
    assert torque.typical_on(0.1 * TYPICAL_INERTIA) == pytest.approx(0.1 * torque.typical)
    assert angle.typical_on(0.1 * TYPICAL_INERTIA) == angle.typical
    _, platform = nominal()
    assert np.trace(platform.inertia) / 3.0 == pytest.approx(TYPICAL_INERTIA, rel=0.05)


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
