"""What the actuators' telemetry does to a comparison with the gyro: what it adds to the noise, and where it is silent.

Between samples a spline stands for the actuators' momentum, and the body rate misses J⁻¹ of what the spline does. Where
the telemetry is slower than what is tested for, that is no noise of the gyro's: of a healthy platform it had the names
of its colour, and of oscillating torques.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import compress

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from testbed.arrays import Array, Flags, Series, Theta, Vector3
from testbed.diagnosis.data import Runs
from testbed.diagnosis.fitting import nominal_fit
from testbed.diagnosis.latent import fastest_oscillation
from testbed.dynamics.inertia import inertia_of
from testbed.effects.fast_changes import FEWEST, ORDER, fast_power
from testbed.estimation.actuation import actuation
from testbed.estimation.differences import correlated_share
from testbed.estimation.gaps import FEWEST_SAMPLES
from testbed.estimation.telemetry import Telemetry, has_momentum
from testbed.estimation.telemetry_noise import predicted_rate_variance

_PROFILE = 64.0
"""Times f³ (1 - f)³, for a share f of the interval, over what a spline misses half way between samples.

Source: formula: of an integrated Wiener process, of which the spline is the mean (Wahba, "Spline models for
observational data", 1990), it misses the variance q Δ³ f³ (1 - f)³ / 3."""
_SHOWN = 10.0
"""χ² that the misses add to all runs together, below which no shape of them is seen.

Source: chosen: noise alone makes a misfit of 9 and less in 99 of 100 data sets."""
_COST = 1.0
"""χ² that the misses at the samples that are left may add to all runs together.

Source: convention: one standard error of whatever they resemble."""
_LEFT = 0.25
"""Share of the actuators' samples that the gyro's are left beside at least.

Source: chosen, between clocks of 4 and 10 Hz, of which every second of the actuators' samples coincides with one of the
gyro's, and of 16 and 25 Hz, of which every sixteenth does: too few to go on with."""


def where_known(runs: Sequence[Telemetry], theta: Theta) -> list[Telemetry]:
    """Return runs less the gyro's samples between those of slow actuators; as they are where splines hardly miss.

    Slow are actuators that come more slowly than what is tested for, and those whose path the gyro sees to be chords.

    Else as many are left as splines miss by little, the nearest to the actuators' samples first. Where these are hardly
    any, as of clocks that lie apart by the same part of an interval always, the nearest to each is left.

    Args:
        runs: of one platform.
        theta: inertia parameters, shape (6,), kg·m².
    """
    watched = [shows_between(run) for run in runs]
    chords = _show_chords(list(compress(runs, watched)), theta)
    slow = [
        has_momentum(run) and (_slower_than_tested(run) or (chords and seen))
        for run, seen in zip(runs, watched, strict=True)
    ]
    missed = [_missed(run, theta) if each else np.zeros(0) for run, each in zip(runs, slow, strict=True)]
    every = np.sort(np.concatenate([np.zeros(0), *missed]))
    if every.sum() < _SHOWN:
        return list(runs)
    seen = np.searchsorted(np.cumsum(every), _COST)
    return [
        run.with_gyro_rows(_known(run, own < every[seen])) if each else run
        for run, own, each in zip(runs, missed, slow, strict=True)
    ]


def unknown_between(left: int, every: int) -> str:
    """Return what to say of gyro samples that are left out, of every one that was sent."""
    return (
        f"{left} of {every} gyro samples lie between samples of the actuators, which come too slowly to show how the "
        "body turned meanwhile, and are not compared: send the actuators' telemetry as often as the gyro's"
    )


def _known(run: Telemetry, unseen: Flags) -> NDArray[np.intp]:
    """Return the indices of the gyro's samples that are left of a run, in order.

    Args:
        run: as it was sent.
        unseen: which of its gyro's samples splines miss by too little to be seen, shape (N,).
    """
    nearest, time, sent = _nearest(run), run.gyro_time, run.actuator_time
    left = np.flatnonzero(unseen & (time >= sent[0]) & (time <= sent[-1]))
    return left if len(left) >= _LEFT * len(nearest) else nearest


def with_telemetry_noise(runs: Runs, theta: Theta) -> Runs:
    """Return runs whose standard deviation holds what the actuators' telemetry adds to the gyro's noise.

    Args:
        runs: with the gyro's own.
        theta: inertia parameters, shape (6,), kg·m².
    """
    variance = runs.sigma**2
    added = np.array([predicted_rate_variance(run, theta) for run in runs.grid.runs])
    if np.any(added > _NOTICED * variance):
        added = np.minimum(added, _most_added(runs, theta) * variance)
    return runs.with_sigma(np.sqrt(variance + added))


_NOTICED = 0.1
"""Share of the gyro's variance up to which it makes no difference how much the telemetry's noise adds to it.

Source: chosen; 5 % of a standard deviation, as well as the noise is known of 200 samples."""
_SURELY = 2.0
"""Standard errors by which the residual may scatter more than it seems to.

Source: convention: of 98 in 100 data sets it does not."""


def _most_added(runs: Runs, theta: Theta) -> Vector3:
    """Return what the telemetry's noise adds at most about each axis, over the gyro's variance, shape (3,).

    Fast changes of telemetry that comes slowly are motion as well: what they say of its noise is an upper limit. What
    the gyro's samples beside the actuators' scatter about their prediction is another one.
    """
    residual = runs.by_run(nominal_fit(runs, theta).residual)
    squares = [np.zeros((0, 3))]
    for run, part in zip(runs.grid.runs, residual, strict=True):
        beside = part[_nearest(run)]
        if len(beside) >= FEWEST:
            squares.append(fast_power(beside))
    every = np.concatenate(squares)
    if not len(every):
        return np.full(3, np.inf)
    error = np.sqrt(2.0 * correlated_share(ORDER) / len(every))
    return np.asarray(np.maximum(every.mean(axis=0) * (1.0 + _SURELY * error) - 1.0, 0.0))


def _nearest(run: Telemetry) -> NDArray[np.intp]:
    """Return the indices of the gyro's samples that are the nearest to one of the actuators', in order."""
    middle = 0.5 * (run.gyro_time[1:] + run.gyro_time[:-1])
    return np.unique(np.searchsorted(middle, run.actuator_time))


def _slower_than_tested(run: Telemetry) -> bool:
    """Return whether the actuators' Nyquist frequency is below those of the torques that are tested for."""
    tested = fastest_oscillation(1.0 / _interval(run.gyro_time))
    return bool(2.0 * tested * _interval(run.actuator_time) > 1.0 + _ROUNDING)


_BETWEEN = 1.5
"""Samples of the gyro for each of the actuators from which it shows what these did between.

Source: chosen: of clocks of one rate nothing lies between, of a gyro twice as fast every second sample does."""
_HALF = 0.5
"""Share of what a spline bends between samples, by the gyro, below which the path is nearer to chords; and share of
what chords bend at samples that it shows at least, and `_SURELY` standard errors more than none: of their noise it
shows none. It was to be surely more than half: of eight healthy sets of one rig, whose tachometer makes a fifth of the
bends, the splines of two were believed, and missed by what looked like an appendage.

Source: convention: half way between one and none."""


def _show_chords(runs: Sequence[Telemetry], theta: Theta) -> bool:
    """Return whether the gyro's second differences follow chords of the actuators' momentum rather than a spline.

    So they do where motors hold their torque from one sample of the telemetry to the next. Bends that its noise makes
    are in neither: the gyro shows none of them.
    """
    bends = [_bends(run, theta) for run in runs]
    if not bends:
        return False
    seen, smooth, bent = (np.concatenate(each) for each in zip(*bends, strict=True))
    certain = float(np.sqrt((bent**2).sum()))
    if certain <= 0.0 or _share(seen, bent) < max(_HALF, _SURELY / certain):
        return False
    return _share(seen - bent, smooth - bent) < _HALF


def _bends(run: Telemetry, theta: Theta) -> tuple[Series, Series, Series]:
    """Return second differences of the gyro's samples, of a spline and of chords, in the noise's standard deviation."""
    rate = _held_rate(run, theta)
    inside = (run.gyro_time >= run.actuator_time[0]) & (run.gyro_time <= run.actuator_time[-1])
    time = run.gyro_time[inside]
    chords = np.stack([np.interp(time, run.actuator_time, axis) for axis in rate.T], axis=1)
    spline = CubicSpline(run.actuator_time, rate)(time)
    noise = np.sqrt(6.0) * run.gyro_noise  # 1² + 2² + 1²
    seen, smooth, bent = (
        np.diff(each, 2, axis=0).ravel() / noise for each in (-run.body_rate[inside][:, run.live], spline, chords)
    )
    return seen, smooth, bent


def shows_between(run: Telemetry) -> bool:
    """Return whether the gyro shows what the actuators did between their samples."""
    return has_momentum(run) and _BETWEEN * _interval(run.gyro_time) <= _interval(run.actuator_time)


def _share(seen: Array, of: Array) -> float:
    """Return the share of a pattern that is seen, by least squares; of none, none."""
    square = float((of**2).sum())
    return float((seen * of).sum()) / square if square > 0.0 else 0.0


def _held_rate(run: Telemetry, theta: Theta) -> Array:
    """Return J⁻¹ of the actuators' momentum at their samples, about the axes that turn, shape (K, axes), rad/s."""
    live = np.ix_(run.live, run.live)
    momentum = actuation(run, run.actuator_time).cluster_momentum_B[:, run.live]
    return np.asarray(np.linalg.solve(inertia_of(theta)[live], momentum.T).T, dtype=np.float64)


_ROUNDING = 1e-3
"""Share by which intervals between samples differ that are the same.

Source: chosen, for clocks that are written with four digits."""


def _interval(time: Series) -> float:
    return float(np.median(np.diff(time)))


def _missed(run: Telemetry, theta: Theta) -> Series:
    """Return what a spline through the actuators' momentum is expected to add to χ² of each sample of the gyro.

    What rough changes add follows from samples that are left out. Motors whose torque is held from sample to sample
    make chords of the path, and the samples themselves do not show that: they may lie on a smooth one.
    """
    rate = _held_rate(run, theta)
    of_two, of_four = (_missed_between(run.actuator_time, rate, every) for every in (2, 4))
    # What is smooth is missed by 1/256 where samples are twice as close, an integrated Wiener process by 1/8.
    of_one = of_two * min(of_two / of_four, 1.0) if of_four > 0.0 else of_two
    place = np.interp(run.gyro_time, run.actuator_time, np.arange(float(len(run.actuator_time))))
    from_ends = (place % 1.0) * (1.0 - place % 1.0)  # f (1 - f)
    inside = np.clip(run.gyro_time, *run.actuator_time[[0, -1]])
    curvature = np.asarray(CubicSpline(run.actuator_time, rate)(inside, 2))
    chord = 0.5 * curvature * (from_ends * _interval(run.actuator_time) ** 2)[:, None]
    return np.asarray((of_one * _PROFILE * from_ends**3 + (chord**2).sum(axis=1)) / run.gyro_noise**2)


def _missed_between(time: Series, values: Array, every: int) -> float:
    """Return the mean square, summed over columns, of what splines miss of the samples half way between their knots.

    Args:
        time: of the samples, shape (K,), s.
        values: shape (K, C).
        every: how many intervals lie between knots, an even number.
    """
    squares = [np.zeros(0)]
    for first in range(every):
        knots = np.arange(first, len(time), every)
        if len(knots) >= FEWEST_SAMPLES:
            between = knots[:-1] + every // 2
            missed = CubicSpline(time[knots], values[knots])(time[between]) - values[between]
            squares.append((missed**2).sum(axis=1))
    every_one = np.concatenate(squares)
    return float(every_one.mean()) if len(every_one) else 0.0
