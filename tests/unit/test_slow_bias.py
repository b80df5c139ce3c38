"""A gyro's bias that is stated to wander is noise of the gyro, and no effect that a model lacks."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from support.diagnosed_records import NOISE, nominal, records
from testbed.diagnosis.fitting import fitted
from testbed.diagnosis.latent import goodness, latent_torque
from testbed.diagnosis.method import diagnosed
from testbed.diagnosis.model_notices import model_notices
from testbed.diagnosis.reading import data_set_of
from testbed.dynamics.inertia import theta_of
from testbed.effects.registry import EFFECTS, NOISE_EFFECTS
from testbed.estimation.slow_bias import SlowBias
from testbed.experiment.measured import estimate_record

WALK = 4e-3
"""rad/s/√s, four times what one second's mean of the noise is known to: as a MEMS gyro's after minutes."""
WALKS = "rate_random_walk_rad_s_per_sqrt_s"
WANDERING = {WALKS: WALK}


@pytest.mark.parametrize(
    "bias",
    [
        SlowBias(instability=1e-4, correlation_time=20.0, random_walk=2e-5),
        SlowBias(instability=1e-4),
        SlowBias(instability=0.0, random_walk=1e-5),
    ],
)
def test_samples_are_whitened_by_the_covariance_of_the_process(bias):
    """Against the Cholesky factor of the covariance, over uneven times."""
    rng = np.random.default_rng(1)
    time, sigma = np.sort(rng.uniform(0.0, 100.0, 300)), np.array([2e-4, 1e-4, 3e-4])
    values = rng.standard_normal((300, 3, 2))
    walked = bias.random_walk**2 * (np.minimum.outer(time, time) - time[0])
    wandered = bias.instability**2 * np.exp(-np.abs(np.subtract.outer(time, time)) / bias.correlation_time)
    white = bias.whitened(values, time, sigma)
    for axis in range(3):
        factor = np.linalg.cholesky((walked + wandered) / sigma[axis] ** 2 + np.eye(300))
        np.testing.assert_allclose(white[:, axis], np.linalg.solve(factor, values[:, axis]), atol=1e-11)
    np.testing.assert_allclose(bias.wandering(white, time, sigma), values, atol=1e-12)
    np.testing.assert_array_equal(bias.whitened(values[..., 0], time, sigma), white[..., 0])


def test_filters_have_their_transposes():
    """Of <F x, y> = <x, Fᵀ y>, for the filter and for its inverse."""
    rng = np.random.default_rng(2)
    bias = SlowBias(instability=1e-4, correlation_time=20.0, random_walk=2e-5)
    time, sigma = np.sort(rng.uniform(0.0, 100.0, 300)), np.array([2e-4, 1e-4, 3e-4])
    one, other = rng.standard_normal((2, 300, 3))
    for there, back in (
        (bias.whitened, bias.whitened_back),
        (bias.wandering, bias.wandering_back),
    ):
        assert np.vdot(there(one, time, sigma), other) == pytest.approx(np.vdot(one, back(other, time, sigma)))


def walking(seed, walk=WALK, count=3, hooks=(), values=()):
    """Return records whose gyro's bias walks."""
    rng = np.random.default_rng(1000 + seed)

    def walked(record):
        steps = walk * np.sqrt(np.diff(record.time, prepend=record.time[0]))[:, None]
        rates = record.channels["body_rate"] + np.cumsum(steps * rng.standard_normal((len(steps), 3)), axis=0)
        return replace(record, channels=record.channels | {"body_rate": rates})

    return [walked(each) for each in records(count, seconds=12.0, seed=seed, hooks=hooks, values=values)]


def fit_of(recorded, stated):
    scenario, platform = nominal()
    scenario = scenario.model_copy(update={"gyro": scenario.gyro.model_copy(update=stated)})
    runs = data_set_of(recorded, scenario, platform).runs
    return runs, fitted(runs, [], theta_of(platform.inertia), [])


@pytest.mark.parametrize("seed", range(3))
def test_a_bias_that_walks_as_stated_is_no_unmodelled_torque(seed):
    recorded = walking(seed)
    unstated = fit_of(recorded, {})
    assert latent_torque(*unstated).p_value < 1e-6
    runs, fit = fit_of(recorded, WANDERING)
    assert goodness(fit, runs.noise_freedom) > 0.01
    assert latent_torque(runs, fit).p_value > 0.01


@pytest.mark.parametrize("seed", range(3))
def test_the_residual_is_in_the_gyros_unit_again(seed):
    runs, fit = fit_of(walking(seed), WANDERING)
    (first, *_), (rate, *_) = runs.gyro_residual(fit.residual), runs.measured
    assert first.shape == rate.shape
    assert np.std(np.diff(first, axis=0)) == pytest.approx(np.sqrt(2.0 * NOISE**2 + WALK**2 / 16.0), rel=0.1)


