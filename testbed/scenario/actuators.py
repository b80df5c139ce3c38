"""Actuators beside the cluster of control moment gyros: reaction wheels, single or in arrays."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import radians
from typing import Annotated, Literal

import numpy as np
from pydantic import Field, model_validator

from testbed.arrays import Axes
from testbed.cmg.wheels import WheelArrayKind, wheel_axes
from testbed.quantities import Bandwidth, Friction, FrictionTorque, Mass, Moment, Momentum, Radius, Torque
from testbed.scenario.cluster import Cluster
from testbed.scenario.section import Conflict, Section, refuse
from testbed.scenario.values import Places, UnitVector
from testbed.signals import MOST_UNITS

_USUAL = {"orthogonal": 3, "tetrahedron": 4, "pyramid": 4}
"""Wheels of an array whose number is not stated."""
_LOST = 1e-6
"""Smallest singular value of the axes, as a share of the largest, below which a direction of torque is lost: an axis
that is written with six decimals is rounded by less."""


class ReactionWheels(Section):
    """Equal reaction wheels: one along an axis, or an array about body z."""

    kind: Literal["reaction_wheel"]
    """What the actuators are."""
    array: WheelArrayKind | None = None
    """How the wheels stand: three along x, y, z; four that point to a tetrahedron's corners; or on a cone about z.
    Omitted: a single wheel along axis."""
    axis: UnitVector | None = None
    """Axis of a single wheel, body axes."""
    units: Annotated[int, Field(ge=1, le=MOST_UNITS)] | None = None
    """Number of wheels; omitted: as many as the array usually has, one without an array."""
    skew_deg: Annotated[float, Field(ge=0, le=90)] | None = None
    """Angle between body z and every axis of a pyramid."""
    mounting_radius_m: Radius = 0.0
    """Distance of every wheel of an array from the centre of the bus, along its axis."""
    position_m: Places | None = None
    """Place of a single wheel from the centre of the bus, body axes; omitted: at mounting_radius_m along its axis."""
    mass_kg: Mass
    """Mass of a wheel's rotor; the housing belongs to the bus."""
    spin_inertia_kg_m2: Moment
    """Inertia of a rotor about its axis."""
    transverse_inertia_kg_m2: Moment | None = None
    """Inertia of a rotor about an axis normal to it; omitted: half of the spin inertia, as of a thin disc."""
    momentum_limit_N_m_s: Momentum
    """Largest momentum of a wheel, from its speed relative to the body; its drive does not push it beyond."""
    torque_limit_N_m: Torque
    """Largest torque of a wheel's motor."""
    speed_loop_bandwidth_rad_s: Bandwidth | None = None
    """Bandwidth of a loop inside the drive that holds a commanded speed; omitted: none, the drive gives torque."""
    viscous_friction_N_m_s_rad: Friction = 0.0
    """Torque of a bearing over the wheel's speed; the controller makes up for it."""
    coulomb_friction_N_m: FrictionTorque = 0.0
    """Torque of a bearing against any motion; the controller does not know of it."""

    @model_validator(mode="after")
    def _consistent(self) -> ReactionWheels:
        refuse(self._conflicts())
        return self

    @property
    def wheels(self) -> int:
        """Number of wheels."""
        return self.units or (1 if self.array is None else _USUAL[self.array])

    @property
    def axes_B(self) -> Axes:
        """Axes of the wheels, shape (W, 3), unit vectors, body axes."""
        if self.array is None:
            return np.array([self.axis])
        return wheel_axes(self.array, self.wheels, radians(self.skew_deg or 0.0))

    @property
    def positions_B(self) -> Axes:
        """Places of the wheels from the centre of the bus, shape (W, 3), m, body axes."""
        return self.mounting_radius_m * self.axes_B if self.position_m is None else np.array([self.position_m])

    def _conflicts(self) -> Iterator[Conflict]:
        if (self.array is None) == (self.axis is None):
            yield Conflict(key="array", text="and axis: state one of them, an array or the axis of a single wheel")
            return
        if self.array is None and self.wheels != 1:
            yield Conflict(key="units", text=f"is {self.units}, but axis is that of a single wheel; state an array")
        if self.array in {"orthogonal", "tetrahedron"} and self.wheels != _USUAL[self.array]:
            text = f"is {self.units}, but the array {self.array} has {_USUAL[self.array]} wheels; omit it"
            yield Conflict(key="units", text=text)
        if self.array == "pyramid" and self.skew_deg is None:
            yield Conflict(key="skew_deg", text="is missing; add it: the angle between body z and every axis")
        if self.array != "pyramid" and self.skew_deg is not None:
            yield Conflict(key="skew_deg", text="is the angle of a pyramid's axes, and of nothing else; omit it")
        if self.array is not None and self.position_m is not None:
            text = "is the place of a single wheel; an array has mounting_radius_m"
            yield Conflict(key="position_m", text=text)
        spin, transverse = self.spin_inertia_kg_m2, self.transverse_inertia_kg_m2
        if transverse is not None and spin > 2.0 * transverse:
            text = f"{transverse} is less than half of spin_inertia_kg_m2 = {spin}; no rigid rotor has that"
            yield Conflict(key="transverse_inertia_kg_m2", text=text)


def wheel_count(actuators: Sequence[ReactionWheels]) -> int:
    """Return how many wheels there are in all; they are numbered in the order of the file."""
    return sum(each.wheels for each in actuators)


def actuator_conflicts(actuators: Sequence[ReactionWheels], cluster: Cluster | None) -> Iterator[Conflict]:
    """Find a platform without actuators, with too many of them, or with a direction about which it has no torque.

    Args:
        actuators: beside the cluster.
        cluster: its units; None where it is wrong itself.
    """
    if cluster is None:
        return
    wheels = wheel_count(actuators)
    if wheels > MOST_UNITS:
        yield Conflict(key="actuators", text=f"have {wheels} wheels in all; at most {MOST_UNITS} are flown")
    if cluster.units == 0 and wheels == 0:
        text = "is missing; add it: The control moment gyros; or [[actuators]] of another kind"
        yield Conflict(key="cluster", text=text)
    elif cluster.units == 0:
        yield from _lost_directions(np.concatenate([each.axes_B for each in actuators]))


def _lost_directions(axes_B: Axes) -> Iterator[Conflict]:
    _, strengths, directions = np.linalg.svd(np.vstack([axes_B, np.zeros((3, 3))]))
    lost = directions[strengths[:3] < _LOST * strengths[0]]
    if len(lost):
        shown = " and ".join("[" + ", ".join(f"{part + 0.0:.3g}" for part in _signed(row)) + "]" for row in lost)
        text = f"give no torque about {shown} in body axes: all axes are normal to it; add a wheel, or turn one"
        yield Conflict(key="actuators", text=text)


def _signed(direction: np.ndarray) -> np.ndarray:
    """Return a direction with its largest part positive, and without rounding where it is zero."""
    cleaned = np.where(np.abs(direction) < _LOST, 0.0, direction)
    return np.asarray(cleaned * np.sign(cleaned[np.abs(cleaned).argmax()]))
