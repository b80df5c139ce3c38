"""Torques that no effect of the library makes, by their shape: what is found is described, and not named.

A shape is a few functions of time, body axes, on the knots of a piecewise linear torque; its amplitudes are free. Each
is tested on what a model leaves in all runs, fitted and held out; its evidence is that of an effect of as many
parameters, less twice the logarithm of the number of shapes.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations_with_replacement
from math import exp, log

import numpy as np

from testbed.arrays import Array
from testbed.diagnosis.chance import log_chance, scale_evidence
from testbed.diagnosis.data import Runs
from testbed.diagnosis.evidence import on_enough_runs
from testbed.diagnosis.latent import torque_response
from testbed.diagnosis.model import Fit
from testbed.diagnosis.projection import orthonormal, projected_out
from testbed.prediction.integration import node_rates

_KNOTS_PER_SECOND = 12.0
"""Hat functions: a sine of 4 Hz keeps nine tenths of its amplitude between three of them."""
_FEWEST_KNOTS = 8
_FASTEST = 4.0
"""Hz; and a quarter of the gyro's rate at most."""
_RESOLVED = 0.25
"""Of a period over the longest run: the distance of frequencies that are tried."""


@dataclass(frozen=True, kw_only=True)
class TorqueShape:
    """What a torque of a certain shape would explain.

    Attributes:
        words: the shape, for the reader.
        evidence: twice the logarithm of by how much it makes the data more likely, for all shapes tried.
        p_value: of as much by chance, times the number of shapes tried.
        frequency_hz: of one that oscillates; None for others.
    """

    words: str
    evidence: float
    p_value: float
    frequency_hz: float | None = None


@dataclass(frozen=True, kw_only=True, eq=False)
class _Tried:
    words: str
    torques: Array
    """At the knots of every run, shape (R, T, F): a function stands for three torques, one on each axis."""
    frequency_hz: float | None = None


def torque_shapes(runs: Runs, fit: Fit) -> tuple[TorqueShape, ...]:
    """Return all shapes that were tried, the one with the most evidence first.

    Args:
        runs: all of them; of their channels the gyro's samples count. An even choice of them where they are very many.
        fit: of the present model to them; what it can absorb is projected out.
    """
    runs, fit = on_enough_runs(runs, fit)
    time = runs.grid.node_time - runs.grid.node_time[:, :1]
    knots = max(_FEWEST_KNOTS, int(np.ceil(_KNOTS_PER_SECOND * time.max())))
    at = np.linspace(np.zeros(len(time)), time[:, -1], knots, axis=1)
    nuisance = orthonormal(fit.jacobian[: runs.samples])
    # Of the residual only what torques can do counts: as many numbers as there are torques.
    directions, free = np.linalg.qr(projected_out(torque_response(runs, fit, knots), nuisance))
    response = np.ascontiguousarray(np.moveaxis(free.reshape(len(free), -1, 3), -1, 0))
    residual = directions.T @ fit.residual[: runs.samples]
    tried = [*_slow(at, _rates(runs, fit, at)), *_oscillations(runs, at)]
    found = [_tested(each, response, residual, len(tried), runs.noise_freedom) for each in tried]
    return tuple(sorted(found, key=lambda shape: -shape.evidence))


def _slow(time: Array, rates: Array) -> Iterator[_Tried]:
    yield _Tried(words="grows in proportion to the time since the start", torques=time[..., None])
    products = [rates[..., i] * rates[..., j] for i, j in combinations_with_replacement(range(3), 2)]
    yield _Tried(words="follows products of body rates", torques=np.stack(products, axis=-1))


def _oscillations(runs: Runs, time: Array) -> Iterator[_Tried]:
    """Yield sines whose phase, from the start of a run, is the same in all runs, and sines with phases of their own."""
    longest = float(time.max())
    rate = max((len(run.gyro_time) - 1) / float(np.ptp(run.gyro_time)) for run in runs.grid.runs)
    for frequency in np.arange(1.0 / longest, min(_FASTEST, 0.25 * rate), _RESOLVED / longest):
        waves = np.exp(2j * np.pi * frequency * time)
        together = np.stack([waves.real, waves.imag], axis=-1)
        words = f"oscillates at {frequency:.2f} Hz"
        yield _Tried(words=words, torques=together, frequency_hz=float(frequency))
        own = np.einsum("rtf,rq->rtqf", together, np.eye(len(time))).reshape(*time.shape, -1)
        yield _Tried(words=f"{words}, in no step between runs", torques=own, frequency_hz=float(frequency))


def _rates(runs: Runs, fit: Fit, time: Array) -> Array:
    """Return the predicted body rate at the knots, shape (R, T, 3), rad/s."""
    nodes = node_rates(runs.grid, [each.hooks for each in fit.placed], fit.values)[:, 0]
    from_start = runs.grid.node_time - runs.grid.node_time[:, :1]
    return np.stack(
        [
            np.stack([np.interp(at, own, axis) for axis in rate.T], axis=-1)
            for at, own, rate in zip(time, from_start, nodes, strict=True)
        ]
    )


def _tested(tried: _Tried, response: Array, residual: Array, shapes: int, noise_freedom: float) -> TorqueShape:
    torques = tried.torques.reshape(-1, tried.torques.shape[-1])
    columns = np.concatenate(response @ torques, axis=-1)
    basis = orthonormal(columns)
    freedom, square = basis.shape[1], float(((basis.T @ residual) ** 2).sum())
    if not freedom:
        return TorqueShape(words=tried.words, evidence=0.0, p_value=1.0)
    return TorqueShape(
        words=tried.words,
        evidence=scale_evidence(square, freedom) - 2.0 * log(shapes),
        p_value=exp(min(0.0, log(shapes) + log_chance(square, freedom, noise_freedom))),
        frequency_hz=tried.frequency_hz,
    )


def surest(shapes: Sequence[TorqueShape]) -> TorqueShape | None:
    """Return the shape that chance makes least likely; None of none."""
    return min(shapes, key=lambda shape: shape.p_value, default=None)
