"""Design in the actuators' space: B-splines for gimbal angles and wheel momenta, the body rate from conservation.

What is designed can be flown: the actuators' own limits are constraints, and no singularity is met on the way.
"""

from __future__ import annotations

import time
from collections.abc import Callable

import casadi as ca
import numpy as np

from testbed.arrays import Array
from testbed.errors import InputError
from testbed.maneuver.alignment_information import alignment_information
from testbed.maneuver.cluster_motion import body_rate_function
from testbed.maneuver.criteria import Criterion
from testbed.maneuver.design import Design, DesignProblem, GimbalLimits, Parametrization, Search
from testbed.maneuver.formulation import SplinePoints, formulated, prefilter_of
from testbed.maneuver.gimbal_limits import hull_limits, path_limits
from testbed.maneuver.gimbal_maneuver import WheelMotion, gimbal_maneuver
from testbed.maneuver.information import SampledFilter
from testbed.maneuver.momentum_path import rests_without_momentum, sampled, total_momentum
from testbed.maneuver.multistart import best_of_starts, compiled_stages, finished_design
from testbed.maneuver.objective import design_information
from testbed.maneuver.program import Program
from testbed.maneuver.splines import clamped_spline

_FIRST_ANGLES = 1.0
"""rad; random starts draw the control points this far from the initial angles, as wheels in shares of their limits."""

_CURVED: Criterion = "condition"
"""It needs exact second derivatives to converge. The others find the same optima with IPOPT's own approximation in a
tenth to a third of the time (docs/notes/2026-11-21-design.md)."""


def gimbal_design(problem: DesignProblem, limits: GimbalLimits, search: Search) -> Design:
    """Design gimbal angles and wheel momenta, from the initial ones to a platform at rest, all still at both ends.

    Args:
        problem: criterion, duration, platform.
        limits: of gimbals, wheels, cluster and body rate.
        search: starts and seed.

    Raises:
        InfeasibleDesignError: no start kept all limits.
    """
    began = time.perf_counter()
    points = _held_points(problem)
    stages = compiled_stages(problem, lambda criterion: _program(problem, criterion, limits, points))
    setup_seconds = time.perf_counter() - began
    best = best_of_starts(stages, _draw(points), search)
    motion, units = points.values(best.variables), problem.actuators.units
    of_wheels = clamped_spline(problem.duration, motion[:, units:] * problem.wheels.momentum_limit)
    maneuver = gimbal_maneuver(
        problem.name,
        clamped_spline(problem.duration, motion[:, :units]),
        inertia=problem.inertia,
        cluster=problem.cluster,
        total_momentum_B=problem.total_momentum_B,
        wheel_motion=WheelMotion(problem.wheels, of_wheels) if len(problem.wheels.spin_inertia) else None,
    )
    parametrization: Parametrization = "gimbal" if maneuver.wheel_momentum is None else "actuator"
    return finished_design(problem, parametrization, maneuver, best, setup_seconds)


def _held_points(problem: DesignProblem) -> SplinePoints:
    """Hold two points at each end, so that all start as given and stand still at both; failed units do not move."""
    works = np.pad(problem.cluster.rotor_momentum != 0.0, (0, len(problem.wheels.spin_inertia)), constant_values=True)
    working = np.diag(works)[works].astype(float)
    free = ca.MX.sym("motion", problem.control_points - 3, len(working))
    moved = ca.vertcat(np.zeros((2, len(working))), free, free[-1, :])
    home = np.tile(problem.initial_motion, (problem.control_points, 1))
    return SplinePoints(free=ca.vec(free), rows=moved @ ca.sparsify(ca.DM(working)) + home)


def _draw(points: SplinePoints) -> Callable[[np.random.Generator], Array]:
    return lambda rng: rng.uniform(-_FIRST_ANGLES, _FIRST_ANGLES, points.free.numel())


def _program(problem: DesignProblem, criterion: Criterion, limits: GimbalLimits, points: SplinePoints) -> Program:
    sampling = prefilter_of(problem)
    fine_time = sampling.fine_time
    path_time = np.union1d(fine_time, problem.duration)
    total = total_momentum(problem, points.rows, path_time)
    moved, rate = (sampled(problem, points.rows, fine_time, order) for order in (0, 1))
    motion = body_rate_function(problem.actuators, problem.inertia).map(len(fine_time))
    body_rate = motion(moved, rate, total[:, : len(fine_time)]).T
    return formulated(
        criterion,
        _information(problem, sampling, moved, body_rate),
        points=points,
        limits=(
            *hull_limits(problem, limits, points.rows),
            *path_limits(problem, limits, points, path_time, total),
        ),
        hessian="exact" if criterion == _CURVED else "limited-memory",
    )


def _information(problem: DesignProblem, sampling: SampledFilter, angle: ca.MX, body_rate: ca.MX) -> ca.MX:
    if problem.parameters == "inertia":
        return design_information(problem, sampling, body_rate)
    if not rests_without_momentum(problem):
        raise InputError(
            "a design for alignments starts without momentum: at rest, with gimbal angles at which the rotors' momenta "
            "cancel, such as zero"
        )
    return alignment_information(problem.cluster, problem.inertia, sampling, angle, body_rate)
