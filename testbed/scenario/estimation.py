"""How the inertia is estimated from a record."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Literal

from pydantic import Field, Strict, model_validator

from testbed.scenario.section import Conflict, Section, refuse
from testbed.scenario.uncertainty import Uncertainty
from testbed.scenario.values import Distinct, PrefilterTime


class Estimation(Section):
    """Which estimators run, and what they assume."""

    estimators: Annotated[
        tuple[Literal["ls", "iv", "iv_momentum", "output_error"], ...], Strict(False), Field(min_length=1), Distinct
    ] = ("iv_momentum", "output_error")
    """Least squares, instrumental variable, instrumental variable in momentum form, output error: any of them; omitted:
    the two that reach the bound."""
    prefilter_time_constant_s: PrefilterTime = 0.8
    """Time constant γ of the prefilter of ls and iv, eq. (32)."""
    instrument: Literal["reference", "nominal", "iterated"] = "iterated"
    """Instrument: the reference maneuver, a simulation of the nominal platform, or of the estimated one, iterated."""
    initial_momentum: Literal["estimated", "zero"] = "estimated"
    """Whether the total momentum is estimated jointly, or known to be zero; on measured records a zero is tested."""
    constant_torque: Literal["none", "body", "inertial", "both"] = "none"
    """Which constant torques on the platform are estimated jointly: fixed in the body, in inertial axes, or both."""
    uncertainty: Uncertainty = Uncertainty()
    """What is uncertain of actuators and gyro."""
    alignments: bool = False
    """Whether output error also estimates the inertia of a flight that `testbed run` flies together with every unit's
    gimbal-axis misalignment, encoder zero and momentum scale; not of records measured elsewhere."""

    @model_validator(mode="after")
    def _consistent(self) -> Estimation:
        refuse(self._conflicts())
        return self

    def _conflicts(self) -> Iterator[Conflict]:
        if self.alignments and self.initial_momentum == "zero":
            text = 'is "zero", but a cluster out of alignment carries momentum even at rest; use "estimated"'
            yield Conflict(key="initial_momentum", text=text)

    cut_at_contact: bool = False
    """Whether `testbed estimate` uses a record that states no usable_to_s only up to the first contact it shows."""
