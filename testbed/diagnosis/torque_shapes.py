"""Torques of known shapes, which no effect of the library has, in a model's residual.

A shape is a few functions of time, body axes, on the knots of a piecewise linear torque; its amplitudes are free. Each
is tested on a model's residual in all runs, fitted and held out. Shapes of one kind differ by a frequency or a phase.
What is found is described, and not named.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from itertools import combinations_with_replacement, groupby, pairwise
from math import exp, log
from typing import Literal, TypeAlias

import numpy as np
from scipy.special import logsumexp

from testbed.arrays import Array
from testbed.diagnosis.data import Runs
from testbed.diagnosis.keeping import part
from testbed.diagnosis.latent import fastest_oscillation, gyro_rate_of, knot_count, on_enough_runs
from testbed.diagnosis.model import Fit, independent, squares_within
from testbed.diagnosis.p_values import log_p_value
from testbed.diagnosis.settings import SETTINGS
from testbed.diagnosis.size_prior import evidences
from testbed.diagnosis.torque_space import TorqueSpace, normal, normal_by_run, torque_space
from testbed.effects.body_torque import BodyTorque
from testbed.prediction.integration import node_rates

_KNOTS_PER_SECOND = 12.0
"""Hat functions: a sine of 4 Hz keeps nine tenths of its amplitude between three of them. With 8 or 24, the evidence of
any shape changes by 0.03 at most in the same cases, that of pulses by 0.6."""
AT_ONCE = 64
"""Shapes whose responses are worked out together: 12 -> 1.3 s for the pulses in five runs of 20 s, the same to
1e-15."""

Kind: TypeAlias = Literal["growing", "product of rates", "oscillation", "oscillation of every run's own", "pulses"]


@dataclass(frozen=True, kw_only=True)
class TorqueShape:
    """What a torque of a certain shape would explain.

    Attributes:
        kind: of the shape.
        words: the shape, for the reader.
        evidence: twice the logarithm of by how much it makes the data more likely, of the sizes of a constant torque.
        reduction: of χ², linearised.
        p_value: of as much by chance, times the number of shapes of its kind, and of kinds.
        frequency_hz: of one that oscillates, or comes in pulses; None for others.
        phase: number of the phase of pulses; 0 for others.
    """

    kind: Kind
    words: str
    evidence: float
    reduction: float
    p_value: float
    frequency_hz: float | None = None
    phase: int = 0

    @property
    def key(self) -> tuple[Kind, str, float | None, int]:
        """What the shape is, whatever it explains."""
        return self.kind, self.words, self.frequency_hz, self.phase


@dataclass(frozen=True, kw_only=True, eq=False)
class _Tried:
    kind: Kind
    words: str
    torques: Array
    """At the knots of every run, shape (R, T, F): a function stands for three torques, one on each axis."""
    frequency_hz: float | None = None
    by_run: bool = False
    """Whether every run has amplitudes of its own."""
    phase: int = 0

    @property
    def sizes(self) -> Array:
        """Mean size of what each amplitude is of, shape (3 F,), in the run where it is largest; (R 3 F,) if by run."""
        of_runs = np.mean(np.abs(self.torques), axis=1)
        return np.tile(of_runs, 3).ravel() if self.by_run else np.tile(of_runs.max(axis=0), 3)


def torque_shapes(runs: Runs, fit: Fit) -> tuple[TorqueShape, ...]:
    """Return all shapes that were tried, the one with the most evidence first.

    Args:
        runs: all of them; of their channels the gyro's samples count. An even choice of them where they are very many.
        fit: of the present model to them; what it can absorb is projected out.
    """
    return part(
        "torque shapes",
        (runs, [each.key for each in fit.placed], fit.values, fit.residual),
        work=lambda: _torque_shapes(runs, fit),
        to_content=lambda shapes: {"shapes": [asdict(each) for each in shapes]},
        from_content=lambda content: tuple(TorqueShape(**each) for each in content["shapes"]),
    )


def shape_knots(runs: Runs) -> int:
    """Return the number of knots of a torque of a known shape, the same in every run."""
    return knot_count(runs, _KNOTS_PER_SECOND)


def _torque_shapes(runs: Runs, fit: Fit) -> tuple[TorqueShape, ...]:
    runs, fit = on_enough_runs(runs, fit)
    time = runs.grid.node_time - runs.grid.node_time[:, :1]
    knots = shape_knots(runs)
    at = np.linspace(np.zeros(len(time)), time[:, -1], knots, axis=1)
    space = torque_space(runs, fit, knots)
    tried = [*_slow(at, _rates(runs, fit, at)), *_oscillations(runs, at), *_pulses(runs, at)]
    alike = Counter(each.kind for each in tried)
    typical = BodyTorque.parameters[0].typical_on(runs.mean_moment(fit.theta))
    found = [
        shape
        for some, information, slope in _normals(tried, space)
        for shape in _tested(some, information, slope, alike, runs.noise_freedom, typical)
    ]
    return tuple(sorted(found, key=lambda shape: -shape.evidence))


def evidence_of_any(shapes: Sequence[TorqueShape], tested: int, prior_odds: float) -> float:
    """Return twice the logarithm of the posterior odds of a torque of one of the shapes against none.

    Each kind has the prior of one effect of the library, times the prior odds; its shapes share that equally.

    Args:
        shapes: all that were tried.
        tested: number of hypotheses of the library.
        prior_odds: of each kind against one of these.
    """
    by_kind = groupby(sorted(shapes, key=lambda shape: shape.kind), key=lambda shape: shape.kind)
    averages = [_log_mean_exp([0.5 * shape.evidence for shape in group]) for _, group in by_kind]
    return 2.0 * float(logsumexp(averages)) - 2.0 * log(tested / prior_odds)


def no_better_than_together(
    alone: Sequence[TorqueShape], beside: Sequence[TorqueShape], by_effects: float
) -> tuple[TorqueShape, ...]:
    """Return shapes with the evidence of what they can explain: not more than effects and the same shape together.

    By what it seems to explain beyond that, a linearisation errs, as it does by a share of a misfit of very many sigma.

    Args:
        alone: tested against the model without the effects.
        beside: the same shapes against the model with them.
        by_effects: by how much the effects reduce χ².
    """
    further = {each.key: each.reduction for each in beside}
    too_much = [each.reduction - by_effects - further[each.key] for each in alone]
    pairs = zip(alone, too_much, strict=True)
    return tuple(replace(each, evidence=each.evidence - max(excess, 0.0)) for each, excess in pairs)


def _log_mean_exp(values: Sequence[float]) -> float:
    return float(logsumexp(values)) - log(len(values))


def _slow(time: Array, rates: Array) -> Iterator[_Tried]:
    yield _Tried(kind="growing", words="grows in proportion to the time since the start", torques=time[..., None])
    products = [rates[..., i] * rates[..., j] for i, j in combinations_with_replacement(range(3), 2)]
    yield _Tried(kind="product of rates", words="follows products of body rates", torques=np.stack(products, axis=-1))


def _oscillations(runs: Runs, time: Array) -> Iterator[_Tried]:
    """Yield sines whose phase, from the start of a run, is the same in all runs, and sines with phases of their own."""
    longest = float(time.max())
    fastest = fastest_oscillation(gyro_rate_of(runs))
    for frequency in np.arange(1.0 / longest, fastest, SETTINGS.frequency_resolution / longest):
        waves = np.exp(2j * np.pi * frequency * time)
        together = np.stack([waves.real, waves.imag], axis=-1)
        resolved = frequency * longest >= SETTINGS.resolved_periods
        words = (
            f"oscillates at {frequency:.2f} Hz" if resolved else f"bends once over {_stretches_words(runs, longest)}"
        )
        shown = float(frequency) if resolved else None
        yield _Tried(kind="oscillation", words=words, torques=together, frequency_hz=shown)
        yield _Tried(
            kind="oscillation of every run's own",
            words=f"{words}, in no step between runs",
            torques=together,
            frequency_hz=shown,
            by_run=True,
        )


def _stretches_words(runs: Runs, longest: float) -> str:
    """Say what a slow shape bends over: its frequency would be that of the stretches, whatever the torque does."""
    return f"{'a window' if runs.windowed else 'a run'} of {longest:.3g} s, so that its frequency is not resolved"


def _pulses(runs: Runs, time: Array) -> Iterator[_Tried]:
    """Yield equal impulses at equal intervals, two at least in the longest run, at the same instants of all runs."""
    longest = float(time.max())
    fastest = min(SETTINGS.fastest_pulses_hz, SETTINGS.pulses_share_of_rate * gyro_rate_of(runs))
    for frequency in np.arange(2.0 / longest, fastest, SETTINGS.frequency_resolution / longest):
        for phase in range(SETTINGS.pulse_phases):
            impulses = np.arange(phase / SETTINGS.pulse_phases, longest * frequency) / frequency
            words = f"comes in a pulse every {1.0 / frequency:.2f} s"
            torques = np.stack([_hats(at, impulses) for at in time])[..., None]
            yield _Tried(kind="pulses", words=words, torques=torques, frequency_hz=float(frequency), phase=phase)


def _hats(knots: Array, instants: Array) -> Array:
    """Return the weights at evenly spaced knots of impulses at instants; those behind the last knot are left out."""
    place = instants[instants < knots[-1]] / (knots[1] - knots[0])
    size = len(knots)
    before = np.minimum(place.astype(int), size - 2)
    share = place - before
    return np.asarray(np.bincount(before, 1.0 - share, size) + np.bincount(before + 1, share, size), dtype=np.float64)


def _rates(runs: Runs, fit: Fit, time: Array) -> Array:
    """Return the predicted body rate at the knots, shape (R, T, 3), rad/s; about an axis that is held, zero."""
    nodes = node_rates(runs.grid, [each.hooks for each in fit.placed], fit.values)[:, 0]
    from_start = runs.grid.node_time - runs.grid.node_time[:, :1]
    return np.stack(
        [
            np.stack([np.interp(at, own, axis) for axis in rate.T], axis=-1)
            for at, own, rate in zip(time, from_start, nodes * runs.live[:, None], strict=True)
        ]
    )


def _normals(tried: Sequence[_Tried], space: TorqueSpace) -> Iterator[tuple[list[_Tried], Array, Array]]:
    """Yield shapes with as many amplitudes C each, their information, shape (shapes, C, C), and slope, (shapes, C)."""
    for first in range(0, len(tried), AT_ONCE):
        some = tried[first : first + AT_ONCE]
        # The same functions come twice: all runs share their amplitudes, or have their own.
        distinct = {id(each.torques): each.torques for each in some}
        together = space.about_axes(np.concatenate(list(distinct.values()), axis=-1))
        ends = np.cumsum([0, *(each.shape[-1] for each in distinct.values())]).tolist()
        place = dict(zip(distinct, pairwise(ends), strict=True))
        forms: dict[tuple[bool, int], list[_Tried]] = {}
        for each in some:
            forms.setdefault((each.by_run, each.torques.shape[-1]), []).append(each)
        for (by_run, _), own in forms.items():
            which = np.array([range(*place[id(each.torques)]) for each in own])
            yield own, *(normal_by_run if by_run else normal)([run.chosen(which) for run in together])


def _tested(
    tried: Sequence[_Tried],
    information: Array,
    slope: Array,
    alike: Mapping[Kind, int],
    noise_freedom: float,
    typical: float,
) -> Iterator[TorqueShape]:
    """Yield what shapes explain; the mean size of each is typically as large as a constant torque, N·m.

    Quick pulses and the constant torque that they amount to are then as probable a priori: of each other's root mean
    square, pulses would be the smaller torques, and would be taken for every constant one below its typical size.

    Args:
        tried: shapes with as many amplitudes each.
        information: of their amplitudes, shape (shapes, C, C).
        slope: of the log-likelihood, shape (shapes, C).
        alike: number of all shapes of each kind.
        noise_freedom: degrees of freedom with which the noise is known.
        typical: size of a constant torque, N·m.
    """
    # What is zero throughout, such as a product with the rate about an axis that a bearing holds, has no amplitude.
    sizes = np.array([np.where(each.sizes > 0.0, each.sizes, np.inf) for each in tried])
    evidence = evidences(typical / sizes, *independent(information, slope))
    for each, square, freedom, own in zip(tried, *squares_within(information, slope), evidence, strict=True):
        shapes = len(alike) * alike[each.kind]
        by_chance = exp(min(0.0, log(shapes) + log_p_value(square, freedom, noise_freedom))) if freedom else 1.0
        yield TorqueShape(
            kind=each.kind,
            words=each.words,
            evidence=float(own),
            reduction=float(square),
            p_value=by_chance,
            frequency_hz=each.frequency_hz,
            phase=each.phase,
        )


def most_probable(shapes: Sequence[TorqueShape], p_value: float) -> TorqueShape | None:
    """Return the shape with the highest posterior odds among the significant ones; None if there is none.

    Args:
        shapes: all that were tried; those of a kind share its prior.
        p_value: below which a shape is significant.
    """
    alike = Counter(shape.kind for shape in shapes)
    significant = [shape for shape in shapes if shape.p_value < p_value]
    return max(significant, key=lambda shape: shape.evidence - 2.0 * log(alike[shape.kind]), default=None)
