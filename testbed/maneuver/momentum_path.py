"""The total momentum in body axes along a motion of the actuators, as an expression of its control points.

L = J(d) ω + h turns with L̇ = -ω × L and keeps its length. Three numbers, so no attitude is needed; and where L starts
at zero it stays there, so nothing is integrated.
"""

from __future__ import annotations

import casadi as ca
import numpy as np

from testbed.arrays import Series
from testbed.maneuver.cluster_motion import body_rate_function
from testbed.maneuver.design import DesignProblem
from testbed.maneuver.splines import basis_matrix

_NEGLIGIBLE = 1e-6
"""Share of the rotors' momentum, about 1e-6 rad/s of body rate on the nominal platform: such a rest is held fixed."""


def total_momentum(problem: DesignProblem, points: ca.MX, time: Series) -> ca.MX:
    """Return L at given times, shape (3, N), N·m·s, body axes, by Runge-Kutta steps between them.

    Args:
        problem: platform and start.
        points: control points of the motion, shape (n, M + W), rad and shares of momentum limits.
        time: shape (N,), s, from 0.
    """
    start = problem.total_momentum_B
    if rests_without_momentum(problem):
        return ca.MX(np.tile(start[:, None], len(time)))
    middle = (time[:-1] + time[1:]) / 2.0
    at = [sampled(problem, points, grid, order) for grid in (time[:-1], middle, time[1:]) for order in (0, 1)]
    later = _step_function(problem).mapaccum(len(middle))(start, *at, np.diff(time)[None])
    return ca.horzcat(start, later)


def rests_without_momentum(problem: DesignProblem) -> bool:
    """Return whether a maneuver starts, and so stays, without total momentum."""
    return bool(np.linalg.norm(problem.total_momentum_B) <= _NEGLIGIBLE * problem.held_momentum)


def sampled(problem: DesignProblem, points: ca.MX, time: Series, derivative: int) -> ca.MX:
    """Return the actuators' motion, or a derivative, at given times, shape (M + W, N).

    Args:
        problem: duration.
        points: control points, shape (n, M + W), rad and shares of momentum limits.
        time: shape (N,), s.
        derivative: its order.
    """
    basis = basis_matrix(problem.duration, problem.control_points, time, derivative)
    return (ca.sparsify(ca.DM(basis)) @ points).T


def _step_function(problem: DesignProblem) -> ca.Function:
    """One classical Runge-Kutta step of L, given angles and rates at its start, middle and end."""
    body_rate = body_rate_function(problem.actuators, problem.inertia)
    total, step = ca.SX.sym("total", 3), ca.SX.sym("step")
    count = problem.actuators.count
    start, middle, end = (tuple(ca.SX.sym(name, count) for name in ("motion", "rate")) for _ in range(3))

    def slope(at: tuple[ca.SX, ...], value: ca.SX) -> ca.SX:
        return -ca.cross(body_rate(*at, value), value)

    first = slope(start, total)
    second = slope(middle, total + step / 2.0 * first)
    third = slope(middle, total + step / 2.0 * second)
    fourth = slope(end, total + step * third)
    after = total + step / 6.0 * (first + 2.0 * second + 2.0 * third + fourth)
    return ca.Function("step", [total, *start, *middle, *end, step], [after])
