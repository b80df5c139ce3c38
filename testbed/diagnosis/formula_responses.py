"""Every formula of the grammar against a residual, linearised along the predicted motion.

The response to a torque at every knot of every run turns each formula's values along the motion into its signature: two
thousand of them cost no more than a few predictions.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property
from itertools import islice, pairwise
from math import log
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import make_interp_spline

from testbed.arrays import Array
from testbed.diagnosis.data import Runs
from testbed.diagnosis.latent import fastest_oscillation, gyro_rate_of, on_enough_runs
from testbed.diagnosis.model import Fit
from testbed.diagnosis.settings import SETTINGS
from testbed.diagnosis.size_prior import evidences
from testbed.diagnosis.torque_shapes import AT_ONCE, shape_knots
from testbed.diagnosis.torque_space import Moved, TorqueSpace, normal, torque_space
from testbed.effects.body_torque import BodyTorque
from testbed.formulas.grammar import MEMORIES, SCANNED, Class
from testbed.formulas.law import Law, Memory, first_state_of, rate_of, value_of
from testbed.formulas.motion import Moment
from testbed.formulas.pattern import Pattern, Placement, axes_of
from testbed.formulas.torque import Frame
from testbed.prediction.formula_hooks import applied_torque, laid_end_to_end
from testbed.prediction.integration import node_rates
from testbed.rotation.kinematics import integrate_attitude
from testbed.rotation.quaternion import matrix_of

_NARROWEST = 0.5
"""Standard deviation, in the knots' distance, from which on a pulse shows at knots: below, it may lie between two.

Source: formula: between two knots one of half their distance is 0.6 of its height at both; 5 Hz samples and faster ones
show all widths of `SCANNED`."""


_REMEMBERED = 10_000_000
"""Numbers, 80 MB, of what memories make of products with all constants that are integrated side by side."""


@dataclass(frozen=True, kw_only=True)
class FormulaEvidence:
    """A formula at its best start.

    Attributes:
        pattern: the formula.
        evidence: averaged over its starts, its share of the prior included.
        start: values of its constants, shape (constants,).
        starts: number of its start values.
        power: root mean square of each of its laws there, shape (laws,).
    """

    pattern: Pattern
    evidence: float
    start: Array
    starts: int
    power: Array


def formula_evidences(
    runs: Runs, fit: Fit, every: Mapping[Class, tuple[Pattern, ...]], share: Mapping[Pattern, float]
) -> Iterator[FormulaEvidence]:
    """Yield every formula with its evidence by the linearisation alone; of very many runs an even choice counts."""
    runs, fit = on_enough_runs(runs, fit)
    along, knots = Along.of(runs, fit), shape_knots(runs)
    space = torque_space(runs, fit, knots)
    typical = BodyTorque.parameters[0].typical_on(runs.mean_moment(fit.theta))
    alike: dict[tuple[Law, ...], list[Pattern]] = {}
    for pattern in (each for of_class in every.values() for each in of_class):
        alike.setdefault(pattern.laws, []).append(pattern)
    # Patterns by their number of amplitudes, whose evidence is worked out together.
    by_size: dict[int, list[tuple[Pattern, _Start, Array, Array, Array]]] = {}
    constants = _Constants.of(runs, along, knots)
    for valued, columns in _columns(_valued(along, list(alike), constants), along, space, knots):
        normals = {frame: normal(own) for frame, own in columns.items()}
        for pattern in alike[valued.laws]:
            axes = _directions(len(valued.values), pattern.placement)
            information, slope = normals[pattern.frame]
            start = _Start(valued.start, valued.power)  # without its values at all nodes, which would fill a memory
            sizes = np.repeat(typical / start.power, len(pattern.axes))
            tried = (pattern, start, sizes, axes @ information @ axes.T, axes @ slope)
            by_size.setdefault(len(sizes), []).append(tried)
    found: dict[Pattern, list[tuple[float, _Start]]] = {}
    for some in by_size.values():
        of, at, *numbers = zip(*some, strict=True)
        for pattern, start, each in zip(of, at, evidences(*map(np.array, numbers)).tolist(), strict=True):
            found.setdefault(pattern, []).append((each, start))
    for pattern, starts in found.items():
        evidence = np.array([each for each, _ in starts])
        best = starts[int(evidence.argmax())][1]
        mean = 2.0 * (float(np.logaddexp.reduce(0.5 * evidence)) - log(len(evidence)))
        yield FormulaEvidence(
            pattern=pattern,
            evidence=mean + 2.0 * log(share[pattern]),
            start=best.constants,
            starts=len(starts),
            power=best.power,
        )


@cache
def _directions(laws: int, placement: Placement) -> Array:
    """Return what amplitudes of some laws are along the three axes of each, shape (D, 3 * laws)."""
    return np.asarray(np.kron(np.eye(laws), axes_of(placement)))


class _Start(NamedTuple):
    """Where a formula's constants start, shape (constants,), and the power of its laws there, shape (laws,)."""

    constants: Array
    power: Array


