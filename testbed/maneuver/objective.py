"""The information matrix whose criterion a design optimises: its metric and its scaling.

The paper's metric is Ψ_fᵀΨ_f behind the prefilter, as if the torque equation's noise were white. The gyro's noise is
white in the body rate, and the momentum equation keeps it so: its information, inverted, is the Cramér-Rao bound.
"""

from __future__ import annotations

import casadi as ca
import numpy as np

from testbed.arrays import Matrix3
from testbed.dynamics.inertia import momentum_regressor
from testbed.maneuver.criteria import information_matrix
from testbed.maneuver.design import DesignProblem
from testbed.maneuver.information import SampledFilter


def design_information(problem: DesignProblem, sampling: SampledFilter, body_rate: ca.MX) -> ca.MX:
    """Return the information matrix of a design problem, shape (6, 6), (rad/s)².

    Args:
        problem: metric, target and inertia.
        sampling: prefilter and grids.
        body_rate: ω on the fine grid, shape (M, 3), rad/s, body axes.
    """
    if problem.metric == "momentum":
        information = momentum_information(body_rate[sampling.samples, :], problem.inertia)
    else:
        information = information_matrix(sampling, body_rate)
    if problem.target_std is None:
        return information
    unit = ca.DM(np.diag(problem.target_std / problem.target_std.mean()))  # parameters counted in their targets
    return unit @ information @ unit


def momentum_information(body_rate: ca.MX, inertia: Matrix3) -> ca.MX:
    """Return M = Σ (J̄ J⁻¹ Γ(ω))ᵀ (J̄ J⁻¹ Γ(ω)), shape (6, 6), with the mean moment J̄ to have the units of Ψ_fᵀΨ_f.

    Γ(ω) θ = -h and zero total momentum give ∂ω/∂θ = -J⁻¹ Γ(ω): the bound's covariance is (σ J̄)² M⁻¹. Γ is linear in ω,
    so that all of a motion enters through Σ ω ωᵀ. The gimbals change J by less than 0.2 %, which is left out here.

    Args:
        body_rate: ω at the gyro's samples, shape (N, 3), rad/s, body axes.
        inertia: J with all gimbals at zero, kg·m², body axes.

    Source: paper eqs. (6), (9), (12), (13).
    """
    mean_moment = np.trace(inertia) / 3.0
    columns = mean_moment * np.linalg.solve(inertia, momentum_regressor(np.eye(3)))
    products = np.einsum("aip,biq->abpq", columns, columns)
    moments = body_rate.T @ body_rate
    return sum((moments[a, b] * ca.DM(products[a, b]) for a in range(3) for b in range(3)), start=ca.MX(6, 6))
