"""The search for the most likely unknowns of a motion, whatever they are."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from functools import lru_cache

import numpy as np
import scipy

from testbed.arrays import Array, Regressor, Response, Theta, Vectors3
from testbed.errors import InputError
from testbed.estimation.motion import Motion, is_physical

REFUSED = 1e3
"""rad/s; the residual of an inertia that is not tried, larger than any other."""


def most_likely(
    measured_rate: Vectors3,
    start: Array,
    motion: Callable[[Array], Motion],
    sensitivity: Callable[[Array, Motion], Regressor],
) -> scipy.optimize.OptimizeResult:
    """Minimise the squares of predicted minus measured rates, Levenberg-Marquardt with analytic sensitivities.

    Args:
        measured_rate: shape (N, 3), rad/s.
        start: unknowns to start from, shape (P,).
        motion: that unknowns predict; InputError where they predict none.
        sensitivity: ∂ω/∂(unknowns), shape (3N, P), of the motion that they predict.

    Raises:
        InputError: no minimum was found.
    """

    @lru_cache(maxsize=1)  # the residual and its sensitivities are asked for at the same unknowns
    def motion_at(unknowns: bytes) -> Motion:
        return motion(np.frombuffer(unknowns))

    def residual(unknowns: Array) -> Response:
        with suppress(InputError):  # a trial whose motion runs away is not the answer, nor the end of the search
            return np.asarray((motion_at(unknowns.tobytes()).body_rate - measured_rate).ravel())
        return np.full(measured_rate.size, REFUSED)

    def columns(unknowns: Array) -> Regressor:
        return sensitivity(unknowns, motion_at(unknowns.tobytes()))

    answer = scipy.optimize.least_squares(residual, start, columns, method="lm", x_scale="jac")
    if not answer.success:
        raise InputError(f"output error found no minimum in {answer.nfev} evaluations; look at the record's residuals")
    return answer


def require_physical(theta: Theta) -> None:
    """Refuse to predict the motion of what is no body.

    Raises:
        InputError: the inertia does not resist turning about every axis.
    """
    if not is_physical(theta):
        raise InputError("no body has this inertia")
