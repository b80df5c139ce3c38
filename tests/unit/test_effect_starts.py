"""Where searches for contacts and modes begin: near enough to what was there to be led to it."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from support.synthetic_telemetry import TRUE_THETA, exact_telemetry, nominal_flight, sample_times
from testbed.arrays import Array
from testbed.diagnosis.data import Runs, runs_of
from testbed.diagnosis.fitting import fitted
from testbed.diagnosis.model import Fit, Hypothesis
from testbed.diagnosis.signatures import Signature, signatures
from testbed.diagnosis.testable import hypotheses
from testbed.dynamics.inertia import inertia_of
from testbed.effects.registry import EFFECTS
from testbed.estimation.telemetry import GimbalTelemetry, Telemetry
from testbed.prediction.grid import PAUSE
from testbed.prediction.integration import Values
from testbed.prediction.prediction import predicted

SIGMA = 0.001658


@cache
def plain() -> tuple[Telemetry, ...]:
    times = sample_times(200.0)
    run = exact_telemetry(nominal_flight(np.array([0.003, -0.004, 0.006])), sample_times(16.0), times)
    return replace(run, gyro_noise=SIGMA), replace(
        run, gyro_noise=SIGMA, gyro_time=run.gyro_time[:48], body_rate=run.body_rate[:48]
    )


def hidden(effect: str, sizes: Array) -> tuple[Runs, Fit]:
    """Runs that show an effect, with noise, and their fit without it."""
    runs = runs_of(["long", "short"], plain())
    first = np.stack([rates[0] for rates in runs.measured])[:, None]
    values = Values(theta=TRUE_THETA[None], initial_rate=first, effects=(sizes[None],))
    shown = predicted(runs.grid, [EFFECTS[effect].hooks("platform")], values)
    rng = np.random.default_rng(5)
    telemetry = [
        replace(run, body_rate=rates[0] + rng.normal(0.0, SIGMA, rates[0].shape))
        for run, rates in zip(plain(), shown, strict=True)
    ]
    noisy = runs_of(["long", "short"], telemetry)
    return noisy, fitted(noisy, [], TRUE_THETA, [])


def searched(runs: Runs, base: Fit, effect: str) -> tuple[Signature, Fit]:
    """The start that explains the most, and the fit that it leads to."""
    placed = Hypothesis(effect=EFFECTS[effect], component="platform")
    best = max(signatures(runs, base, [placed]), key=lambda each: each.score)
    lower, upper = placed.bounds
    return best, fitted(runs, [placed], base.theta, [np.clip(best.start + best.step, lower, upper)])


@pytest.mark.parametrize(
    ("effect", "sizes"),
    [
        ("flexible_appendage", [1.5, 0.05, 2.4e-3, -1.6e-3, 8e-4]),
        ("slosh", [0.9, 0.1, 0.05, -0.03, 0.05]),
    ],
)
def test_modes_are_found_between_the_frequencies_of_the_scan(effect, sizes):
    runs, base = hidden(effect, np.array(sizes))
    best, fit = searched(runs, base, effect)
    assert best.rank == 3  # of a speck neither frequency nor damping shows
    freedom = fit.freedom
    assert abs(fit.chi_square - freedom) < 4.0 * np.sqrt(2.0 * freedom)
    found = fit.effect_values * np.sign(fit.effect_values[2] * sizes[2])  # an axis has no sign
    found[:2] = fit.effect_values[:2]
    error = (found - sizes) / np.sqrt(np.diag(fit.covariance))[6:]
    assert np.abs(error).max() < 4.0  # of five normal numbers; 3e-4 by chance


@pytest.mark.parametrize("effect", ["flexible_appendage", "slosh"])
@pytest.mark.parametrize(("rate", "fastest"), [(16.0, 0.0), (2.0, 2.0)])
def test_modes_faster_than_the_gyro_samples_are_not_looked_for(effect, rate, fastest):
    every = EFFECTS[effect].starts("platform", runs_of(["long", "short"], plain()).grid)[:, 0]
    slow = [run.with_gyro_rows(slice(None, None, round(16.0 / rate))) for run in plain()]
    found = EFFECTS[effect].starts("platform", runs_of(["long", "short"], slow).grid)[:, 0]
    assert found.min() == every.min()
    assert found.max() == pytest.approx(fastest or every.max())


def slow(seconds: float) -> tuple[Telemetry]:
    """One run whose gimbals swing slowly, a gyro at 4 Hz that has read nothing yet."""
    gyro = nominal_flight(np.array([0.003, -0.004, 0.006])).cluster
    time = np.arange(0.0, seconds, 0.25)
    waves = [np.sin(2.0 * np.pi * (0.03 + 0.02 * unit) * time + unit) for unit in range(6)]
    return (
        Telemetry(
            gyro_time=time,
            body_rate=np.zeros((len(time), 3)),
            gyro_noise=SIGMA,
            actuator_time=time,
            gimbals=GimbalTelemetry(cluster=gyro, angle=0.3 * np.stack(waves, axis=1)),
        ),
    )


@pytest.mark.parametrize(("seconds", "slowest"), [(50.0, 0.3), (200.0, 0.09)])
def test_slower_modes_are_looked_for_in_runs_of_minutes(seconds, slowest):
    runs = runs_of(["long"], slow(seconds))
    for effect in ("flexible_appendage", "slosh"):
        assert EFFECTS[effect].starts("platform", runs.grid)[:, 0].min() == pytest.approx(slowest, rel=0.01)
    testable, _ = hypotheses(runs, {"slosh": EFFECTS["slosh"]})
    assert testable[0].bounds[0][0] == pytest.approx(min(0.2, 12.0 / seconds), rel=0.01)


def test_a_mode_of_ten_seconds_is_found_in_a_run_of_minutes():
    sizes = np.array([0.1, 0.05, 2.4e-3, -1.6e-3, 8e-4])
    quiet = runs_of(["long"], slow(200.0))
    (placed,), _ = hypotheses(quiet, {"flexible_appendage": EFFECTS["flexible_appendage"]})
    values = Values(theta=TRUE_THETA[None], initial_rate=np.zeros((1, 1, 3)), effects=(sizes[None],))
    (shown,) = predicted(quiet.grid, [placed.hooks], values)
    rates = shown[0] + np.random.default_rng(5).normal(0.0, SIGMA, shown[0].shape)
    runs = runs_of(["long"], [replace(slow(200.0)[0], body_rate=rates)])
    base = fitted(runs, [], TRUE_THETA, [])
    best = max(signatures(runs, base, [placed]), key=lambda each: each.score)
    fit = fitted(runs, [placed], base.theta, [best.start + best.step])
    assert fit.effect_values[0] == pytest.approx(0.1, abs=4.0 * np.sqrt(fit.covariance[6, 6]))
    assert np.sqrt(fit.covariance[6, 6]) < 0.005
    assert abs(fit.chi_square - fit.freedom) < 4.0 * np.sqrt(2.0 * fit.freedom)


def test_a_contact_is_found_in_the_run_in_which_it_was():
    spans = np.ptp(runs_of(["long", "short"], plain()).grid.time, axis=1)
    at = spans[0] + PAUSE + 1.83  # in the second run
    runs, base = hidden("contact", np.array([at, 2e-4, -1e-4, 3e-4]))
    best, fit = searched(runs, base, "contact")
    assert abs(best.start[0] - at) < 1.5 / 16.0  # s: the samples beside the touch
    assert abs(fit.effect_values[0] - at) < 1.5 / 16.0
    error = (fit.effect_values[1:] - [2e-4, -1e-4, 3e-4]) / np.sqrt(np.diag(fit.covariance))[7:]
    assert np.abs(error).max() < 4.0


@pytest.mark.parametrize("rate", [50.0, 100.0])
def test_a_fast_gyro_shows_a_short_touch(rate):
    """What a bell of 0.02 s leaves of 20 ms, χ² of 1.9 and 1.5 for each sample, was taken for a noisier gyro."""
    time, impulse = np.arange(0.0, 6.0, 1.0 / rate), np.array([6e-4, -4e-4, 2e-4])
    jump = np.clip((time - 3.0) / 0.02, 0.0, 1.0)[:, None] * impulse / 0.03  # of a sphere that nothing else turns
    still = np.zeros((len(time), 3))
    touched = Telemetry(
        gyro_time=time,
        body_rate=jump + np.random.default_rng(11).normal(0.0, 4e-4, still.shape),
        gyro_noise=4e-4,
        actuator_time=time,
        gimbals=None,
        cluster_momentum=still + np.array([1e-9, 0.0, 0.0]),
    )
    runs = runs_of(["touched"], [touched])
    sphere = np.array([0.03, 0.03, 0.03, 0.0, 0.0, 0.0])
    placed = Hypothesis(effect=EFFECTS["contact"], component="platform")
    fit = fitted(runs, [placed], sphere, [np.array([3.0, *impulse])])
    assert fit.chi_square < 1.2 * fit.freedom
    np.testing.assert_allclose(np.linalg.solve(inertia_of(fit.theta), fit.effect_values[1:]), impulse / 0.03, rtol=0.05)


def test_a_contact_is_looked_for_at_instants_that_are_not_the_same():
    runs, _ = hidden("contact", np.zeros(4))
    instants = np.sort(EFFECTS["contact"].starts("platform", runs.grid)[:, 0])
    assert len(instants) == 8
    assert np.diff(instants).min() > 0.2  # s
