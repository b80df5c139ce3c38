"""Level and colour of noise, estimated from a residual's fast part; whitening with them, and back."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter
from scipy.stats import multivariate_normal

from testbed.estimation.noise_color import NoiseColor
from testbed.estimation.noise_spectrum import SpectrumPrior, noise_spectrum
from testbed.sensors.noise import autoregression

PRIOR = SpectrumPrior(
    level=0.2,
    deviation=0.2,
    correlation=0.3,
    correlation_deviation=0.1,
    persistence=0.5,
    color=0.5,
    slowest=2.0,
    share_of_rate=0.25,
    most_power=4.0,
)
RATE = 16.0
LENGTHS = (80, 56, 32, 63, 39, 59)
"""Samples of six runs, 20 s together: what a data set of the blind cases has."""
SETS = 40


def sets(correlation=0.0, levels=None, slow=0.0, hum=0.0, hum_hz=3.1):
    """Yield the spectra of sets of residuals, each with its seed."""
    for seed in range(SETS):
        rng = np.random.default_rng(seed)
        runs = [autoregression(correlation, rng.standard_normal((length + 50, 3)))[50:] for length in LENGTHS]
        if levels is not None:
            runs = [level * run for level, run in zip(levels, runs, strict=True)]
        times = [np.arange(length) / RATE for length in LENGTHS]
        runs = [run + slow * np.sin(2.0 * np.pi * 0.7 * time)[:, None] for run, time in zip(runs, times, strict=True)]
        phases = rng.uniform(0.0, 2.0 * np.pi, (len(runs), 3))
        waves = [np.sin(2.0 * np.pi * hum_hz * time[:, None] + own) for time, own in zip(times, phases, strict=True)]
        runs = [run + hum * wave for run, wave in zip(runs, waves, strict=True)]
        yield noise_spectrum(runs, times, PRIOR)


@pytest.mark.parametrize("correlation", [-0.5, -0.2, 0.0, 0.2, 0.5])
def test_the_correlation_of_neighbouring_samples_is_estimated_within_its_standard_error(correlation):
    found = list(sets(correlation))
    errors = np.array([(each.correlation - correlation) / each.correlation_std for each in found])
    assert abs(errors.mean()) < 1.0  # the prior draws it to zero
    assert errors.std() < 1.3


def test_white_noise_as_stated_stays_nearly_white_and_nearly_as_stated():
    found = list(sets())
    assert np.mean([np.abs(each.color.correlation).max() for each in found]) < 0.05
    assert np.mean([each.variance_ratio for each in found]) == pytest.approx(1.0, abs=0.03)
    assert np.median([each.freedom for each in found]) > 200.0


def test_a_level_that_is_stated_wrong_in_one_run_is_estimated():
    levels = (1.0, 1.2, 1.0, 0.8, 1.0, 1.0)
    ratio = np.mean([each.variance_ratio for each in sets(levels=levels)], axis=(0, 2))
    assert 1.1 < ratio[1] < 1.45
    assert 0.6 < ratio[3] < 0.9


def test_what_is_slow_is_taken_neither_for_a_level_nor_for_a_colour():
    plain, moved = list(sets()), list(sets(slow=3.0))
    assert np.mean([each.variance_ratio for each in moved]) < 1.05 * np.mean([each.variance_ratio for each in plain])
    assert np.mean([abs(each.correlation) for each in moved]) < 0.1


@pytest.mark.parametrize("hum_hz", [3.1, 5.0])
def test_a_hum_is_taken_neither_for_a_level_nor_for_a_colour(hum_hz):
    """Of half the noise's power: the level had doubled, or risen by a third, and the correlation to 0.34 and 0.22."""
    plain, humming = list(sets()), list(sets(hum=1.0, hum_hz=hum_hz))
    assert np.mean([each.variance_ratio for each in humming]) < 1.1 * np.mean([each.variance_ratio for each in plain])
    assert np.mean([abs(each.correlation) for each in humming]) < 0.1


def test_what_is_no_noise_of_this_gyro_is_left_alone():
    rng = np.random.default_rng(4)
    assert noise_spectrum([3.0 * rng.standard_normal((200, 3))], [np.arange(200) / RATE], PRIOR) is None


def test_nothing_is_estimated_from_too_few_samples():
    assert noise_spectrum([np.ones((6, 3))], [np.arange(6) / RATE], PRIOR) is None


def test_axes_that_a_bearing_holds_say_nothing_of_the_noise():
    """Zeros had passed for a level far below the stated one, and the readings there for a colour of the others."""
    live = np.tile([False, False, True], (len(LENGTHS), 1))
    times = [np.arange(length) / RATE for length in LENGTHS]
    errors = []
    for seed in range(SETS):
        rng = np.random.default_rng(seed)
        runs = [autoregression(0.4, rng.standard_normal((length + 50, 3)))[50:] for length in LENGTHS]
        held, empty = (noise_spectrum([run * on for run in runs], times, PRIOR, live) for on in (1.0, live[0]))
        assert (held.correlation, held.correlation_std) == (empty.correlation, empty.correlation_std)
        assert held.freedom == empty.freedom
        np.testing.assert_array_equal(held.variance_ratio, empty.variance_ratio)
        assert np.isfinite(held.color.correlation).all()
        errors.append((held.correlation - 0.4) / held.correlation_std)
    assert abs(np.mean(errors)) < 1.0  # the prior draws it to zero
    assert np.std(errors) < 1.3