def test_intervals_of_the_inertia_hold_it_beside_a_bias_that_walks():
    """Of 6 parameters in 12 sets, in standard deviations: beside a bias that nobody states they are half as wide."""
    truth = theta_of(nominal()[1].inertia)
    errors = {stated: [] for stated in (False, True)}
    for seed in range(10, 22):
        recorded = walking(seed)
        for stated, found in errors.items():
            _, fit = fit_of(recorded, WANDERING if stated else {})
            found.append((fit.theta - truth) / np.sqrt(np.diag(fit.covariance)[:6]))
    assert 0.8 < np.sqrt(np.mean(np.square(errors[True]))) < 1.2
    assert np.sqrt(np.mean(np.square(errors[False]))) > 1.5


def test_estimators_take_a_stated_walk_off_and_find_their_residual_white():
    scenario, platform = nominal()
    (recorded, *_) = walking(8, 2e-3)
    stated = scenario.model_copy(update={"gyro": scenario.gyro.model_copy(update={WALKS: 2e-3})})
    unstated, known = (estimate_record(each, platform, recorded).checks.residual for each in (scenario, stated))
    assert unstated.whiteness_p_value < 1e-6
    assert known.whiteness_p_value > 0.01
    assert known.size_p_value > 0.01


SLOW = {name: EFFECTS[name] for name in ("gyro_drift", "gyro_bias", "body_torque", "viscous_drag", "gyro_scale")}
"""What a walk may pass for; all effects take four times as long."""


def diagnosis_of(recorded, effects=SLOW, stated=None):
    scenario, platform = nominal()
    scenario = scenario.model_copy(update={"gyro": scenario.gyro.model_copy(update=stated or {})})
    data = data_set_of(recorded, scenario, platform)
    theta = theta_of(platform.inertia)
    *_, last = diagnosed(data.runs, data.heldout, effects, theta, lambda _: None, NOISE_EFFECTS)
    return last


def error_of(found, walk):
    """Return how far the size of a walk is from the truth, in its standard errors."""
    size, std = found.size
    return (size - walk) / std


@pytest.mark.parametrize(("seed", "walk"), [(40, WALK), (42, 5e-4)])
def test_a_walk_that_nobody_states_is_named_alone_and_the_inertia_holds(seed, walk):
    """From a walk that after 12 s is as large as the noise of one sample on."""
    slow = {name: SLOW[name] for name in ("gyro_drift", "gyro_bias", "viscous_drag")}
    last = diagnosis_of(walking(seed, walk), slow)
    (found,) = last.added
    assert (last.verdict, found.key) == ("named", "gyro_rate_random_walk:gyro")
    assert abs(error_of(found, walk)) < 3.0
    errors = (last.model.theta - theta_of(nominal()[1].inertia)) / np.sqrt(np.diag(last.model.covariance)[:6])
    assert np.abs(errors).max() < 4.0


@pytest.mark.parametrize("seed", [72, 77])
def test_what_a_walk_passes_for_gives_way_to_it(seed):
    """Of these a formula and a touch had been named (looked at); what was added on the way is said to be out again."""
    last = diagnosis_of(walking(seed, 2.5e-4, count=5), {name: EFFECTS[name] for name in ("gyro_drift", "contact")})
    (found,) = last.added
    assert found.key == "gyro_rate_random_walk:gyro"
    assert last.given_up
    assert any("out again" in words for words in model_notices(last))


def test_a_walk_is_named_beside_an_effect_on_the_motion():
    drag = EFFECTS["viscous_drag"]
    last = diagnosis_of(walking(44, 1e-3, 5, [drag.hooks("platform")], [np.full(3, 1e-3)]), {drag.id: drag})
    assert [each.key for each in last.added] == ["viscous_drag:platform", "gyro_rate_random_walk:gyro"]
    assert abs(error_of(last.added[1], 1e-3)) < 3.0


@pytest.mark.parametrize("seed", [50, 51])
def test_records_without_a_walk_get_no_such_name(seed):
    last = diagnosis_of(records(5, seconds=12.0, seed=seed))
    assert last.verdict == "none"
    (walk,) = (each for each in last.noise_candidates if each.finding.slow_bias is not None)
    assert walk.odds < 0.0


def test_a_walk_too_small_for_a_name_is_mentioned_where_the_residual_is_more_than_noise():
    """Among all hypotheses it is no more than chance, but it leaves nothing."""
    last = diagnosis_of(walking(69, 1.5e-4, count=5), EFFECTS)
    assert last.verdict == "unexplained"
    assert any("rate_random_walk_rad_s_per_sqrt_s" in words for words in model_notices(last))


def test_a_stated_walk_is_not_looked_for():
    last = diagnosis_of(walking(62, count=5), {}, WANDERING)
    assert not any(each.finding.slow_bias for each in last.noise_candidates)


def test_a_walk_is_named_beside_an_instability_that_is_stated():
    """As data sheets give the one alone: a walk of the noise in a second beside a hundredth that comes back."""
    stated = {"bias_instability_rad_s": 0.01 * NOISE, "bias_correlation_time_s": 100.0}
    last = diagnosis_of(walking(63, 1e-3, count=5), {}, stated)
    (found,) = last.added
    assert abs(error_of(found, 1e-3)) < 3.0
    assert found.finding.slow_bias.instability == stated["bias_instability_rad_s"]
