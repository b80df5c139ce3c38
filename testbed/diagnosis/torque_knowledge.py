"""Whether the applied torque of whole runs is known well enough: what is not adds up to a random walk of the body rate.

Jets and motors that give what they are asked for but for a random share turn the body by a little more or less at
every sample. Over a whole run that is a motion of its own, which looks like other effects and like another inertia, and
their intervals, which count the gyro's noise alone, are far too short. The remedy is to compare over windows.

The measured rate's changes from sample to sample are fitted by commands and motion, by Euler's equations with any
numbers in them. The residual is the gyro's noise and, if torques are off, a random walk: its changes over m samples
have a variance that grows as m, and not as m² as those of a torque that lasts, nor stay bounded as those of a delay or
of what oscillates. It is looked for where from one sample to the next it gains twice the gyro's noise.

Source: Lo and MacKinlay, "Stock market prices do not follow random walks", Review of Financial Studies (1988), for the
variances' ratio.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations_with_replacement

import numpy as np
import scipy
from numpy.typing import NDArray
from scipy.optimize import nnls

from testbed.arrays import Array, Flags, Vectors3
from testbed.diagnosis.data import Runs
from testbed.diagnosis.gate import Gate
from testbed.diagnosis.model import Fit
from testbed.dynamics.inertia import inertia_of
from testbed.estimation.telemetry import Telemetry

_LATE = np.arange(-1.0, 11.0)
"""Samples by which a torque may come late or early and still explain what the rate gains: those of quadcopters' motors
that lag by three samples leave a walk behind two samples, and none behind ten."""
_MOST_SHARE = 0.25
"""Of the samples, the most numbers that may explain them: of shorter runs, whose residual would have less than three
quarters of the noise's variance, nothing is asked.

Source: chosen."""
_LONGEST_SHARE = 1.0 / 16.0
"""Of a run over which changes are taken: sixteen of them that do not overlap tell a variance to a third, those of three
runs to a fifth."""
_FEWEST_LAGS = 4
"""Numbers of samples over which the variance has to grow alike: 1, 2, 4 and 8; a run of 128 samples has so many.

Source: chosen, two more than a straight line has unknowns."""
_STRAIGHT = 0.35
"""By which the variance may differ from a straight line over the number of samples, as a share of it.

Source: chosen, twice the standard error of the longest; the variance of a torque that lasts for four samples differs by
half."""
_ABOVE = 2.0
"""Times the noise's variance that a walk gains with a sample where it is looked for: slow torques beside noise may grow
as straight, but gain less than it.

Source: chosen; of twelve jets, random shares of 10 and 30 % gain about 4 and 30 times."""
_SHOWN = 10.0
"""Standard deviations of the gyro's noise by which such a walk leaves its beginning in a run, from which on it is
refused.

Source: chosen; of four runs of twelve jets, 600 samples at 10 Hz, random shares of 10 and 30 % leave it by 44 and
153."""
_JUMP = 8.0
"""Times the changes' median size, as a standard deviation, from which on one is a touch, as long as these are few.

Source: chosen, far beyond what noise or a random share makes of one sample; what is off at random is so in most."""
_FEW = 0.01
"""Share of the changes up to which those are few.

