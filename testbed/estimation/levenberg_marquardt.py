"""Nonlinear least squares of many small problems side by side, each as if it were alone.

The steps, the trust region and the tests are those of MINPACK's `lmder` with its own scaling: what a problem answers
depends on no other. A problem leaves as soon as it has its minimum.

Source: J. J. Moré, The Levenberg-Marquardt algorithm: implementation and theory, Lecture Notes in Mathematics 630
(1978).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from testbed.arrays import Array, Flags, Indices

TOLERANCE = 1e-8
"""Relative: of the sum of squares, of the unknowns, and of the cosine between residual and columns."""
_FIRST_RADIUS = 100.0
"""Of the first trust region, in scaled lengths of the start. Source: MINPACK, `factor`."""
_ENOUGH = 1e-4
"""Share of the predicted reduction from which a trial is taken."""
_MISSED = 0.1
"""Share of the radius by which a step may be longer than it, or a damped one off it."""
_DAMPINGS = 10
"""Most that are tried for one step."""
_TRIALS = 100
"""Most evaluations for each unknown, beyond which there is no minimum."""


@dataclass(kw_only=True)
class Searches:
    """Where F searches are.

    Attributes:
        unknowns: shape (F, P).
        residual: shape (F, R).
        size: its length, shape (F,).
        rounds: evaluations of the columns, shape (F,).
        trials: evaluations of the residual, shape (F,).
        found: whether the search is at a minimum, shape (F,).
        columns: at the end of the searches, shape (F, R, P).
        triangle: R of the columns' Q R, shape (F, P, P).
        image: Qᵀ r, shape (F, P).
        scale: of the unknowns, shape (F, P).
        radius: of the trust region, in scaled unknowns, shape (F,).
        damping: λ of the last step, shape (F,).
    """

    unknowns: Array
    residual: Array
    size: Array
    rounds: Indices
    trials: Indices
    found: Flags
    columns: Array
    triangle: Array
    image: Array
    scale: Array
    radius: Array
    damping: Array


def minima(
    start: Array, residual: Callable[[Array, Indices], Array], columns: Callable[[Array, Indices], Array]
) -> Searches:
    """Minimise the squares of F residuals, each over its own P unknowns.

    Args:
        start: unknowns to start from, shape (F, P).
        residual: r of unknowns of shape (A, P), of the problems whose A indices it is given, shape (A, R).
        columns: ∂r/∂(unknowns), shape (A, R, P), likewise.

    Returns:
        The searches at their ends.
    """
    problems, unknowns = start.shape
    at, every = _begun(start, residual(start, np.arange(problems))), np.arange(problems)
    moved = going = every
    while going.size:
        if moved.size:
            _look(at, moved, columns(at.unknowns[moved], moved))
            going = going[~at.found[going]]
        if going.size:
            step = _step(at, going)
            trial = at.unknowns[going] - step
            taken = _judge(at, going, step, residual(trial, going))
            moved = going[taken & ~at.found[going]]
            going = going[~at.found[going] & (at.trials[going] < _TRIALS * unknowns)]
            moved = moved[at.trials[moved] < _TRIALS * unknowns]
    at.columns = columns(at.unknowns, every)
    return at


def _begun(start: Array, residual: Array) -> Searches:
    problems, unknowns = start.shape
    return Searches(
        unknowns=start.copy(),
        residual=residual.copy(),
        size=np.linalg.norm(residual, axis=1),
        rounds=np.zeros(problems, dtype=np.intp),
        trials=np.ones(problems, dtype=np.intp),
        found=np.zeros(problems, dtype=np.bool_),
        columns=np.zeros((problems, 0, unknowns)),
        triangle=np.zeros((problems, unknowns, unknowns)),
        image=np.zeros((problems, unknowns)),
        scale=np.zeros((problems, unknowns)),
        radius=np.zeros(problems),
        damping=np.zeros(problems),
    )


def _look(at: Searches, which: Indices, columns: Array) -> None:
    """Take in the columns where some of the searches have moved to; a residual normal to all of them is a minimum."""
    first = at.rounds[which] == 0
    at.rounds[which] += 1
    turned, triangle = np.linalg.qr(columns)
    image = np.matvec(turned.mT, at.residual[which])
    lengths = np.linalg.norm(columns, axis=1)
    at.triangle[which], at.image[which] = triangle, image
    at.scale[which] = np.maximum(at.scale[which], np.where((lengths == 0.0) & first[:, None], 1.0, lengths))
    begun = which[first]
    lengths_of_start = np.linalg.norm(at.scale[begun] * at.unknowns[begun], axis=1)
    at.radius[begun] = _FIRST_RADIUS * np.where(lengths_of_start == 0.0, 1.0, lengths_of_start)
    across = np.abs(np.matvec(triangle.mT, image))
    at.found[which] = (across <= TOLERANCE * lengths * at.size[which, None]).all(axis=1)


def _step(at: Searches, which: Indices) -> Array:
    """Return by how much the unknowns are to go down, shape (A, P): damped where they would leave the trust region."""
    step = np.asarray(np.linalg.solve(at.triangle[which], at.image[which, :, None])[..., 0], dtype=np.float64)
    length = np.linalg.norm(at.scale[which] * step, axis=1)
    inside = length <= (1.0 + _MISSED) * at.radius[which]
    at.damping[which[inside]] = 0.0
    for row in np.flatnonzero(~inside):
        step[row] = _damped(at, which[row], step[row])
    return step


def _damped(at: Searches, problem: int, step: Array) -> Array:
    """Return the step that minimises |r - J p|² + λ |D p|² with |D p| near the radius, and keep its λ.

    Args:
        at: the searches.
        problem: which of them.
        step: without damping, shape (P,).
    """
    triangle, image, scale = at.triangle[problem], at.image[problem], at.scale[problem]
    radius, damping = at.radius[problem], at.damping[problem]
    length, unknowns = float(np.linalg.norm(scale * step)), len(step)
    beyond = length - radius
    least = beyond / radius / _slope(triangle, scale, step, length) ** 2
    gradient = np.linalg.norm((triangle.T @ image) / scale)
    most = gradient / radius
    damping = min(max(damping, least), most) or gradient / length
    for trial in range(_DAMPINGS):
        damping = damping or 1e-3 * most
        turned, damped = np.linalg.qr(np.vstack([triangle, np.diag(np.sqrt(damping) * scale)]))
        step = np.linalg.solve(damped, turned[:unknowns].T @ image)
        length = float(np.linalg.norm(scale * step))
        beyond = length - radius
        if abs(beyond) <= _MISSED * radius or trial == _DAMPINGS - 1:
            break
        least, most = (max(least, damping), most) if beyond > 0.0 else (least, min(most, damping))
        damping = max(least, damping + beyond / radius / _slope(damped, scale, step, length) ** 2)
    at.damping[problem] = damping
    return step


def _slope(triangle: Array, scale: Array, step: Array, length: float) -> float:
    """Return |R⁻ᵀ D² p| / |D p|, from which Newton's correction of λ follows."""
    return float(np.linalg.norm(np.linalg.solve(triangle.T, scale * (scale * step) / length)))