@dataclass(frozen=True, kw_only=True, eq=False)
class _Constants:
    """Constants of laws that depend on time alone, as far as samples show them.

    Attributes:
        frequencies: of oscillations, as those of torque shapes with a frequency, Hz.
        pulses: instants and widths of pulses in single runs, the instants as far apart as a pulse is wide, s.
    """

    frequencies: Array
    pulses: tuple[tuple[float, float], ...]

    @staticmethod
    def of(runs: Runs, along: Along, knots: int) -> _Constants:
        """Return those of runs whose torques are linear between so many knots."""
        longest = float(along.time.max())
        slowest, fastest = SETTINGS.resolved_periods / longest, fastest_oscillation(gyro_rate_of(runs))
        narrowest = _NARROWEST * longest / (knots - 1)
        return _Constants(
            frequencies=np.arange(slowest, fastest, SETTINGS.frequency_resolution / longest),
            pulses=tuple(
                (float(instant), width)
                for width in SCANNED["width"]
                if width > narrowest
                for elapsed in along.moment.elapsed
                for instant in np.arange(elapsed[0], elapsed[-1], width)
            ),
        )


@dataclass(frozen=True, kw_only=True, eq=False)
class _Valued:
    """Laws with values for their constants.

    Attributes:
        laws: of a formula.
        start: values of their constants, shape (constants,).
        values: at the nodes, shape (laws, R, N).
    """

    laws: tuple[Law, ...]
    start: Array
    values: Array

    @cached_property
    def power(self) -> Array:
        """Root mean square of each law in the run where it is largest, shape (laws,)."""
        mean = (self.values**2).mean(axis=-1).max(axis=-1)
        return np.asarray(np.sqrt(np.maximum(mean, np.finfo(float).tiny)))


