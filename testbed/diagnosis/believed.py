"""What is believed of a model's parameters, as rows of its residual and Jacobian."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TypeAlias

import numpy as np

from testbed.arrays import Array
from testbed.diagnosis.data import Runs
from testbed.dynamics.inertia import slopes_of_log_ratio
from testbed.prediction.integration import Values
from testbed.prediction.prediction import common_size

_Rows: TypeAlias = Iterator[tuple[Array, Array]]


def believed(runs: Runs, keys: Sequence[str], values: Values, width: int) -> tuple[Array, Array]:
    """Return by how many standard deviations parameters fall short of beliefs, (B,), and slopes, (B, width).

    Args:
        runs: with what is believed of inertia, effects, first attitudes and trims.
        keys: of the effects in the model.
        values: one parameter set, P = 1.
        width: number of the model's parameters.
    """
    rows = [*_of_all(runs, keys, values, width), *_of_turns(runs, values, width), *_of_trims(runs, values, width)]
    if not rows:
        return np.zeros(0), np.zeros((0, width))
    return np.concatenate([away for away, _ in rows]), np.concatenate([slopes for _, slopes in rows])


def _of_all(runs: Runs, keys: Sequence[str], values: Values, width: int) -> _Rows:
    """Yield the same of inertia and effects, which all runs share."""
    belief = runs.belief
    if belief is None:
        return
    if 0.0 < belief.log_ratio_std < np.inf:
        logarithm = belief.log_ratio_of(values.theta[0])
        slopes = np.linalg.inv(slopes_of_log_ratio(logarithm, belief.nominal, np.eye(3)))
        std = belief.known_std[:6]
        yield (belief.log_ratio - logarithm) / std, _placed_columns(slopes / std[:, None], 0, width)
    firsts = np.cumsum([6, *(value.shape[1] for value in values.effects)])[:-1]
    for known, mean, std in belief.effects:
        for first, key, value in zip(firsts.tolist(), keys, values.effects, strict=True):
            if key == known:
                yield (mean - value[0]) / std, _placed_columns(np.diag(1.0 / std), first, width)


def _of_turns(runs: Runs, values: Values, width: int) -> _Rows:
    """Yield the same of the turns of first attitudes, which are believed to be none."""
    if values.first_turn is None or runs.first_turn_std is None:
        return
    common = common_size(values.effects)
    for run, (turn, std) in enumerate(zip(values.first_turn[:, 0], runs.first_turn_std, strict=True)):
        yield -turn / std, _placed_columns(np.eye(3) / std, common + runs.own_size * run + 3, width)


def _of_trims(runs: Runs, values: Values, width: int) -> _Rows:
    """Yield the same of the trims; theirs are the last of all rows and columns."""
    belief = runs.belief
    if belief is not None and values.trim is not None and np.isfinite(belief.trim_std).all():
        trims = values.trim[np.unique(runs.trim_of, return_index=True)[1], 0]
        std = np.tile(belief.trim_std, len(trims))
        away = (belief.trim - trims).ravel() / std
        yield away, _placed_columns(np.diag(1.0 / std), width - len(away), width)


def _placed_columns(block: Array, first: int, width: int) -> Array:
    matrix = np.zeros((len(block), width))
    matrix[:, first : first + block.shape[1]] = block
    return matrix
