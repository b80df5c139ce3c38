"""Actuators as a list: reaction wheels, single or in arrays, beside control moment gyros."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import pi, radians
from typing import Annotated, Literal, TypeAlias

import numpy as np
from pydantic import Field, model_validator

from testbed.arrays import Array, Axes
from testbed.cmg.wheels import WheelArrayKind, wheel_axes
from testbed.quantities import Bandwidth, Friction, FrictionTorque, Mass, Moment, Momentum, Radius, Torque
from testbed.scenario.cluster import Cluster
from testbed.scenario.gyros import ControlMomentGyros, Gyros, gyro_conflicts, gyros_of
from testbed.scenario.section import Conflict, Section, refuse
from testbed.scenario.values import Places, UnitVector
from testbed.signals import MOST_UNITS

_USUAL = {"orthogonal": 3, "tetrahedron": 4, "pyramid": 4}
"""Wheels of an array whose number is not stated."""
_LOST = 1e-6
"""Smallest singular value of the axes, as a share of the largest, below which a direction of torque is lost: an axis
that is written with six decimals is rounded by less."""
_DRAWN = 4
"""Sets of gimbal angles, one of which at the least is no singularity of an array that has torque about every axis."""


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


Actuator: TypeAlias = Annotated[ReactionWheels | ControlMomentGyros, Field(discriminator="kind")]
"""An entry of [[actuators]]."""


def reaction_wheels(actuators: Sequence[Actuator]) -> tuple[ReactionWheels, ...]:
    """Return the entries that are reaction wheels."""
    return tuple(each for each in actuators if isinstance(each, ReactionWheels))


def control_moment_gyros(actuators: Sequence[Actuator]) -> tuple[ControlMomentGyros, ...]:
    """Return the entries that are control moment gyros."""
    return tuple(each for each in actuators if isinstance(each, ControlMomentGyros))


def wheel_count(actuators: Sequence[Actuator]) -> int:
    """Return how many wheels there are in all; they are numbered in the order of the file."""
    return sum(each.wheels for each in reaction_wheels(actuators))


def surplus_conflicts(actuators: Sequence[Actuator], cluster: Cluster | None) -> Iterator[Conflict]:
    """Find too many actuators.

    Args:
        actuators: beside the cluster.
        cluster: its units; None where it is wrong itself.
    """
    if cluster is None:
        return
    wheels = wheel_count(actuators)
    if wheels > MOST_UNITS:
        yield Conflict(key="actuators", text=f"have {wheels} wheels in all; at most {MOST_UNITS} are flown")
    yield from gyro_conflicts(control_moment_gyros(actuators), cluster)


def torque_conflicts(actuators: Sequence[Actuator], cluster: Cluster | None) -> Iterator[Conflict]:
    """Find a platform to be flown without actuators, or with a direction about which it has no torque.

    Args:
        actuators: beside the cluster.
        cluster: its units; None where it is wrong itself.
    """
    if cluster is None:
        return
    entries = control_moment_gyros(actuators)
    if cluster.units == 0 and not actuators:
        text = "is missing; add it: The control moment gyros; or [[actuators]] of another kind"
        yield Conflict(key="cluster", text=text)
    elif cluster.units == 0:
        axes_B = [each.axes_B for each in reaction_wheels(actuators)]
        yield from _lost_directions(np.concatenate([np.zeros((0, 3)), *axes_B]), gyros_of(cluster, entries))


def _lost_directions(wheel_axis_B: Axes, gyros: Gyros) -> Iterator[Conflict]:
    """Find directions about which no actuator gives torque, whatever the gimbal angles."""
    torques_B = _torques(wheel_axis_B, gyros)
    if any(_lost(each).size == 0 for each in torques_B):
        return
    always = _lost(np.concatenate(torques_B))
    if not always.size:
        text = (
            f"give torque about no more than two axes at a time: with all gimbals at zero not about "
            f"{_shown(_lost(torques_B[0]))} in body axes; add an actuator"
        )
    elif gyros.units:
        text = f"give no torque about {_shown(always)} in body axes at any gimbal angles; add an actuator, or turn one"
    else:
        text = (
            f"give no torque about {_shown(always)} in body axes: all axes are normal to it; add a wheel, or turn one"
        )
    yield Conflict(key="actuators", text=text)


def _torques(wheel_axis_B: Axes, gyros: Gyros) -> list[Array]:
    """Return the directions of all torques, each of shape (W + M, 3): with gimbals at zero, and at some other angles.

    Where an array can give torque about every axis at all, it can at all angles but those of its singularities, which
    angles drawn at random miss.
    """
    working = np.setdiff1d(np.arange(gyros.units), np.array(gyros.failed, dtype=np.intp) - 1)
    spin_B = gyros.places.spin_axis_B[working]
    transverse_B = np.cross(gyros.places.gimbal_axis_B[working], spin_B)
    drawn = np.random.default_rng(0).uniform(-pi, pi, (_DRAWN, len(working), 1))
    angles = [np.zeros((len(working), 1)), *drawn] if len(working) else [np.zeros((0, 1))]
    return [np.concatenate([wheel_axis_B, np.cos(d) * transverse_B - np.sin(d) * spin_B]) for d in angles]


def _lost(torques_B: Axes) -> Axes:
    """Return directions, shape (L, 3), normal to all torques."""
    _, strengths, directions = np.linalg.svd(np.vstack([torques_B, np.zeros((3, 3))]))
    return np.asarray(directions[strengths[:3] < _LOST * strengths[0]])


def _shown(directions: Axes) -> str:
    return " and ".join("[" + ", ".join(f"{part + 0.0:.3g}" for part in _signed(row)) + "]" for row in directions)


def _signed(direction: np.ndarray) -> np.ndarray:
    """Return a direction with its largest part positive, and without rounding where it is zero."""
    cleaned = np.where(np.abs(direction) < _LOST, 0.0, direction)
    return np.asarray(cleaned * np.sign(cleaned[np.abs(cleaned).argmax()]))
