"""A gyro's bias that is stated to wander is noise of the gyro, and no effect that a model lacks."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from support.diagnosed_records import NOISE, nominal, records
from testbed.diagnosis.fitting import fitted
from testbed.diagnosis.latent import goodness, latent_torque
from testbed.diagnosis.reading import data_set_of
from testbed.dynamics.inertia import theta_of
from testbed.estimation.slow_bias import SlowBias

WALK = 4e-3
"""rad/s/√s, four times what one second's mean of the noise is known to: as a MEMS gyro's after minutes."""
WANDERING = {"rate_random_walk_rad_s_per_sqrt_s": WALK}


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


def walking(seed):
    """Return records whose gyro's bias walks."""
    rng = np.random.default_rng(1000 + seed)

    def walked(record):
        steps = WALK * np.sqrt(np.diff(record.time, prepend=record.time[0]))[:, None]
        rates = record.channels["body_rate"] + np.cumsum(steps * rng.standard_normal((len(steps), 3)), axis=0)
        return replace(record, channels=record.channels | {"body_rate": rates})

    return [walked(each) for each in records(3, seconds=12.0, seed=seed)]


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
    """Of 6 parameters in 20 sets, in standard deviations: beside a bias that nobody states they are half as wide."""
    truth = theta_of(nominal()[1].inertia)
    errors = {stated: [] for stated in (False, True)}
    for seed in range(10, 30):
        recorded = walking(seed)
        for stated, found in errors.items():
            _, fit = fit_of(recorded, WANDERING if stated else {})
            found.append((fit.theta - truth) / np.sqrt(np.diag(fit.covariance)[:6]))
    assert 0.8 < np.sqrt(np.mean(np.square(errors[True]))) < 1.2
    assert np.sqrt(np.mean(np.square(errors[False]))) > 1.5
