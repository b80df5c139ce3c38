"""The search for the most likely unknowns of motions, whatever they are."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

import numpy as np

from testbed.arrays import Array, Indices, Regressor, Response, Theta, Vectors3
from testbed.errors import InputError
from testbed.estimation.levenberg_marquardt import Searches, minima
from testbed.estimation.motion import Motion, is_physical

REFUSED = 1e3
"""rad/s; the residual of an inertia that is not tried, larger than any other."""


def most_likely(
    measured_rate: Vectors3,
    start: Array,
    motion: Callable[[Array, Indices], Motion],
    sensitivity: Callable[[Array, Indices, Motion], Regressor],
    whiten: Callable[[Regressor], Regressor],
) -> Searches:
    """Minimise the squares of predicted minus measured rates, Levenberg-Marquardt with analytic sensitivities.

    Args:
        measured_rate: of F flights, shape (F, N, 3), rad/s.
        start: unknowns to start from, shape (F, P).
        motion: that unknowns, shape (A, P), of the flights with given indices predict; InputError where those of any of
            them predict none.
        sensitivity: ∂ω/∂(unknowns), shape (A, 3N, P), of the motion that they predict.
        whiten: what makes the noise white in rows of the samples, shape (A, 3N, C).

    Returns:
        The searches at their ends, all of them at a minimum.

    Raises:
        InputError: no minimum was found of one of them.
    """

    @lru_cache(maxsize=1)  # the residual and its sensitivities are asked for at the same unknowns
    def motion_at(unknowns: bytes, flights: bytes) -> Motion:
        which = np.frombuffer(flights, dtype=np.intp)
        return motion(np.frombuffer(unknowns).reshape(len(which), -1), which)

    def residual(unknowns: Array, flights: Indices) -> Response:
        try:
            rates = motion_at(unknowns.tobytes(), flights.tobytes()).body_rate
        except InputError:  # a trial whose motion runs away is not the answer, nor the end of the search
            if len(flights) == 1:
                return np.full((1, measured_rate[0].size), REFUSED)
            each = zip(unknowns[:, None], flights[:, None], strict=True)
            return np.concatenate([residual(*one) for one in each])
        apart = rates.reshape(measured_rate[flights].shape) - measured_rate[flights]
        return whiten(apart.reshape(len(flights), -1, 1))[..., 0]

    def columns(unknowns: Array, flights: Indices) -> Regressor:
        predicted = motion_at(unknowns.tobytes(), flights.tobytes())
        return whiten(sensitivity(unknowns, flights, predicted).reshape(len(flights), measured_rate[0].size, -1))

    searches = minima(start, residual, columns)
    if not searches.found.all():
        trials = searches.trials[~searches.found].max()
        raise InputError(
            f"output error found no minimum in {trials} evaluations: over the whole record something turns the "
            "platform that no channel holds; use a shorter part (usable_from_s, usable_to_s), set "
            "estimation.constant_torque, or let `testbed diagnose` find what is missing"
        )
    return searches


def require_physical(theta: Theta) -> None:
    """Refuse to predict the motion of what is no body.

    Raises:
        InputError: an inertia, shape (..., 6), does not resist turning about every axis.
    """
    if not is_physical(theta).all():
        raise InputError("no body has this inertia")
