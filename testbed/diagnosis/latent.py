"""The unmodelled torque in a model's residual, of any shape: a latent random-walk torque on each axis.

The residual r of the present model, with all that the model can absorb projected out, is N(0, 1) if nothing is missing,
and N(0, 1 + q G Gᵀ) if a torque whose increments have the variance q acts on the platform. The likelihood ratio of the
two tests for the unknown, and gives it a place among the hypotheses.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from itertools import pairwise
from math import ceil

import numpy as np
import scipy

from testbed.arrays import Array
from testbed.diagnosis.data import Runs, chosen, joined
from testbed.diagnosis.fitting import fitted_initial_rates
from testbed.diagnosis.keeping import Content, array_from_content, array_to_content, part
from testbed.diagnosis.model import Fit, evaluated, orthonormal, projected_out
from testbed.diagnosis.p_values import p_value
from testbed.diagnosis.settings import SETTINGS
from testbed.diagnosis.torque_space import torque_responses
from testbed.estimation.random_walk import Increments, likeliest_variance

KNOTS_PER_SECOND = 8.0
"""Hat functions of the torque: enough for 4 Hz, the fastest that 16 Hz samples distinguish from noise. With half or
twice as many, the likelihood ratio of the baselines of cases 9 and 12 of 14 of seed 90817, 10.1 and 29.6, changes by
0.4 at most."""
_MOST_KNOTS = 240
"""Of a run, however long: its increments make an eigenvalue problem of three times as many.

