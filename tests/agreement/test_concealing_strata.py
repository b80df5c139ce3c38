"""Sizes of hidden effects, counted in what a data set can show, and the strata of the score card."""

import json
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import least_squares
from scipy.stats import chi2

from concealing import signature
from concealing.blind_set import Counts, make, orders
from concealing.case import Case, Run, Telemetry
from concealing.effect import HiddenEffect
from concealing.flown import fly_case
from concealing.library import KINDS
from concealing.power import detectable_norm
from concealing.signature import signal
from concealing.sizing import hypotheses, sized
from concealing.strata import random_case
from tests.agreement.test_concealing import SCENARIO

RUNS = (Run(duration=1.5, maneuver=0, planned_spin=(0.2, 0.0, -0.1)), Run(duration=2.0, maneuver=3))
CASE = Case(scenario=SCENARIO, seed=2, runs=RUNS, theta_error=(6e-4, -3e-4, 5e-4, 1e-4, 0.0, 2e-4))


def hidden(effect, component, **parameters):
    return HiddenEffect(effect=effect, component=component, parameters=parameters)


def test_without_effect_nothing_is_left_and_an_inertia_is_no_gap():
    # The predictor's own error at 12.5 ms is 1e-7 rad/s, 1e-4 of sigma a sample.
    assert signal(CASE) < 1e-3
    entries = dict.fromkeys(("dJ11", "dJ22", "dJ33", "dJ23", "dJ13", "dJ12"), 5e-4)
    assert signal(replace(CASE, effects=(hidden("inertia", "platform", **entries),))) < 1e-3


def test_projecting_is_refitting():
    """Inertia and initial rates fitted to noise-free data leave as much as is left when they are projected out."""
    case = replace(CASE, effects=(hidden("gyro_scale", "z", scale_factor_error=0.02),))
    flown = fly_case(case, quiet=True)
    telemetry, start = signature.telemetry_of(flown), flown.log.body_rate[0]

    def left(values):
        inertia = flown.craft.inertia + 1e-4 * (values[:6][[0, 5, 4, 5, 1, 3, 4, 3, 2]].reshape(3, 3))
        rates = signature.predictions(
            telemetry, flown.clock.period, inertia[None, None], (start + 1e-2 * values[6:].reshape(2, 3))[None]
        )
        return signature.sampled(flown, flown.log.gyro - rates[:, 0]) / 0.001658

    fitted = least_squares(left, np.zeros(12), x_scale="jac")
    assert np.sqrt(2.0 * fitted.cost) == pytest.approx(signal(case), rel=0.02)  # the fit is not quite linear
    assert np.linalg.norm(left(np.zeros(12))) > 1.5 * signal(case)  # much of it is taken up


def test_the_signature_of_a_torque_grows_in_proportion():
    drag = dict.fromkeys(KINDS["viscous_drag"].units, 0.0001)
    single = signal(replace(CASE, effects=(hidden("viscous_drag", "platform", **drag),)))
    double = signal(replace(CASE, effects=(hidden("viscous_drag", "platform", **dict.fromkeys(drag, 0.0002)),)))
    assert single > 1.0
    assert double == pytest.approx(2.0 * single, rel=0.02)


def test_a_lag_is_counted_in_what_its_own_gimbal_does_before_any_is_at_its_limit():
    """Behind a limit two flights differ in every gimbal by how long they stayed there, for a lag of 1 ms as well."""
    wild = replace(
        CASE,
        runs=(Run(duration=3.75, maneuver=10, release_error=(0.011, 0.013, -0.011)),),
        theta_error=(9.2e-4, 9.2e-4, 5.5e-4, -2.3e-4, 3.4e-4, -7e-5),
    )
    late = replace(wild, effects=(hidden("gimbal_lag", "cmg2", time_constant=1e-3),))
    flown = fly_case(late, quiet=True)
    assert (np.abs(flown.log.rate_order) >= 2.0).any()
    powers = (signature._servo_signature(flown).reshape(-1, 6) ** 2).sum(axis=0)
    assert powers[1] > 0.8 * powers.sum() > 0.0


