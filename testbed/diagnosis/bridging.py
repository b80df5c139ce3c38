"""Over which gaps of the actuators' telemetry a motion can be predicted, as the record itself shows.

Without an applied torque the total angular momentum lasts through a gap. What is lost is the attitude by which it
turned meanwhile: the spline through the samples on both sides errs by δh between them, the attitude behind by
δφ = J⁻¹ ∫ δh dt, and the body rate from there on by J⁻¹ (δφ × H). How large that is follows from samples that came
through: some are left out, in bursts as long as the gap, and the spline through the others is compared with them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from testbed.arrays import Array, Flags, Matrix3, Vectors3
from testbed.dynamics.inertia import cross_matrix
from testbed.estimation.actuation import actuation
from testbed.estimation.gaps import FEWEST_BURSTS, HELD_PERIODS, KEPT_BETWEEN, between_gaps, bursts, gaps, lost_samples
from testbed.estimation.telemetry import Telemetry
from testbed.prediction.tachometer import without_tachometer_noise

_ALWAYS = 0.3
"""s. Bridged without being asked.

Source: chosen: over it a gimbal that swings by 0.3 rad at 1 Hz costs an attitude of 6e-4 rad."""
_ALWAYS_TORQUE = 0.11
"""s. The same under an applied torque, of which no momentum tells afterwards what it did.

Source: measured: it is followed at 16 Hz, and so is it over gaps that are hardly longer; over 0.12 s what changes
between left a jump of 4e-5 N·m·s, which looks like a touch."""
_LONGEST, _LONGEST_PERIODS = 1.0, 10.0
"""s, and usual intervals, the longer of which a bridged gap may last: in longer ones something may have happened that
no telemetry tells, such as a touch."""
_COST = 1.0
"""χ² that all bridged gaps of a record may cost together.

