"""The level of the gyro's noise: what readings show of it, against what is stated, and the density of samples in it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import isinf

import numpy as np
import scipy

from testbed.arrays import Array, Theta, Vector3
from testbed.diagnosis.data import Runs
from testbed.diagnosis.fitting import fitted, nominal_fit
from testbed.diagnosis.model import DEPENDENT, Fit
from testbed.diagnosis.settings import SETTINGS
from testbed.dynamics.inertia import inertia_of
from testbed.effects.fast_changes import variance_ratio
from testbed.effects.noise_effect import Readings


@dataclass(frozen=True, kw_only=True)
class NoiseLevel:
    """How the gyro's noise compares with what is stated.

    Attributes:
        ratio: measured over stated standard deviation, shape (3,), per axis; NaN where no run turns about it, or too
            few samples tell.
        std: of the ratio, shape (3,).
        p_value: of the stated noise on all axes, two-sided.
    """

    ratio: Vector3
    std: Vector3
    p_value: float

    @property
    def understated(self) -> bool:
        """Whether there is more noise than stated, by more than chance."""
        return self.p_value < SETTINGS.noise_level_p_value and bool(np.nanmean(self.ratio) > 1.0)

    @property
    def overstated(self) -> bool:
        """Whether there is less, by so much that effects have to be larger to be found."""
        return self.p_value < SETTINGS.noise_level_p_value and bool(np.nanmean(self.ratio) < SETTINGS.overstated_noise)


def noise_level(readings: Readings) -> NoiseLevel:
    """Compare the residual's fourth differences with those of white noise of the stated standard deviation."""
    ratios = [variance_ratio(readings, axis) for axis in np.eye(3, dtype=bool)]
    known = np.array([freedom for _, freedom in ratios]) > 0.0
    if not known.any():
        return NoiseLevel(ratio=np.full(3, np.nan), std=np.full(3, np.nan), p_value=1.0)
    ratio = np.where(known, np.sqrt([variance for variance, _ in ratios]), np.nan)
    freedom = np.where(known, [freedom for _, freedom in ratios], np.nan)
    pairs = zip((freedom * ratio**2)[known], freedom[known], strict=True)
    tails = np.array(
        [2.0 * min(scipy.stats.chi2.cdf(value, own), scipy.stats.chi2.sf(value, own)) for value, own in pairs]
    )
    return NoiseLevel(
        ratio=ratio, std=ratio / np.sqrt(2.0 * freedom), p_value=float(min(1.0, len(tails) * tails.min()))
    )


def readings_of(runs: Runs, fit: Fit) -> Readings:
    """Return what the gyro gave against what a model predicts."""
    return Readings(
        measured=[run.body_rate for run in runs.grid.runs],
        residual=runs.gyro_residual(fit.residual),
        sigma=runs.sigma,
        runs=runs.grid.runs,
        inertia=inertia_of(fit.theta),
        parameters=int((np.diag(fit.normal) > 0.0).sum()),
        stated=isinf(runs.noise_freedom),
        live=runs.live,
    )


def deviance(runs: Runs, fit: Fit, first: int = 0) -> float:
    """Return minus twice the logarithm of the density of the gyro's samples beside a model's parameters.

    That is the restricted likelihood, up to a constant: noise does not show in what the parameters take up, which is no
    evidence against it.

    Source: Patterson and Thompson, "Recovery of inter-block information when block sizes are unequal",
    Biometrika (1971).

    Args:
        runs: with their noise.
        fit: of any model to them.
        first: of the parameters that were fitted to them.
    """
    total = _log_volume(fit.normal[first:, first:])
    for run, (white, sigma, live) in enumerate(zip(runs.by_run(fit.residual), runs.sigma, runs.live, strict=True)):
        scaled = len(white) * np.log(sigma) - runs.log_scale(run)
        total += float((white[:, live] ** 2).sum() + 2.0 * scaled[live].sum())
    return total


def _log_volume(normal: Array) -> float:
    """Return log det of a normal matrix over the directions that the columns span, apart from their scales."""
    shown = np.diag(normal) > 0.0
    scale = np.sqrt(np.diag(normal)[shown])
    strength = np.linalg.eigvalsh(normal[np.ix_(shown, shown)] / np.outer(scale, scale))
    return float(np.log(strength[strength > DEPENDENT * strength[-1]]).sum() + 2.0 * np.log(scale).sum())


def pooled_noise(runs: Runs, theta: Theta) -> tuple[float, float] | None:
    """Return the noise estimated from the samples of all runs together, rad/s, and its degrees of freedom.

    None where they are too few.

    Args:
        runs: all of them.
        theta: to start their fit from, shape (6,), kg·m².
    """
    # All runs get the same weight: noise levels estimated run by run must not decide this fit.
    runs = runs.with_sigma(np.sqrt(np.mean(runs.sigma**2, axis=0)))
    # The fastest changes, from which it is estimated, show no inertia that windows of half-known torque could tell of.
    model = nominal_fit(runs, theta) if runs.known_in_part else fitted(runs, [], theta, [])
    ratio, freedom = variance_ratio(readings_of(runs, model), np.ones(3, dtype=bool))
    return (float(np.sqrt(ratio * np.mean(runs.sigma**2))), freedom) if freedom > 0.0 else None


def with_pooled_noise(runs: Runs, level: tuple[float, float]) -> Runs:
    """Return runs with the noise estimated from the samples; it includes that of the actuators' telemetry.

    Args:
        runs: any of them.
        level: as `pooled_noise`.
    """
    noise, freedom = level
    return replace(
        runs.with_sigma(np.full(3, noise)),
        noise_stated=False,
        noise_freedom=freedom,
        noise_uncertainty=SETTINGS.unstated_noise_uncertainty,
    )
