"""From the cluster's limits to what a body-rate maneuver may take, whatever the attitude."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from testbed.arrays import Vector3
from testbed.errors import InfeasibleDesignError
from testbed.maneuver.design import BodyRateLimits, DesignProblem


class Budget(NamedTuple):
    """What the maneuver may take, each of shape (3,), per body axis.

    Attributes:
        rate: of ω, rad/s.
        momentum: of J ω, N·m·s.
        torque: of J ω̇, N·m.
    """

    rate: Vector3
    momentum: Vector3
    torque: Vector3


def body_rate_budget(problem: DesignProblem, limits: BodyRateLimits) -> Budget:
    """Turn the actuators' limits into the motion's.

    h = Rᵀ H₀ - J ω and -ḣ = J ω̇ + ω × Rᵀ H₀: a total momentum takes its norm off every axis, whatever the attitude.

    Args:
        problem: platform and start.
        limits: of the cluster and of the body rate.

    Raises:
        InfeasibleDesignError: the total momentum alone takes all.

    Source: paper eqs. (25), (26).
    """
    total = float(np.linalg.norm(problem.total_momentum_B))
    momentum = limits.cluster_momentum - total  # eq. (26)
    rate = np.minimum(limits.body_rate, np.abs(np.linalg.inv(problem.inertia)) @ np.maximum(momentum, 0.0))
    torque = limits.cluster_torque - total * float(np.linalg.norm(rate))  # eq. (25)
    if min(momentum.min(), torque.min()) <= 0.0:
        raise InfeasibleDesignError(
            f"the total momentum of {total:.3g} N·m·s leaves {momentum.min():.3g} N·m·s of the cluster's momentum "
            f"limit and {torque.min():.3g} N·m of its torque limit; start slower, or raise the limits"
        )
    return Budget(rate=rate, momentum=momentum, torque=torque)
