"""The equations of motion of a gyrostat: a body that carries momentum h in its actuators.

    L̇ = τ - ω × L,   ω = J(d)⁻¹ (L - h)

L is the total angular momentum in body axes, J(d) the inertia with the gimbals at d, τ the external torque: paper
eq. (1) without the derivative of any measurement. Two implementations follow this law with the classical fourth-order
rule: `estimation.motion` on plain numbers, compiled, one run at a time, and `prediction.equations` on arrays of runs,
parameter sets and complex steps, with what the effects add. A property test holds them to each other to rounding;
docs/notes/2026-11-23-one-of-each.md has what either is for. What both refuse is defined here. There h is measured;
where its motion follows from motors' torques, as in a simulated flight, `gyrostat_kernel` has the equations.
"""

from __future__ import annotations

import numpy as np

from testbed.arrays import Array
from testbed.errors import InputError

_WILDEST = 1e6
"""N·m·s, or rad/s: no platform of this kind carries or turns as much, and squares of it are far from overflow."""
_RUNAWAY = (
    "the motion that these actuator channels predict runs away: check their units and signs, and that the scenario is "
    "of this platform"
)


def require_bounded(motion: Array, largest: float = _WILDEST) -> None:
    """Refuse a predicted motion that diverges, as it does where channels or units do not belong together.

    Args:
        motion: momenta, N·m·s, or body rates, rad/s, along it, or their derivatives, of any shape.
        largest: beyond which it has run away.

    Raises:
        InputError: it leaves what any platform does, or the finite numbers.
    """
    if not np.abs(motion).max() < largest:  # also true for NaN
        raise InputError(_RUNAWAY)
