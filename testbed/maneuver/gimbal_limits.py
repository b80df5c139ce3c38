"""The limits of a design of gimbal angles and wheel momenta as constraints."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike, NDArray

from testbed.arrays import Series
from testbed.maneuver.cluster_motion import MOTION_OUTPUTS, has_envelope, motion_function
from testbed.maneuver.design import DesignProblem, GimbalLimits
from testbed.maneuver.formulation import SplinePoints
from testbed.maneuver.instants import Instants, at_instants
from testbed.maneuver.momentum_path import sampled
from testbed.maneuver.program import Constraint, within
from testbed.maneuver.splines import derivative_points_matrix

_CHECKS_PER_KNOT = 4
_CHECKS_PER_SECOND, _CHECKS_PER_RADIAN = 12.0, 7.5
"""Instants at which limits without a convex hull are kept: by the knot, or by the second, whichever are more; of slow
gimbals by the radian that they can turn instead. Between them the nominal designs bend torque, envelope and body rate
by less than 2 %, and a narrow dip of the singularity measure by 10 %."""


def hull_limits(problem: DesignProblem, limits: GimbalLimits, points: ca.MX) -> tuple[Constraint, ...]:
    """Bound the control points of ḋ, d̈ and the wheels' momenta; the convex hull property bounds the curves.

    Args:
        problem: duration.
        limits: of gimbal rate, acceleration and wheel momentum.
        points: of the motion, shape (n, M + W), rad and shares of momentum limits.
    """
    angles, shares = points[:, : problem.actuators.units], points[:, problem.actuators.units :]
    rate, acceleration = (
        ca.sparsify(ca.DM(derivative_points_matrix(problem.duration, problem.control_points, order))) @ angles
        for order in (1, 2)
    )
    return tuple(
        _finite(
            ("gimbal rate", rate, limits.gimbal_rate),
            ("gimbal acceleration", acceleration, limits.gimbal_acceleration),
            ("wheel momentum", shares, limits.wheel_momentum_fraction),
        )
    )


def path_limits(
    problem: DesignProblem, limits: GimbalLimits, points: SplinePoints, path_time: Series, total: ca.MX
) -> tuple[Constraint, ...]:
    """Keep what is not linear in the control points at a few instants of each knot interval, and rest at the end.

    Args:
        problem: platform and duration.
        limits: what to keep.
        points: of the motion, n rows of M + W, rad and shares of momentum limits.
        path_time: shape (N,), s, ends with the duration.
        total: L at these times, shape (3, N), N·m·s, body axes.
    """
    checked = _checked(problem, limits, len(path_time))
    motion = motion_function(problem.actuators, problem.inertia, limits.wheel_friction)
    curves = [sampled(problem, points.rows, path_time[checked], order) for order in (0, 1, 2)]
    instants = at_instants(motion, [*curves, total[:, checked.tolist()]], points.free)
    rows = [motion.size1_out(index) for index in range(motion.n_out())]
    outputs = ca.MX.sym("outputs", sum(rows), len(checked))
    named = zip(MOTION_OUTPUTS, ca.vertsplit(outputs, np.cumsum([0, *rows]).tolist()), strict=True)
    values = {name: output.T for name, output in named}
    of_outputs = (
        *_finite(
            ("body rate", values["body_rate"], limits.body_rate),
            ("cluster momentum", values["momentum"], limits.cluster_momentum),
            ("cluster torque", values["momentum_rate"], limits.cluster_torque),
            ("gimbal torque", values["gimbal_torque"], limits.gimbal_torque),
            ("wheel torque", values["wheel_torque"], limits.wheel_torque_fraction),
        ),
        *_envelope(values["envelope_share"], limits.envelope_fraction if has_envelope(problem.actuators) else 1.0),
        *_dexterity(values["dexterity"], limits.min_singularity_measure),
        _rest(problem, values["excess"][-1, :]),
    )
    return tuple(_of_motion(limit, outputs, instants) for limit in of_outputs)


def _of_motion(limit: Constraint, outputs: ca.MX, instants: Instants) -> Constraint:
    """Return a limit of the motion: it is linear in the outputs, and its Jacobian follows from theirs."""
    shares = ca.evalf(ca.jacobian(limit.expression, outputs))
    return replace(limit, expression=shares @ instants.values, jacobian=shares @ instants.jacobian)


def _checked(problem: DesignProblem, limits: GimbalLimits, path_length: int) -> NDArray[np.int_]:
    """Indices into the path, both ends included."""
    by_knot = (problem.control_points - 3) * _CHECKS_PER_KNOT
    per_second = min(_CHECKS_PER_SECOND, _CHECKS_PER_RADIAN * limits.gimbal_rate)
    intervals = max(by_knot, int(np.ceil(per_second * problem.duration - 1e-9)))  # 1e-9: rounding must not add one
    return np.unique(np.linspace(0, path_length - 1, intervals + 1).round().astype(int))


def _envelope(share: ca.MX, fraction: float) -> Iterator[Constraint]:
    """Keep a margin to the envelope; within all of it the cluster is anyway."""
    if fraction < 1.0:
        yield Constraint(name="momentum envelope", expression=share / fraction, lower=-np.inf, upper=1.0)


def _dexterity(dexterity: ca.MX, measure: float) -> Iterator[Constraint]:
    """Keep the singularity measure above its floor, both squared to stay smooth."""
    if measure > 0.0:
        share = dexterity / measure**2
        yield Constraint(name="singularity measure, squared,", expression=share, lower=1.0, upper=np.inf)


def _rest(problem: DesignProblem, excess: ca.MX) -> Constraint:
    """All momentum in the actuators at the end: the platform rests."""
    share = excess.T / problem.held_momentum
    return Constraint(name="rest at the end", expression=share, lower=0.0, upper=0.0)


def _finite(*limits: tuple[str, ca.MX, ArrayLike]) -> Iterator[Constraint]:
    """Leave out infinite limits, which would only cost time, and those of actuators that are not there."""
    return (within(name, curve, limit) for name, curve, limit in limits if curve.numel() and np.all(np.isfinite(limit)))