def _judge(at: Searches, which: Indices, step: Array, residual: Array) -> Flags:
    """Take the trials that reduce the squares as predicted, and fit the trust regions; return which were taken."""
    before, size, damping = at.size[which], np.linalg.norm(residual, axis=1), at.damping[which]
    length = np.linalg.norm(at.scale[which] * step, axis=1)
    at.trials[which] += 1
    radius = np.where(at.rounds[which] == 1, np.minimum(at.radius[which], length), at.radius[which])
    with np.errstate(divide="ignore", invalid="ignore"):  # of residuals that are zero
        actual = np.where(_MISSED * size < before, 1.0 - (size / before) ** 2, -1.0)
        linear = (np.linalg.norm(np.matvec(at.triangle[which], step), axis=1) / before) ** 2
        damped = damping * (length / before) ** 2
        predicted = linear + 2.0 * damped
        ratio = np.where(predicted == 0.0, 0.0, actual / predicted)
        shrunk = np.where(actual >= 0.0, 0.5, 0.5 * (linear + damped) / (linear + damped - 0.5 * actual))
    shrunk = np.where((_MISSED * size >= before) | (shrunk < _MISSED), _MISSED, shrunk)
    poor, good = ratio <= 0.25, (damping == 0.0) | (ratio >= 0.75)
    at.radius[which] = np.where(
        poor, shrunk * np.minimum(radius, length / _MISSED), np.where(good, 2.0 * length, radius)
    )
    at.damping[which] = np.where(poor, damping / shrunk, np.where(good, 0.5 * damping, damping))
    taken = ratio >= _ENOUGH
    moved = which[taken]
    at.unknowns[moved] -= step[taken]
    at.residual[moved], at.size[moved] = residual[taken], size[taken]
    reach = np.linalg.norm(at.scale[which] * at.unknowns[which], axis=1)
    settled = (np.abs(actual) <= TOLERANCE) & (predicted <= TOLERANCE) & (ratio <= 2.0)
    at.found[which] = settled | (at.radius[which] <= TOLERANCE * reach)
    return np.asarray(taken)