def test_the_detectable_norm_has_its_power():
    # One degree of freedom, one test: z(0.975) + z(0.9) but for the other tail.
    assert detectable_norm(1, 1) == pytest.approx(1.960 + 1.2816, abs=1e-3)
    drawn = np.random.default_rng(1).standard_normal((40_000, 3))
    drawn[:, 0] += detectable_norm(3, 77)
    power = ((drawn**2).sum(axis=1) > chi2.isf(0.05 / 77, 3)).mean()
    assert power == pytest.approx(0.9, abs=0.006)  # four standard errors
    assert hypotheses("cmg") == 79


@pytest.mark.parametrize(
    "effect",
    [
        hidden("gimbal_zero", "cmg2", zero=0.02),
        hidden("gyro_bandwidth", "gyro", bandwidth=15.0),
        hidden("gimbal_viscous_friction", "cmg5", coefficient=3e-5),
    ],
)
def test_an_effect_is_made_as_large_as_wanted(effect):
    made, shown = sized(CASE, effect, 12.0)
    assert shown == pytest.approx(12.0, rel=0.1)
    assert signal(replace(CASE, effects=(made,))) == pytest.approx(shown, rel=1e-12)


def test_excess_noise_is_sized_by_its_variance():
    telemetry = Telemetry(gyro_rate=100.0)
    case = replace(CASE, telemetry=telemetry, runs=(Run(duration=2.0, maneuver=0),) * 3)
    loud, _ = sized(case, hidden("gyro_noise", "y", extra_noise=1e-3), 6.0)
    flown = fly_case(replace(case, effects=(loud,)))
    error = flown.log.gyro - flown.log.body_rate
    variance = (error**2).mean(axis=(0, 1)) / flown.sensors.gyro_noise**2
    # 603 samples: a variance is within four times sqrt(2 / 603) = 0.23 of itself.
    assert variance[1] == pytest.approx(1.0 + 6.0 * np.sqrt(2.0 / 600.0), rel=0.23)
    np.testing.assert_allclose(variance[[0, 2]], 1.0, rtol=0.23)


@pytest.mark.parametrize("stratum", ["null", "sigma_understated", "sigma_overstated"])
def test_the_same_numbers_draw_the_same_case(stratum):
    once, again = (random_case(np.random.default_rng(4), stratum, SCENARIO) for _ in range(2))
    assert once == again
    assert once.stratum == stratum
    assert len(once.effects) == (stratum == "sigma_understated")


# The seeds are those of short data sets.
@pytest.mark.parametrize(
    ("stratum", "effect", "count", "seed"),
    [("single", "gimbal_zero", 1, 54), ("pair", "gyro_latency", 2, 13), ("unlisted", "sine_torque", 1, 54)],
)
def test_a_stratum_hides_what_it_says_in_the_size_it_says(stratum, effect, count, seed):
    case = random_case(np.random.default_rng(seed), stratum, SCENARIO, effect)
    assert case.stratum == stratum
    assert case.effects[0].effect == effect
    assert len({each.effect for each in case.effects}) == len(case.effects) == count
    assert all(each.component in KINDS[each.effect].components for each in case.effects)
    if stratum == "unlisted":
        assert case.notes["sigma"] == pytest.approx(case.notes["wanted_sigma"], rel=0.1)


def test_a_set_has_its_shares_in_random_order():
    planned = orders(Counts(), 7)
    shares = Counter(each.stratum for each in planned)
    assert shares["null"] == 200
    assert sum(shares.values()) - shares["flown"] == 800
    assert sum(each.effect is None for each in planned if each.stratum == "flown") == 16
    singles = Counter((each.effect, each.multiple) for each in planned if each.stratum == "single")
    assert len(singles) == 28 * 5
    assert set(singles.values()) == {3}
    assert len({each.stratum for each in planned[:20]}) > 2


def test_a_case_of_a_set_is_made_once(tmp_path):
    (order, *_), folders = orders(Counts(), 7), (tmp_path / "data", tmp_path / "answers")
    order = replace(order, stratum="sigma_understated", effect=None, multiple=None)
    made = make(order, 7, SCENARIO, *folders)
    before = (made / "sealed.sha256").stat().st_mtime_ns
    assert make(order, 7, SCENARIO, *folders) == made
    assert (made / "sealed.sha256").stat().st_mtime_ns == before
    answer = json.loads((folders[1] / made.name / "answer.json").read_text())
    assert answer["effects"][0]["effect"] == "gyro_noise"
    assert answer["gyro_noise_rad_s"] == pytest.approx([0.001658 / 0.8] * 3)
