"""Torques by formulas, which the flown platform has and the nominal one does not."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Literal, TypeAlias

import numpy as np
from pydantic import AfterValidator, Field

from testbed.errors import InputError
from testbed.formulas.parser import parsed
from testbed.formulas.torque import Torque
from testbed.scenario.section import Conflict, Section
from testbed.scenario.values import Many, ManyOrOne, One, UnitVector


def _is_formula(text: str) -> str:
    try:
        parsed(text)
    except InputError as error:
        raise ValueError(f"is no formula: {error}") from None
    return text


_Axis: TypeAlias = Annotated[
    Annotated[Literal["x", "y", "z"], One] | Annotated[UnitVector, Many],
    ManyOrOne,
]


class FormulaTorque(Section):
    """A torque on the flown platform: coefficient times formula, about an axis."""

    formula: Annotated[str, AfterValidator(_is_formula)]
    """What the torque follows: a product of at most three of t, w_x, gimbal_1, gimbal_rate_1, R_xx, abs(w_x), norm(w),
    sin(gimbal_1), sin(2*pi*0.8*t) and their like, in lag( , s), delay( , s) or hysteresis( , ) with a memory."""
    axis: _Axis
    """Axis of the torque, or a unit vector."""
    frame: Literal["B", "N"] = "B"
    """Whose axis: the body's, or the inertial frame's along which the body's axes lie when the flight starts."""
    coefficient: Annotated[float, Field(ge=-1e6, le=1e6)]
    """Torque over the formula's value, in SI units: N·m for `1`, N·m·s²/rad² for `w_x*w_y`."""

    @property
    def torque(self) -> Torque:
        """As it is flown."""
        axis_B = np.eye(3)["xyz".index(self.axis)] if isinstance(self.axis, str) else np.array(self.axis)
        return Torque(law=parsed(self.formula), coefficient=self.coefficient * axis_B, frame=self.frame)


def formula_conflicts(torques: tuple[FormulaTorque, ...], units: int | None) -> Iterator[Conflict]:
    """Find formulas of gimbals that the platform does not have, and those that no flown platform has.

    Args:
        torques: of [[truth.torque]].
        units: number of control moment gyros; None where they are wrong themselves.
    """
    for number, each in enumerate(torques, start=1):
        needed = parsed(each.formula).units_needed
        if units is not None and needed > units:
            text = f"of entry {number} reads gimbal {needed}, but there are {units}; use one that is there"
            yield Conflict(key="truth.torque.formula", text=text)
        if not parsed(each.formula).recurs:
            text = f"of entry {number} is of one of several runs; write pulse in the place of once"
            yield Conflict(key="truth.torque.formula", text=text)
        if parsed(each.formula).reads_torque:
            text = f"of entry {number} reads torque_x, _y or _z of actuators that store no momentum; none are flown"
            yield Conflict(key="truth.torque.formula", text=text)