def _valued(along: Along, every: Sequence[tuple[Law, ...]], scanned: _Constants) -> Iterator[_Valued]:
    """Yield laws at each of their start values; those with the same memory are integrated together."""
    for laws in every:
        if not laws[0].names:
            yield _Valued(laws=laws, start=np.zeros(0), values=along.products(laws, {}))
        elif laws[0].names == ("f",):
            for frequency in scanned.frequencies:
                values = along.products(laws, {"f": np.asarray(frequency)})
                yield _Valued(laws=laws, start=np.array([frequency]), values=values)
        elif laws[0].names == ("at", "width"):
            for start in scanned.pulses:
                values = along.products(laws, {"at": np.asarray(start[0]), "width": np.asarray(start[1])})
                yield _Valued(laws=laws, start=np.array(start), values=values)
    for memory, name in MEMORIES.items():
        own = [laws for laws in every if laws[0].memory == memory]
        products = along.products([laws[0] for laws in own], {})
        together = max(_REMEMBERED // max(products.size, 1), 1)
        for first in range(0, len(SCANNED[name]), together):
            constants = np.array(SCANNED[name][first : first + together])
            for constant, kept in zip(constants, _remembered(memory, products, along.time, constants), strict=True):
                yield from (
                    _Valued(laws=laws, start=constant[None], values=values[None])
                    for laws, values in zip(own, kept, strict=True)
                )


def _columns(
    every: Iterator[_Valued], along: Along, space: TorqueSpace, knots: int
) -> Iterator[tuple[_Valued, Mapping[Frame, list[Moved]]]]:
    """Yield what unit torques by laws do to every run, laws * 3 of them, by frame; many are worked out at once."""
    while some := list(islice(every, AT_ONCE)):
        values = np.concatenate([each.values for each in some])
        edges = 3 * np.cumsum([0, *(len(each.values) for each in some)])
        frames: tuple[Frame, Frame] = ("B", "N")
        of_runs = {frame: space.along(along.torques(values, frame, knots)) for frame in frames}
        for each, ends in zip(some, pairwise(edges), strict=True):
            yield each, {frame: [own.rows(slice(*ends)) for own in of_runs[frame]] for frame in frames}


@dataclass(frozen=True, kw_only=True, eq=False)
class Along:
    """What formulas read along the predicted motion of all runs, at the nodes of the grid.

    Attributes:
        time: since the first sample, shape (R, N), s.
        moment: at all nodes, arrays of shape (R, N, ...).
    """

    time: Array
    moment: Moment

    @staticmethod
    def of(runs: Runs, fit: Fit) -> Along:
        """Return the motion that a model predicts."""
        grid = runs.grid
        rates = node_rates(grid, [each.hooks for each in fit.placed], fit.values)[:, 0]
        time = grid.node_time - grid.node_time[:, :1]
        attitude = np.stack([matrix_of(integrate_attitude(own, rate)) for own, rate in zip(time, rates, strict=True)])
        torque_B = applied_torque(grid)[:, 0, ::2]
        elapsed = time + laid_end_to_end(grid)[:, None]
        moment = Moment(time=time, body_rate=rates, attitude=attitude, elapsed=elapsed, applied_torque=torque_B)
        if grid.gimbals is not None:
            angle, rate = (
                np.broadcast_to(each[:, 0, ::2], (*time.shape, each.shape[-1]))
                for each in (grid.gimbals.angle, grid.gimbals.rate)
            )
            moment = replace(moment, gimbal_angle=angle, gimbal_rate=rate)
        return Along(time=time, moment=moment)

    def products(self, laws: Sequence[Law], constants: Mapping[str, Array]) -> Array:
        """Return the laws' products at the nodes, shape (laws, R, N)."""
        return np.stack([np.broadcast_to(law.product(self.moment, constants), self.time.shape) for law in laws])

    def torques(self, values: Array, frame: str, knots: int) -> Array:
        """Return unit torques by laws along three axes at the knots of every run, shape (R, knots, 3, laws * 3)."""
        at = np.linspace(0.0, self.time.shape[1] - 1, knots)
        before = np.minimum(at.astype(int), self.time.shape[1] - 2)
        share = (at - before)[:, None, None]

        def along(nodes: NDArray[np.intp]) -> Array:  # (laws, R, knots, axis, component)
            axes = np.eye(3) if frame == "B" else self.moment.attitude[:, nodes]  # of N: rows of R_AB are the axes in B
            return np.asarray(values[:, :, nodes, None, None] * axes)

        at_knots: Array = (1.0 - share) * along(before) + share * along(before + 1)
        return np.moveaxis(at_knots, (0, 3), (3, 4)).reshape(len(self.time), knots, 3, len(values) * 3)


def _remembered(memory: Memory, product: Array, time: Array, constants: Array) -> Array:
    """Return what a memory makes of products that are known at nodes, for each of its constants.

    Args:
        memory: of what it makes.
        product: shape (laws, R, N).
        time: of the nodes, shape (R, N), s.
        constants: shape (C,).

    Returns:
        Shape (C, laws, R, N).
    """
    constant = constants[:, None, None]
    count = product.shape[-1]
    half = make_interp_spline(np.arange(count), product, k=3, axis=-1)(np.arange(count - 1) + 0.5)
    step = (time[:, 1] - time[:, 0])[None, :, None]
    begun = first_state_of(memory, product[..., 0])
    state = np.broadcast_to(begun, (len(constants), *begun.shape))
    values = [np.broadcast_to(value_of(memory, product[..., 0], begun), state.shape[:-1])]
    for node in range(count - 1):
        first = rate_of(memory, product[..., node], state, constant)
        second = rate_of(memory, half[..., node], state + 0.5 * step * first, constant)
        third = rate_of(memory, half[..., node], state + 0.5 * step * second, constant)
        fourth = rate_of(memory, product[..., node + 1], state + step * third, constant)
        state = state + step / 6.0 * (first + 2.0 * second + 2.0 * third + fourth)
        values.append(value_of(memory, product[..., node + 1], state))
    return np.stack(values, axis=-1)