Source: convention: one standard error of whatever they resemble; in three sets of seed 8003 a gap costs up to 0.006."""
_EXACT, _RATIO = 12, 1.2
"""Lost samples up to which every number is tried by itself, and the ratio of those that are tried beyond: of a gyro at
200 Hz eight lengths instead of 140, each up to a fifth too long, which costs more and not less than the gap does."""


def bridged_stretches(telemetry: Telemetry, inertia: Matrix3) -> list[slice]:
    """Return the actuator samples between gaps over which the motion cannot be predicted.

    Args:
        telemetry: of one run.
        inertia: nominal J about the point that the platform turns about, shape (3, 3), kg·m².
    """
    if telemetry.applied_torque is not None:
        return driven_stretches(telemetry)
    cut = gaps(telemetry.actuator_time, shortest=_ALWAYS)
    if cut.any():
        cut[_cheapest(_costs(telemetry, inertia, cut))] = False
    return between_gaps(cut)


def driven_stretches(telemetry: Telemetry) -> list[slice]:
    """Return the actuator samples between gaps of an applied torque, of which no momentum tells what it did there."""
    if telemetry.torque_held:
        return between_gaps(gaps(telemetry.actuator_time, HELD_PERIODS))
    return between_gaps(gaps(telemetry.actuator_time, shortest=_ALWAYS_TORQUE))


def _cheapest(costs: Array) -> NDArray[np.intp]:
    """Return the indices of as many costs as may be had together, the least first."""
    order = np.argsort(costs, kind="stable")
    return np.asarray(order[np.cumsum(costs[order]) <= _COST])


def _costs(telemetry: Telemetry, inertia: Matrix3, cut: Flags) -> Array:
    """Return the χ² that bridging each gap costs, infinite where it is too long, or no gap, shape (K - 1,)."""
    long = gaps(telemetry.actuator_time, _LONGEST_PERIODS, shortest=_LONGEST)
    whole = [telemetry.with_actuator_rows(rows) for rows in between_gaps(long) if rows.stop - rows.start > KEPT_BETWEEN]
    stretches = [
        part.with_actuator_rows(rows)
        for part in map(_momentum_only, without_tachometer_noise(whole))
        for rows in between_gaps(gaps(part.actuator_time))
    ]
    inverse = _inverse(inertia, telemetry.live)
    stiffness = _stiffness(telemetry, inertia, inverse)
    lost = np.where(cut & ~long, _tried(lost_samples(telemetry.actuator_time)), 0)
    by_length = {each: _cost(stretches, inverse, stiffness, each) for each in np.unique(lost[lost > 0]).tolist()}
    return np.array([by_length.get(each, np.inf) for each in lost.tolist()])


def _tried(lost: NDArray[np.intp]) -> NDArray[np.intp]:
    """Return by how many lost samples each gap is tried."""
    steps = np.ceil(np.log(np.maximum(lost, 1) / _EXACT) / np.log(_RATIO))
    return np.where(lost > _EXACT, np.ceil(_EXACT * _RATIO**steps), lost).astype(np.intp)


def _momentum_only(run: Telemetry) -> Telemetry:
    """Return the run with the best of what its actuators hold, and without what acts from outside."""
    return replace(run.with_best_momentum(), surroundings=None)


def _inverse(inertia: Matrix3, live: tuple[bool, ...]) -> Matrix3:
    """Return J⁻¹ of the axes about which a platform turns, zero where a bearing holds it."""
    axes, inverse = np.ix_(live, live), np.zeros((3, 3))
    inverse[axes] = np.linalg.inv(inertia[axes])
    return inverse


def _stiffness(telemetry: Telemetry, inertia: Matrix3, inverse: Matrix3) -> Matrix3:
    """Return S of the χ² that an error of the attitude costs, δφᵀ S δφ, in the middle of a run, shape (3, 3), 1/rad².

    Half of the samples follow, each with the error J⁻¹ (δφ × H) of the rate over the gyro's noise; on a pivot gravity
    acts along a wrong attitude as well, for half of the run.
    """
    rates, time, pivot = telemetry.body_rate, telemetry.gyro_time, telemetry.pivot
    at = np.clip(time, *telemetry.actuator_time[[0, -1]])
    momentum = rates @ inertia + actuation(_momentum_only(telemetry), at).cluster_momentum_B
    slopes = inverse @ cross_matrix(momentum) / telemetry.gyro_noise
    stiffness = 0.5 * np.einsum("nij,nik->jk", slopes, slopes)
    if pivot is None:
        return np.asarray(stiffness)
    pulled = pivot.weight * float(np.linalg.norm(pivot.offset_B)) * 0.5 * float(np.ptp(time)) * inverse
    return np.asarray(stiffness + 0.5 * len(time) * pulled.T @ pulled / telemetry.gyro_noise**2)


def _cost(stretches: Sequence[Telemetry], inverse: Matrix3, stiffness: Matrix3, lost: int) -> float:
    """Return the χ² that a gap of so many lost samples costs; infinite where the stretches cannot tell."""
    errors = np.concatenate([np.zeros((0, 3)), *(_momentum_errors(each, lost) for each in stretches)])
    if len(errors) < FEWEST_BURSTS:
        return np.inf
    turned = errors @ inverse.T
    return float(np.einsum("ni,ij,nj->", turned, stiffness, turned)) / len(errors)


def _momentum_errors(complete: Telemetry, lost: int) -> Vectors3:
    """Return ∫ δh dt over each burst that is left out of complete samples, shape (bursts, 3), N·m·s²."""
    time = complete.actuator_time
    gone = bursts(len(time), lost)
    if not gone.any():
        return np.zeros((0, 3))
    around = complete.with_actuator_rows(~gone)
    error = (actuation(around, time).cluster_momentum_B - actuation(complete, time).cluster_momentum_B)[gone]
    return np.asarray(error.reshape(-1, lost, 3).sum(axis=1) * float(np.median(np.diff(time))))
