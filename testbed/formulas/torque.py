"""A torque by a law: coefficients along axes of the body, or of the inertial frame."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np

from testbed.arrays import Array, Vector3
from testbed.formulas.law import Law
from testbed.formulas.motion import Moment, depends_on_motion, needs_attitude

Frame: TypeAlias = Literal["B", "N"]
"""Body axes, or inertial ones along the body's at the first sample of the run."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Torque:
    """Coefficient times law along an axis.

    Attributes:
        law: with numbers for all its constants.
        coefficient: along three axes, shape (3,), in `law.coefficient_unit`.
        frame: whose axes.
    """

    law: Law
    coefficient: Vector3
    frame: Frame = "B"

    def value(self, at: Moment, state: Array) -> Array:
        """Return the torque on the body, shape (..., 3), N·m, body axes."""
        return along(self.frame, self.law.value(at, state, {})[..., None] * self.coefficient, at)


def along(frame: Frame, torque: Array, at: Moment) -> Array:
    """Return a torque given in a frame's axes, shape (..., 3), in body axes; without the conjugation of vecmat."""
    if frame == "B":
        return torque
    return np.asarray((torque[..., None] * at.attitude).sum(axis=-2))


def reads_attitude(law: Law, frame: Frame) -> bool:
    """Return whether a torque depends on the attitude."""
    return frame == "N" or any(map(needs_attitude, law.quantities))


def follows_motion(law: Law, frame: Frame) -> bool:
    """Return whether the body's own motion changes a torque, so that it cannot be given along time."""
    return frame == "N" or any(map(depends_on_motion, law.quantities))


NO_CONSTANTS: Mapping[str, Array] = {}
