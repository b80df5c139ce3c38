"""What torque a body is under that nobody commanded, from the residuals of many short windows.

Draughts, propellers and motors that do not do quite what they are asked turn a body by more than a gyro's noise. Of a
window whose initial rate is free, the rate's residual at the time t after its first sample has the covariance

    C(t, t') = s² δ(t, t') + q² min(t, t') + a² t t'

per axis: white noise of the samples, an angular acceleration that is white, and one that is constant in the window.
Source: Maybeck, "Stochastic Models, Estimation, and Control", vol. 1 (1979), section 4.5, for the second term.
"""

# What is compiled has no annotations: the signatures state the types.
# mypy: disallow-untyped-defs=False, disallow-untyped-calls=False
# ruff: noqa: ANN001, ANN202

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from testbed.arrays import Array, Series
from testbed.compiled import kept

_LEAST = 0.05
"""Share of the largest part of the scatter of single samples that their white noise has at least: it keeps covariances
away from singular ones, and is far below what the fastest changes of any gyro show."""
_STARTS = ((0.9, 0.3, 0.3), (0.3, 0.9, 0.3))
"""Shares of the scatter that the three parts begin with; both lead to the same end where the windows show it."""
_EVALUATIONS = 400
"""Of the likelihood at most: three unknowns are found to per cents in about 150."""


def torque_noise(times: Sequence[Series], residuals: Sequence[Array]) -> Array:
    """Return s, rad/s, q, rad/s per √s, and a, rad/s², of each axis by maximum likelihood, shape (3, 3).

    Args:
        times: of the samples of every window, shapes (N,), s; windows of the most frequent length are used.
        residuals: of the body rate in each, shapes (N, 3), rad/s.
    """
    lengths = [len(time) for time in times]
    usual = max(set(lengths), key=lengths.count)
    windows = np.stack([residual for residual in residuals if len(residual) == usual])
    time = np.median([time - time[0] for time in times if len(time) == usual], axis=0)
    # Contrasts, which no initial rate changes.
    contrasts = np.linalg.svd(np.ones((1, usual)))[2][1:]
    parts = [contrasts @ part @ contrasts.T for part in _parts(time)]
    return np.stack([_of_axis(parts, contrasts @ windows[:, :, axis].T, time) for axis in range(3)])


def covariance(time: Series, noise: Array) -> Array:
    """Return C of one window for every axis, shape (3, N, N), (rad/s)².

    Args:
        time: of its samples, shape (N,), s.
        noise: as `torque_noise`, shape (3, 3).
    """
    return np.asarray(np.einsum("ak,kmn->amn", noise**2, np.stack(_parts(time - time[0]))))


def _parts(time: Series) -> list[Array]:
    return [np.eye(len(time)), np.minimum.outer(time, time), np.outer(time, time)]


def _of_axis(parts: Sequence[Array], samples: Array, time: Series) -> Array:
    """Return s, q and a from contrasts of shape (N - 1, W)."""
    triangle: Array = np.asarray(np.linalg.qr(samples.T / np.sqrt(samples.shape[1]), mode="r"))
    root = triangle.T
    whole = float(np.sqrt((root**2).sum() / len(root))) + np.finfo(float).tiny
    scale = whole / np.array([1.0, np.sqrt(time[-1]), time[-1]])
    every, least = np.stack(parts), np.array([(_LEAST * whole) ** 2])
    found = np.empty((len(_STARTS), len(scale) + 1))
    for start, row in zip(_STARTS, found, strict=True):
        kept(_search, _SEARCHED)(np.log(start), scale, every, root, least, row)
    sizes = scale * np.exp(min(found, key=lambda row: float(row[-1]))[:-1])
    sizes[0] = np.hypot(sizes[0], _LEAST * whole)
    return np.asarray(sizes)


_SEARCHED = (("f8", 1), ("f8", 1), ("f8", 3), ("f8", 2), ("f8", 1), ("f8", 1))
"""Kinds of numbers and numbers of axes."""
_BEGIN = 1.05
"""Factor of one coordinate after the other by which the first simplex begins, as in SciPy."""
_SMALL = 1e-4
"""Size of the simplex in every logarithm, and difference of the function over it, below which the search ends."""


def _search(start, scale, parts, root, least, found):
    """Fill in the logarithms of the sizes of the parts, in scale, that surprise the least, and by how much they do.

    The simplex method: Nelder and Mead, "A simplex method for function minimization", Computer Journal (1965).
    """
    size = len(start)
    model, white = np.empty((len(root), len(root))), np.empty(len(root))
    points, values = np.empty((size + 1, size)), np.empty(size + 1)
    for corner in range(size + 1):
        points[corner] = start
        if corner:
            points[corner, corner - 1] *= _BEGIN
        values[corner] = _surprise(points[corner], scale, parts, root, least[0], model, white)
    calls = size + 1
    while True:
        order = np.argsort(values)
        points, values = points[order], values[order]
        if calls >= _EVALUATIONS or _is_small(points, values):
            break
        middle, worst = (points[:-1].sum(axis=0)) / size, points[-1].copy()
        there = 2.0 * middle - worst
        value = _surprise(there, scale, parts, root, least[0], model, white)
        calls += 1
        if values[0] <= value < values[-2]:
            points[-1], values[-1] = there, value
        else:
            better, bound = value < values[0], min(value, values[-1])
            share = 2.0 if better else 0.5 if value < values[-1] else -0.5
            other = (1.0 + share) * middle - share * worst
            tried = _surprise(other, scale, parts, root, least[0], model, white)
            calls += 1
            if tried < bound:
                points[-1], values[-1] = other, tried
            elif better:
                points[-1], values[-1] = there, value
            else:
                for corner in range(1, size + 1):
                    points[corner] = 0.5 * (points[0] + points[corner])
                    values[corner] = _surprise(points[corner], scale, parts, root, least[0], model, white)
                calls += size
    found[:-1], found[-1] = points[0], values[0]


def _is_small(points, values):
    return np.abs(points[1:] - points[0]).max() <= _SMALL and np.abs(values[1:] - values[0]).max() <= _SMALL


def _surprise(logarithms, scale, parts, root, least, model, white):
    """Return log det C + tr C⁻¹ Y Yᵀ of C by the sizes of its parts, Y the root of the scatter."""
    squares = (scale * np.exp(logarithms)) ** 2
    surprise = 0.0
    for column in range(len(model)):
        for row in range(column, len(model)):
            entry = least if row == column else 0.0
            for part in range(len(squares)):
                entry += squares[part] * parts[part, row, column]
            for before in range(column):
                entry -= model[row, before] * model[column, before]
            if row == column and not entry > 0.0:
                return np.inf
            model[row, column] = np.sqrt(entry) if row == column else entry / model[column, column]
        surprise += 2.0 * np.log(model[column, column])
    for sample in range(root.shape[1]):
        for row in range(len(model)):
            left = root[row, sample]
            for before in range(row):
                left -= model[row, before] * white[before]
            white[row] = left / model[row, row]
            surprise += white[row] ** 2
    return surprise
