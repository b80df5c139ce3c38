"""The paper's design problem on the shipped platform, small enough for tests."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from support.platforms import shipped
from testbed.cmg.actuators import Actuators
from testbed.cmg.cluster import Cluster
from testbed.cmg.wheels import no_wheels
from testbed.maneuver.design import BodyRateLimits, DesignProblem, GimbalLimits
from testbed.plant.geometry import cluster_of, composite_inertia

CLUSTER = cluster_of(shipped())
GYROS = Actuators(cluster=CLUSTER, wheels=no_wheels(), gimbal_rate_limit=2.0)
INERTIA = composite_inertia(shipped())
TORQUE_LIMIT, MOMENTUM_LIMIT = np.array([0.040, 0.040, 0.047]), np.array([0.0210, 0.0210, 0.0254])  # eq. (31)


def design_problem(criterion="D", control_points=12, **changes) -> DesignProblem:
    """5 s, 16 Hz, γ = 0.8 s, from rest."""
    return replace(
        DesignProblem(
            name="test",
            criterion=criterion,
            duration=5.0,
            control_points=control_points,
            sample_rate=16.0,
            prefilter_time_constant=0.8,
            inertia=INERTIA,
            cluster=CLUSTER,
        ),
        **changes,
    )


def body_rate_limits(**changes) -> BodyRateLimits:
    """Eq. (31) and |ω| ≤ 0.3 rad/s."""
    limits = BodyRateLimits(cluster_torque=TORQUE_LIMIT, cluster_momentum=MOMENTUM_LIMIT, body_rate=0.3)
    return replace(limits, **changes)


def gimbal_limits(**changes) -> GimbalLimits:
    """What the shipped gimbal-space design may use."""
    limits = GimbalLimits(
        gimbal_rate=1.9,
        gimbal_torque=0.015,
        cluster_torque=TORQUE_LIMIT,
        gimbal_acceleration=10.0,
        cluster_momentum=MOMENTUM_LIMIT,
        envelope_fraction=0.95,
        min_singularity_measure=0.3,
    )
    return replace(limits, **changes)


def without_units(*failed: int) -> Cluster:
    """The cluster with the rotors of some units (0 to 5) at rest."""
    momentum = CLUSTER.rotor_momentum.copy()
    momentum[list(failed)] = 0.0
    return replace(CLUSTER, rotor_momentum=momentum)
