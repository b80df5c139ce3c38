"""The gyro's bias walks at random during a run."""

from __future__ import annotations

from dataclasses import replace
from math import inf
from typing import final

import numpy as np
import scipy
from typing_extensions import override

from testbed.arrays import Array, Series
from testbed.effects.contract import Extension, Parameter
from testbed.effects.noise_effect import Finding, NoiseEffect, Readings
from testbed.estimation.random_walk import Increments, likeliest_variance, relative_error
from testbed.estimation.slow_bias import SlowBias
from testbed.scenario.scenario import Scenario

_MOST_KNOTS = 200
"""At which the bias of a run steps, at each sample where there are fewer. Over one step of a run of T the walk is less
than what the mean of its samples tells, of walks up to 200 σ √dt / T: of 60 s at 100 Hz, a third of σ in a second."""
_DEPENDENT = 1e-10
"""Share of the strongest direction of the parameters below which one is none of its own: rounding leaves 1e-14."""


@final
class GyroRateRandomWalk(NoiseEffect):
    """ω̄ = ω + b, b a random walk of K √t, from nothing at the first sample of each run, about each axis alike.

    K is the likeliest one beside all that the model's parameters can make of the samples, where the residual may be
    noise alone; every test is on samples from which the walk is taken off. Not tested where the scenario states a walk,
    nor over windows, which are short.

    Source: IEEE Std 952, appendix B (rate random walk).
    """

    id = "gyro_rate_random_walk"
    components = ("gyro",)
    parameters = (Parameter(name="rate_random_walk_rad_s_per_sqrt_s", unit="rad/s/√s", typical=1e-4, lower=0.0),)
    sentence = "The bias of {component} walks at random."
    look_alikes = ("gyro_drift", "gyro_bias")
    confirm = "A long record of the platform held still: its Allan deviation grows with the square root of time."

    @override
    def found(self, component: str, readings: Readings) -> Finding | None:
        stated = readings.runs[0].slow_bias or SlowBias(instability=0.0)  # of one gyro, alike in all runs
        if not readings.absorbed or stated.random_walk:
            return None
        increments, spectrum = _increments(readings), readings.spectrum
        freedom = spectrum.freedom if spectrum is not None else inf
        variance, ratio = likeliest_variance(increments, freedom)
        walk = float(np.sqrt(variance))
        error = 0.5 * walk * relative_error(increments, variance) if walk else inf
        return Finding(
            values=np.array([walk]),
            std=np.array([error]),
            chi_square_reduction=ratio,
            freedom=1,
            p_value=0.5 * float(scipy.stats.chi2.sf(ratio, 1)) if ratio > 0.0 else 1.0,  # q cannot be negative
            variance=np.zeros(3),
            noise_freedom=freedom,
            slow_bias=replace(stated, random_walk=walk),
        )

    @override
    def held_out_gain(self, component: str, values: Array, readings: Readings) -> float:
        if not readings.absorbed:
            return 0.0
        increments, variance = _increments(readings), float(values[0]) ** 2
        return increments.explained(variance) - increments.widened(variance)

    @override
    def extension(self, component: str, values: Array, scenario: Scenario) -> Extension:
        walk = np.hypot(scenario.gyro.rate_random_walk_rad_s_per_sqrt_s, values[0])
        return Extension(scenario={"gyro": {"rate_random_walk_rad_s_per_sqrt_s": float(walk)}})


def _increments(readings: Readings) -> Increments:
    """Return what steps of the bias do to the residual beside all parameters, in units of (rad/s)²/s of variance."""
    found, size = list[tuple[Array, Array, Array]](), readings.absorbed[0].shape[-1]
    normal, against = np.zeros((size, size)), np.zeros(size)
    for run, (residual, absorbed) in enumerate(zip(readings.residual, readings.absorbed, strict=True)):
        live = readings.live[run]
        left, columns = (_in_noise(readings, each, run)[:, live] for each in (residual, absorbed))
        flat = columns.reshape(-1, columns.shape[-1])
        normal += flat.T @ flat
        against += flat.T @ left.ravel()
        steps = _in_noise(readings, _steps(readings.runs[run].gyro_time), run)[:, live]
        for axis in range(int(live.sum())):
            power, own = np.linalg.eigh(steps[:, axis].T @ steps[:, axis])
            along = steps[:, axis] @ own
            found.append((np.maximum(power, 0.0), along.T @ left[:, axis], along.T @ columns[:, axis]))
    power, slope, columns = (np.concatenate(parts) for parts in zip(*found, strict=True))
    root = _inverse_root(normal)
    across = columns @ root
    return Increments(power=power, slope=slope - across @ (root.T @ against), across=across)


def _in_noise(readings: Readings, values: Array, run: int) -> Array:
    """Return what stands in a run's samples in units of the noise that they show, shape (N, 3) or (N, 3, C)."""
    white, spectrum = readings.whitened(values, run), readings.spectrum
    if spectrum is None:
        return white
    return np.asarray(white / np.sqrt(spectrum.variance_ratio[run]).reshape(3, *[1] * (values.ndim - 2)))


def _steps(time: Series) -> Array:
    """Return a bias that steps at each knot as a walk of 1 rad/s/√s does, about each axis, shape (N, 3, T)."""
    edges = np.linspace(time[0], time[-1], min(len(time) - 1, _MOST_KNOTS) + 1)
    steps = (time[:, None] > 0.5 * (edges[1:] + edges[:-1])) * np.sqrt(np.diff(edges))
    return np.repeat(steps[:, None], 3, axis=1)


def _inverse_root(normal: Array) -> Array:
    """Return R with Rᵀ normal R = 1 on the directions that the columns span, shape (P, rank)."""
    scale = 1.0 / np.sqrt(np.maximum(np.diag(normal), np.finfo(float).tiny))
    strength, axes = np.linalg.eigh(normal * np.outer(scale, scale))
    own = strength > _DEPENDENT * strength[-1]
    return np.asarray(scale[:, None] * axes[:, own] / np.sqrt(strength[own]))
