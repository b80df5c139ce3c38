"""The information that a gimbal motion gives on inertia and alignments together.

Where the total momentum is zero, ω = -J⁻¹ h and ∂ω = J⁻¹ (Rᵀ ∂H₀ - Γ(ω) ∂θ - ∂h), with R integrated from ω: no
equation of motion has to be differentiated. Left out are the inertia's change with the gimbals and the gimbals' own
turning, 0.3 % of the rotors' share; without them a common scale of inertia and rotor momenta is exactly invisible, and
is held by a mean momentum scale of zero.
"""

from __future__ import annotations

import casadi as ca
import numpy as np

from testbed.arrays import Array, Matrix3, Series
from testbed.cmg.cluster import Cluster
from testbed.dynamics.inertia import momentum_regressor
from testbed.maneuver.information import SampledFilter


def alignment_information(
    cluster: Cluster, inertia: Matrix3, sampling: SampledFilter, angle: ca.MX, body_rate: ca.MX
) -> ca.MX:
    """Return the information matrix of θ and of the working units' alignments, the initial momentum unknown, (rad/s)².

    In this order: θ in shares of the mean moment; turns about s and about t, encoder zeros (rad); momentum scales
    relative to their mean, one fewer than units. The bound's covariance is σ² times its inverse.

    Args:
        cluster: nominal, without misalignments.
        inertia: J, kg·m², body axes.
        sampling: the gyro's samples and the fine grid.
        angle: d on the fine grid, shape (units, M), rad.
        body_rate: ω on the fine grid, shape (M, 3), rad/s, body axes.

    Source: paper eqs. (9), (12), (13); the initial momentum's share is taken out by its Schur complement.
    """
    samples = range(*sampling.samples.indices(len(sampling.fine_time)))
    period = np.diff(sampling.fine_time[sampling.samples])
    columns = _columns_function(cluster, inertia).map(len(samples))
    rows = columns(angle[:, samples], body_rate[samples, :].T, _attitudes(body_rate, period))  # Sᵀ, shape (P + 3, 3N)
    gram = rows @ rows.T
    kept = gram.shape[0] - 3
    across = gram[:kept, kept:]
    return gram[:kept, :kept] - across @ ca.solve(gram[kept:, kept:], across.T)


def relative_scales(units: int) -> Array:
    """Return an orthonormal basis of momentum scales whose mean is zero, shape (units, units - 1)."""
    return np.asarray(np.linalg.svd(np.ones((1, units)))[2][1:].T)


def _columns_function(cluster: Cluster, inertia: Matrix3) -> ca.Function:
    """Return [∂ω/∂(parameters), ∂ω/∂H₀]ᵀ, shape (P + 3, 3), as a function of d, ω and Rᵀ by columns; H₀ in shares."""
    angle = ca.SX.sym("angle", len(cluster.rotor_momentum))
    rate, to_body = ca.SX.sym("rate", 3), ca.SX.sym("to_body", 9)
    working = np.flatnonzero(cluster.rotor_momentum)
    momentum = cluster.rotor_momentum[working]
    spin, transverse, gimbal = (
        axes[working].T for axes in (cluster.spin_axis_B, cluster.transverse_axis_B, cluster.gimbal_axis_B)
    )
    cos, sin = (ca.diag(momentum * function(angle[working.tolist()])) for function in (ca.cos, ca.sin))
    regressor = sum((rate[axis] * ca.DM(momentum_regressor(np.eye(3)[axis])) for axis in range(3)), start=ca.SX(3, 6))
    mean_moment = np.trace(inertia) / 3.0
    held = ca.horzcat(
        mean_moment * regressor,
        gimbal @ sin,  # s0 × s(d)
        -gimbal @ cos,  # t0 × s(d)
        spin @ sin - transverse @ cos,  # -t(d)
        (spin @ cos + transverse @ sin) @ relative_scales(len(working)),
        -mean_moment * ca.reshape(to_body, 3, 3),
    )
    return ca.Function("columns", [angle, rate, to_body], [-(ca.DM(np.linalg.inv(inertia)) @ held).T])


def _attitudes(body_rate: ca.MX, period: Series) -> ca.MX:
    """Return Rᵀ at every gyro sample by columns, shape (9, N); R is the unit matrix at the first.

    Source: Magnus expansion of fourth order with Simpson's rule, as in `testbed.rotation.kinematics`.
    """
    start, middle, end = (body_rate[slice(first, last, 2), :].T for first, last in ((0, -1), (1, None), (2, None)))
    later = _turn_function().mapaccum(len(period))(ca.vec(ca.DM.eye(3)), start, middle, end, period[None])
    return ca.horzcat(ca.vec(ca.DM.eye(3)), later)


def _turn_function() -> ca.Function:
    """Rᵀ after a period, from ω at its start, middle and end: exp(-φ×) Rᵀ."""
    to_body, step = ca.SX.sym("to_body", 9), ca.SX.sym("step")
    start, middle, end = (ca.SX.sym(name, 3) for name in ("start", "middle", "end"))
    turn = step / 6.0 * (start + 4.0 * middle + end) + step**2 / 12.0 * ca.cross(start, end)
    cross = ca.skew(turn)
    square = ca.sumsqr(turn)
    sine = 1.0 - square / 6.0 + square**2 / 120.0  # of sin|φ|/|φ|; a turn in one period is far below 1 rad
    versine = 0.5 - square / 24.0 + square**2 / 720.0
    rotation = ca.SX.eye(3) - sine * cross + versine * cross @ cross
    after = ca.vec(rotation @ ca.reshape(to_body, 3, 3))
    return ca.Function("turn", [to_body, start, middle, end, step], [after])