COLORS = {
    "an autoregression": ((0.5, -0.4, 0.0), (0.0, 0.0, 0.0)),
    "a slow part in white noise": ((0.9, 0.8, -0.7), (-0.6, -0.5, 0.3)),
    "means of neighbours": ((0.0, 0.0, 0.3), (0.5, -0.5, 0.6)),
}


def colored(color, number, seed):
    """Samples of unit variance, an ARMA(1,1) by its definition."""
    white = np.random.default_rng(seed).standard_normal((number + 200, 3))
    samples = np.column_stack(
        [
            lfilter([1.0, average], [1.0, -persistence], each)
            for persistence, average, each in zip(color.persistence, color.average, white.T, strict=True)
        ]
    )[200:]
    return samples / np.sqrt(1.0 + (color.persistence + color.average) ** 2 / (1.0 - color.persistence**2))


def named(name):
    persistence, average = COLORS[name]
    return NoiseColor(persistence=np.array(persistence), average=np.array(average))


@pytest.mark.parametrize("name", COLORS)
def test_whitened_noise_is_white_and_has_its_colour_again_across_gaps(name):
    kept = np.random.default_rng(1).random(8000) > 0.1
    time = np.arange(8000.0)[kept] / RATE
    samples = colored(named(name), 8000, 7)[kept]
    white = named(name).decorrelated(samples, time)
    assert white.var(axis=0) == pytest.approx(np.ones(3), abs=0.08)
    for apart in (1, 2, 5):
        assert np.mean(white[apart:] * white[:-apart], axis=0) == pytest.approx(np.zeros(3), abs=0.05)
    np.testing.assert_allclose(named(name).correlated(white, time), samples, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(white[0], samples[0])


@pytest.mark.parametrize("name", COLORS)
def test_the_correlation_of_neighbours_is_that_of_the_samples(name):
    samples = colored(named(name), 40000, 8)
    assert np.mean(samples[1:] * samples[:-1], axis=0) == pytest.approx(named(name).correlation, abs=0.03)


@pytest.mark.parametrize(
    ("persistence", "average"),
    [
        pytest.param(0.7, -0.4, id="a slow part in white noise"),
        pytest.param(0.0, 0.5, id="a mean of two samples"),
        pytest.param(0.0, -0.5, id="a difference of two samples"),
        pytest.param(0.6, 0.3, id="a filter of second order"),
    ],
)
def test_a_colour_of_two_parameters_is_found(persistence, average):
    """In sets of 20 s: whitened by it they are nearly white; an autoregression leaves up to 0.19 at two samples."""
    true = NoiseColor(persistence=np.full(3, persistence), average=np.full(3, average))
    apart, left, errors = [], [], []
    for seed in range(SETS):
        runs = [colored(true, length, 100 * seed + index) for index, length in enumerate(LENGTHS)]
        times = [np.arange(length) / RATE for length in LENGTHS]
        found = noise_spectrum(runs, times, replace(PRIOR, slowest=0.5))
        errors.append((found.correlation - true.correlation[0]) / found.correlation_std)
        apart.append(found.color.correlation - true.correlation)
        white = [found.color.decorrelated(run, time) for run, time in zip(runs, times, strict=True)]
        left.append([np.mean(np.concatenate([run[lag:] * run[:-lag] for run in white])) for lag in (1, 2, 3)])
    assert np.abs(np.mean(apart)) < 0.08
    assert np.mean(left, axis=0) == pytest.approx(np.zeros(3), abs=0.09)
    assert abs(np.mean(errors)) < 1.3
    assert np.std(errors) < 1.5


def test_columns_are_whitened_as_samples_are():
    time, color = np.arange(30) / RATE, named("a slow part in white noise")
    columns = np.random.default_rng(2).standard_normal((30, 3, 4))
    together = color.decorrelated(columns, time)
    for index in range(4):
        np.testing.assert_allclose(together[..., index], color.decorrelated(columns[..., index], time))


@pytest.mark.parametrize("name", COLORS)
def test_the_density_of_samples_is_that_of_their_joint_normal_distribution(name):
    kept = np.sort(np.random.default_rng(3).choice(60, 40, replace=False))
    color, time = named(name), kept / RATE
    samples = colored(color, 60, 9)[kept]
    white = color.decorrelated(samples, time)
    logarithm = -0.5 * (white**2).sum(axis=0) - 20.0 * np.log(2.0 * np.pi) + color.log_scale(time)
    lags = np.abs(kept[:, None] - kept)
    for axis in range(3):
        after = color.correlation[axis] * color.persistence[axis] ** np.maximum(lags - 1.0, 0.0)
        covariance = np.where(lags == 0, 1.0, np.where(lags == 1, color.correlation[axis], after))
        expected = multivariate_normal(cov=covariance).logpdf(samples[:, axis])
        assert logarithm[axis] == pytest.approx(expected, abs=1e-8)
