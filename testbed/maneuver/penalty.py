"""The paper's soft limits: a sixth-power penalty on the control points instead of hard constraints."""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca

from testbed.maneuver.program import Constraint


@dataclass(frozen=True, kw_only=True)
class Penalty:
    """Weights of eq. (28), for excesses counted in shares of their limits.

    Attributes:
        ends: K1, of the body rate at both ends.
        rate: K2, of body rate and cluster momentum.
        torque: K3, of the cluster torque.
    """

    ends: float = 1e9
    rate: float = 1e9
    torque: float = 1e9


def sixth_power(constraint: Constraint) -> ca.MX:
    """Return Σ Q(x, threshold) on both sides of a limit.

    Q(x, c) = (x - c)⁶ above c, else 0. Eq. (28) writes the lower side Q(-x, -c); what it must mean is Q(-x, c).

    Args:
        constraint: |x| ≤ 1 in shares of the limit.

    Source: paper eqs. (28), (29).
    """
    x = constraint.expression
    return ca.sumsqr(ca.fmax(x - constraint.upper, 0.0) ** 3) + ca.sumsqr(
        ca.fmax(constraint.lower - x, 0.0) ** 3
    )  # eq. (29)