Source: chosen: three touches in 300 samples, where a walk takes part in all."""
_WINDOW = 20
"""Samples of the windows that are proposed: as many as those of the quadcopters of data/crazyflie, in which the walk is
small and the effects of motors still show."""


def require_known_torque(runs: Runs, baseline: Fit, gate: Gate) -> None:
    """Refuse whole runs whose applied torque is off at random from sample to sample.

    Args:
        runs: to be fitted, of one platform.
        baseline: the platform without effects, fitted to them.
        gate: what is accepted.

    Raises:
        InputError: it is, by so much that over whole runs it would pass for something else.
    """
    if runs.known_in_part or runs.driven_by_momentum:
        return
    telemetry = runs.grid.runs
    left = _unexplained(telemetry)
    length = min(len(run.gyro_time) for run in telemetry)
    lags = 2 ** np.arange(int(np.log2(max(_LONGEST_SHARE * length, 1.0))) + 1, dtype=np.intp)
    if left is None or len(lags) < _FEWEST_LAGS:
        return
    gained = np.array([_grown(left, lags, axis) for axis in range(3)])
    sigma = np.sqrt(np.mean(runs.sigma**2, axis=0))
    walking = np.any(runs.live, axis=0) & (np.sqrt(gained * length) > _SHOWN * sigma)
    if walking.any():
        gate.refuse("torque", _words(runs, baseline, gained, walking))


def _unexplained(telemetry: Sequence[Telemetry]) -> list[Vectors3] | None:
    """Return what no command, no motion and no touch explains of the rates' changes, shapes (N, 3).

    None of too few samples.
    """
    changes, known = zip(*map(_changes, telemetry), strict=True)
    every, explaining = np.concatenate(changes), np.concatenate(known)
    if explaining.shape[1] > _MOST_SHARE * len(explaining):
        return None
    left = every - explaining @ np.linalg.lstsq(explaining, every, rcond=None)[0]
    kept = ~_touched(left)
    if not kept.all():  # a touch moves what explains the others as well
        left = every - explaining @ np.linalg.lstsq(explaining[kept], every[kept], rcond=None)[0]
        left[~kept] = 0.0
    return np.split(left, np.cumsum([len(each) for each in changes])[:-1])


def _changes(run: Telemetry) -> tuple[Vectors3, Array]:
    """Return by how much the rate changes from sample to sample, (N, 3), and what may explain it, (N, C).

    That are torques about then, the rate, and the products of both. Before the first known torques, nothing is asked.
    """
    time, rate = run.gyro_time, 0.5 * (run.body_rate[1:] + run.body_rate[:-1])
    middle, interval = 0.5 * (time[1:] + time[:-1]), float(np.median(np.diff(time)))
    assert run.applied_torque is not None
    given = run.applied_torque if run.thrust is None else run.thrust
    torque = np.column_stack([np.interp(middle, run.actuator_time, column) for column in run.applied_torque.T])
    asked = [np.interp(middle - late * interval, run.actuator_time, column) for late in _LATE for column in given.T]
    pairs = list(combinations_with_replacement(range(3), 2))
    products = [each[:, i] * each[:, j] for each in (rate, torque) for i, j in pairs]
    rows = middle - _LATE[-1] * interval >= run.actuator_time[0]
    return np.diff(run.body_rate, axis=0)[rows], np.column_stack([np.ones(len(middle)), *asked, rate, *products])[rows]


def _grown(left: Sequence[Vectors3], lags: NDArray[np.intp], axis: int) -> float:
    """Return by how much a walk's variance grows with every sample, rad²/s².

    Zero where there is none, or it gains so little from sample to sample that slow torques would look alike.
    """
    walks = [np.concatenate([[0.0], np.cumsum(each[:, axis])]) for each in left]
    variance = np.array([np.mean(np.concatenate([walk[lag:] - walk[:-lag] for walk in walks]) ** 2) for lag in lags])
    if not variance.all():
        return 0.0
    terms = np.column_stack([np.full(len(lags), 2.0), lags]) / variance[:, None]
    (noise, gained), _ = nnls(terms, np.ones(len(lags)))
    straight = np.all(np.abs(terms @ [noise, gained] - 1.0) < _STRAIGHT)
    return float(gained) if straight and gained > _ABOVE * noise else 0.0


def _touched(left: Vectors3) -> Flags:
    """Return which changes, shape (N,), are far larger than all others, if these are few: one jump varies as a walk."""
    usual = scipy.stats.median_abs_deviation(left, axis=0, scale="normal")
    touched = np.any(np.abs(left) > _JUMP * usual, axis=1)
    return touched if touched.mean() <= _FEW else np.zeros_like(touched)


def _words(runs: Runs, baseline: Fit, gained: Array, walking: Flags) -> str:
    """Say by how much the torque is off, and the remedy."""
    interval = float(np.median(np.concatenate([np.diff(run.gyro_time) for run in runs.grid.runs])))
    off = np.sqrt(np.where(walking, gained, 0.0)) / interval @ inertia_of(baseline.theta)
    asked = np.concatenate([run.applied_torque for run in runs.grid.runs if run.applied_torque is not None])
    share = float(np.linalg.norm(off) / np.sqrt(np.mean(asked**2) * 3.0))
    return (
        f"the body turns as if applied_torque were off by {100.0 * share:.2g} % ({np.linalg.norm(off):.2g} N·m) at "
        "random from sample to sample: over whole runs that passes for effects that are not there and for another "
        f"inertia. Compare over windows, [diagnosis] horizon_s = {_WINDOW * interval:.2g}"
    )
