"""One step of the twelve-stage Runge-Kutta method of order 8 by Dormand and Prince, on a fixed grid.

The grid ends where the controller changes its mind, so that no step straddles a jump of the right-hand side.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.integrate import DOP853

from concealing.craft import Array

_STAGES, _NODES, _WEIGHTS = DOP853.A, DOP853.C, DOP853.B
REACH = 2.1
"""Largest step times rate of the fastest motion; the method is stable on the negative axis up to about 6."""


def step(derivative: Callable[[float, Array], Array], time: float, state: Array, size: float) -> Array:
    """Return the state one step later.

    Args:
        derivative: of time and state.
        time: at the beginning, s.
        state: any shape.
        size: s.
    """
    slopes = np.empty((len(_NODES), *state.shape))
    flat = slopes.reshape(len(_NODES), -1)
    for stage, node in enumerate(_NODES):
        shift = (_STAGES[stage, :stage] @ flat[:stage]).reshape(state.shape) if stage else 0.0
        slopes[stage] = derivative(time + node * size, state + size * shift)
    return state + size * (_WEIGHTS @ flat).reshape(state.shape)


def steps_for(span: float, fastest: float, refinement: float = 1.0) -> int:
    """Return into how many steps a span is divided, given the fastest rate of any motion, 1/s."""
    return max(1, int(np.ceil(span * fastest * refinement / REACH - 1e-9)))
