"""Refinement of a flight's path: distances and limits linearised in the control points, in a trust region.

Each round is a linear program: the smallest margin of all pairs as large as it can be, all limits kept.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import scipy

from testbed.arrays import Array
from testbed.next_experiment.criterion import Choice, DiscriminationCriterion

_ROUNDS = 4
"""Linear programs at most. With six and eight the proposal for case 11 of 14 of seed 90817 is the same; all five
situations of docs/separation.md were resolved with four."""
_RADIUS = (0.3, 0.02)
"""rad, or shares of what wheels and body rates may reach: first and smallest trust region of the control points. A
fifth of the farthest that gimbals' paths are drawn, and four halvings of that."""
_NUDGE = 1e-4
"""rad or shares, for the differences that stand in for derivatives; they then have four correct digits, of which a
trust region needs two."""
_WORTH = 1.05
"""Gain of the smallest margin below which another round is not worth its time."""
_KEPT = 0.99
"""Share of the limits that a linearised step may take: the rest is a margin for the curvature."""


@dataclass(frozen=True, kw_only=True, eq=False)
class _Linearised:
    """Margins and shares of limits at a flight, and their derivatives with respect to its K moves.

    Attributes:
        margins: of separable pairs, shape (Q,).
        margin_slopes: shape (Q, K), 1/rad.
        shares: of the limits, shape (L,).
        share_slopes: shape (L, K), 1/rad.
    """

    margins: Array
    margin_slopes: Array
    shares: Array
    share_slopes: Array


def refined(criterion: DiscriminationCriterion, choice: Choice, progress: Callable[[str], None]) -> Choice:
    """Return a flight at least as good, of the same release, within the limits.

    Args:
        criterion: of flights.
        choice: to start from, within the limits.
        progress: called with what is being done.
    """
    radius = _RADIUS[0]
    for number in range(1, _ROUNDS + 1):
        progress(f"better paths, {number} of {_ROUNDS}")
        model = _linearised(criterion, choice)
        better = _stepped(criterion, choice, model, radius)
        while better is None and radius > _RADIUS[1]:
            radius /= 2.0
            better = _stepped(criterion, choice, model, radius)
        if better is None:
            break
        gain = _smallest(criterion, better) / _smallest(criterion, choice)
        choice = better
        if gain < _WORTH or _smallest(criterion, choice) >= 1.0:
            break
    return choice


def _linearised(criterion: DiscriminationCriterion, choice: Choice) -> _Linearised:
    size = criterion.space.moves(choice.flight).size
    points = _stepped_points(criterion, choice, _NUDGE * np.eye(size))
    moved = criterion.space.flights(choice.flight.release, points)
    margins = _margins(criterion, choice.distances, choice)
    shares = _shares(criterion, choice, np.concatenate([choice.flight.control_points[None], points]))
    return _Linearised(
        margins=margins,
        margin_slopes=(_margins(criterion, criterion.distances(moved), choice) - margins).T / _NUDGE,
        shares=shares[0],
        share_slopes=(shares[1:] - shares[0]).T / _NUDGE,
    )


def _stepped(criterion: DiscriminationCriterion, choice: Choice, model: _Linearised, radius: float) -> Choice | None:
    """Return the flight after the best linear step within a radius; None where it is no better or breaks a limit."""
    working = np.tile(criterion.space.free, len(criterion.space.moves(choice.flight)))
    solved = scipy.optimize.linprog(
        np.append(np.zeros(len(working)), -1.0),  # the last unknown is the smallest margin
        A_ub=np.block(
            [
                [-model.margin_slopes, np.ones((len(model.margins), 1))],
                [model.share_slopes, np.zeros((len(model.shares), 1))],
            ]
        ),
        b_ub=np.concatenate([model.margins, np.maximum(_KEPT, model.shares) - model.shares]),
        bounds=[*((-radius * free, radius * free) for free in working), (None, None)],
    )
    if solved.x is None:
        return None
    points = _stepped_points(criterion, choice, solved.x[None, :-1])
    if _shares(criterion, choice, points).max() > 1.0:
        return None
    (flight,) = criterion.space.flights(choice.flight.release, points)
    trial = replace(choice, flight=flight, distances=criterion.distances([flight])[0])
    return trial if _smallest(criterion, trial) > _smallest(criterion, choice) else None


def _smallest(criterion: DiscriminationCriterion, choice: Choice) -> float:
    return float(_margins(criterion, choice.distances, choice).min())


def _margins(criterion: DiscriminationCriterion, distances: Array, choice: Choice) -> Array:
    """Return the distances of separable pairs in shares of what is wanted, shape (..., Q)."""
    return np.asarray((distances / criterion.wanted)[..., choice.separable])


def _shares(criterion: DiscriminationCriterion, choice: Choice, points: Array) -> Array:
    return criterion.space.shares(choice.flight.release, points)


def _stepped_points(criterion: DiscriminationCriterion, choice: Choice, steps: Array) -> Array:
    """Return the control points after steps of all moves, shape (F, n, K), of steps of shape (F, m K)."""
    moves = criterion.space.moves(choice.flight)
    return criterion.space.points(choice.flight.release, moves + steps.reshape(-1, *moves.shape))