Source: measured on five flights of 40 s with a torque that no effect has; the likelihood ratio of 133.42 changes by
0.002 from 320 knots to 240, by 0.006 to 120."""
_FEWEST_KNOTS = 8
"""Of a run, however short: runs of 1 s and more have as many by their length, and the shortest that are used, of ten
samples, nearly as many samples."""


def goodness(fit: Fit, noise_freedom: float) -> float:
    """Return the p-value of the residual's χ², with all directions of the parameters projected out.

    Args:
        fit: evaluated on all runs.
        noise_freedom: degrees of freedom with which the noise is known.
    """
    basis = orthonormal(fit.jacobian)
    left = projected_out(fit.residual, basis)
    return p_value(float(left @ left), len(left) - basis.shape[1], noise_freedom)


def on_all_runs(runs: Runs, heldout: Runs | None, fit: Fit) -> tuple[Runs, Fit]:
    """Return all runs together, gyro only, and a fit evaluated on them: unmodelled torques are tested in all runs.

    Args:
        runs: that were fitted.
        heldout: that were not: of them, initial rates are fitted; None where there are none.
        fit: to the former.
    """
    rates, trim, turn = fit.values.initial_rate, fit.values.trim, fit.values.first_turn
    if heldout is not None:
        own = fitted_initial_rates(heldout, fit).values
        rates = np.concatenate([rates, own.initial_rate])
        trim = None if trim is None or own.trim is None else np.concatenate([trim, own.trim])
        turn = None if turn is None or own.first_turn is None else np.concatenate([turn, own.first_turn])
    everything = joined(runs, heldout)
    return everything, evaluated(
        everything, fit.placed, replace(fit.values, initial_rate=rates, trim=trim, first_turn=turn)
    )


def on_enough_runs(runs: Runs, fit: Fit) -> tuple[Runs, Fit]:
    """Return an even choice of runs where there are very many, gyro only, and the fit evaluated on them.

    Args:
        runs: of one data set, as many as there are.
        fit: of them.
    """
    if len(runs.names) <= SETTINGS.most_residual_runs:
        return runs, fit
    which = np.linspace(0, len(runs.names) - 1, SETTINGS.most_residual_runs).round().astype(int).tolist()
    some = chosen(runs, which)
    return some, evaluated(some, fit.placed, fit.values.of_runs(np.array(which)))


@dataclass(frozen=True, kw_only=True, eq=False)
class LatentTorque:
    """An unmodelled torque, estimated from the residual.

    Attributes:
        likelihood_ratio: 2 (log L(q̂) - log L(0)), the noise as the model has it.
        p_value: of the ratio if there is no such torque, the noise known as well as it is; q cannot be negative.
        runs: names of those that were used.
        knot_time: of each run, shape (R, T), s.
        torque_B: the smoothed torque, shape (R, T, 3), N·m, body axes; zero where q̂ = 0.
    """

    likelihood_ratio: float
    p_value: float
    runs: tuple[str, ...]
    knot_time: Array
    torque_B: Array


def latent_torque(runs: Runs, fit: Fit) -> LatentTorque:
    """Estimate the variance of a random-walk torque, and the torque itself, from the residual of a fit.

    Args:
        runs: that were fitted; an even choice of them where there are very many.
        fit: of the present model to them.
    """
    return part(
        "latent torque",
        (runs, [each.key for each in fit.placed], fit.values, fit.residual),
        work=lambda: _latent_torque(runs, fit),
        to_content=_to_content,
        from_content=_from_content,
    )


def _to_content(latent: LatentTorque) -> Content:
    arrays = {"knot_time": array_to_content(latent.knot_time), "torque_B": array_to_content(latent.torque_B)}
    return {field.name: getattr(latent, field.name) for field in fields(latent)} | arrays


def _from_content(content: Content) -> LatentTorque:
    arrays = {name: array_from_content(content[name]) for name in ("knot_time", "torque_B")}
    return LatentTorque(**content | arrays | {"runs": tuple(content["runs"])})


def _latent_torque(runs: Runs, fit: Fit) -> LatentTorque:
    runs, fit = on_enough_runs(runs, fit)
    knots = min(knot_count(runs, KNOTS_PER_SECOND), _MOST_KNOTS)
    # From its increments to the torque at the knots.
    walk = np.asarray(np.kron(np.tril(np.ones((knots, knots))), np.eye(3)), dtype=np.float64)
    increments, directions = _increments(_by_run(runs, fit, knots), walk)
    variance, ratio = likeliest_variance(increments)
    _, surely = likeliest_variance(increments, runs.noise_freedom)
    likeliest = np.split(variance * increments.solved(variance), len(runs.names))
    torque_B = np.stack([(walk @ (own @ each)).reshape(-1, 3) for own, each in zip(directions, likeliest, strict=True)])
    ends = runs.grid.node_time[:, [0, -1]]
    return LatentTorque(
        likelihood_ratio=ratio,
        p_value=0.5 * float(scipy.stats.chi2.sf(surely, 1)) if surely > 0.0 else 1.0,
        runs=runs.names,
        knot_time=np.linspace(ends[:, 0], ends[:, 1], knots, axis=1),
        torque_B=torque_B,
    )


def knot_count(runs: Runs, per_second: float) -> int:
    """Return the number of knots of the longest run: no more than samples, which tell no faster torque."""
    per_second = min(per_second, gyro_rate_of(runs))
    return max(_FEWEST_KNOTS, ceil(per_second * float(np.ptp(runs.grid.node_time, axis=1).max())))


def fastest_oscillation(gyro_rate: float) -> float:
    """Return the highest frequency of an oscillating torque that is tested for, Hz, of a gyro at a rate, Hz."""
    return min(SETTINGS.fastest_oscillation_hz, SETTINGS.share_of_rate * gyro_rate)


def gyro_rate_of(runs: Runs) -> float:
    """Return the rate at which gyros sample, Hz; of runs that differ, the highest."""
    return max((len(run.gyro_time) - 1) / float(np.ptp(run.gyro_time)) for run in runs.grid.runs)


@dataclass(frozen=True, kw_only=True, eq=False)
class _Free:
    """What torques at the knots do to a run, and its residual; what the run's own parameters can do is projected out.

    Attributes:
        response: shape (samples, T 3).
        shared: what parameters of all runs do, shape (samples, C).
        residual: shape (samples,).
    """

    response: Array
    shared: Array
    residual: Array


def _by_run(runs: Runs, fit: Fit, knots: int) -> list[_Free]:
    common = 6 + len(fit.effect_values)
    size = runs.own_size
    trims = common + size * len(runs.names)  # columns from here on, which windows of one record share
    edges, free = np.cumsum([0, *runs.sizes]).tolist(), []
    for run, (rows, response) in enumerate(
        zip((slice(*ends) for ends in pairwise(edges)), torque_responses(runs, fit, knots), strict=True)
    ):
        # A torque on the body shows in the gyro's samples, which come first.
        own = orthonormal(fit.jacobian[rows, common + size * run : common + size * (run + 1)])
        shared = np.hstack([fit.jacobian[rows, :common], fit.jacobian[rows, trims:]])
        parts = (projected_out(each, own) for each in (response, shared, fit.residual[rows]))
        free.append(_Free(**dict(zip(("response", "shared", "residual"), parts, strict=True))))
    return free


def _increments(free: Sequence[_Free], walk: Array) -> tuple[Increments, list[Array]]:
    """Return what increments do to the residual, and by run the directions of its components, as columns.

    Args:
        free: of each run.
        walk: from a run's increments to its torque, shape (T 3, T 3).
    """
    shared = orthonormal(np.concatenate([each.shared for each in free]))
    whole = projected_out(np.concatenate([each.residual for each in free]), shared)
    ends = np.cumsum([len(each.residual) for each in free])[:-1]
    found, directions = list[tuple[Array, Array, Array]](), []
    for each, basis, residual in zip(free, np.split(shared, ends), np.split(whole, ends), strict=True):
        response = each.response @ walk
        power, own = np.linalg.eigh(response.T @ response)
        found.append((np.maximum(power, 0.0), own.T @ (response.T @ residual), own.T @ (response.T @ basis)))
        directions.append(own)
    power, slope, across = (np.concatenate(parts) for parts in zip(*found, strict=True))
    return Increments(power=power, slope=slope, across=across), directions
