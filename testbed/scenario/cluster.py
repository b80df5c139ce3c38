"""The cluster of control moment gyros and what it may be asked for."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Annotated, Literal

from pydantic import Field, Strict, model_validator

from testbed.cmg.arrays import ArrayKind
from testbed.quantities import Bandwidth, DampingRatio, Mass, Moment, Momentum, Radius, RateLimit, Torque
from testbed.scenario.section import Conflict, Section, refuse
from testbed.scenario.values import Distinct, Three
from testbed.signals import MOST_UNITS

_ROWS = ("roof", "box")
"""Arrays of two equal rows."""


class GyroNumbers(Section):
    """Numbers of equal control moment gyros, wherever they stand."""

    rotor_momentum_N_m_s: Momentum
    """Momentum of each rotor about its spin axis, from its speed relative to the gimbal."""
    rotor_momentum_limit_N_m_s: Momentum
    """What a rotor's servo may carry; a rotor that would exceed it is clamped there."""
    gimbal_rate_limit_rad_s: RateLimit
    """Largest gimbal rate; the steering law scales all rates alike to keep it."""
    gimbal_torque_limit_N_m: Torque
    """Largest torque of a gimbal motor."""
    gimbal_servo_bandwidth_rad_s: Bandwidth
    """Bandwidth of the gimbal servo."""
    gimbal_servo_damping_ratio: DampingRatio = 0.7
    """Damping ratio of the gimbal servo."""
    rotors: Literal["constant_speed", "free"]
    """Whether a servo holds each rotor's speed, or the rotor turns freely."""
    failed: Annotated[
        tuple[Annotated[int, Field(ge=1, le=MOST_UNITS)], ...], Strict(False), Field(max_length=MOST_UNITS), Distinct
    ] = ()
    """Numbers, from 1, of failed units, at most half of all: rotor at rest, gimbal locked at zero."""

    def number_conflicts(self, units: int, spin: float | None, transverse: float | None) -> Iterator[Conflict]:
        """Find numbers that do not go together.

        Args:
            units: how many there are of them.
            spin: inertia of a rotor about its spin axis, kg·m²; None where it is not stated.
            transverse: likewise about an axis normal to it.
        """
        if self.rotor_momentum_N_m_s > self.rotor_momentum_limit_N_m_s:
            yield Conflict(
                key="rotor_momentum_N_m_s",
                text=f"{self.rotor_momentum_N_m_s} exceeds rotor_momentum_limit_N_m_s = "
                f"{self.rotor_momentum_limit_N_m_s}; lower the one or raise the other",
            )
        beyond = [unit for unit in self.failed if unit > units]
        if beyond:
            yield Conflict(key="failed", text=f"names unit {beyond[0]}, but there are {units}")
        if len(self.failed) > units // 2:
            text = f"names {len(self.failed)} of {units} units; at most half of them may have failed"
            yield Conflict(key="failed", text=text)
        if spin is not None and transverse is not None and spin > 2.0 * transverse:
            yield Conflict(
                key="rotor_transverse_inertia_kg_m2",
                text=f"{transverse} is less than half of rotor_spin_inertia_kg_m2 = {spin}; no rigid rotor has that",
            )


class Cluster(GyroNumbers):
    """Equal control moment gyros in an array about body z; by default the paper's, a hexagonal pyramid.

    A number marked "omitted: the model's own" keeps the value of the MJCF model.
    """

    array: ArrayKind = "pyramid"
    """How the units stand: gimbal axes on a cone about z; in two rows, tilted to either side (a box: by 45°); in a
    line, all along z."""
    units: Annotated[int, Field(ge=2, le=MOST_UNITS)] = 6
    """Number of units."""
    skew_deg: Annotated[float, Field(ge=0.1, le=90)] | None = None
    """Angle between body z and every gimbal axis; omitted: the model's own."""
    mounting_radius_m: Radius | None = None
    """Distance of every unit from body z; omitted: the model's own."""
    rotor_spin_inertia_kg_m2: Moment | None = None
    """Inertia of a rotor about its spin axis; omitted: the model's own."""
    rotor_transverse_inertia_kg_m2: Moment | None = None
    """Inertia of a rotor about an axis normal to its spin axis; omitted: the model's own."""
    rotor_mass_kg: Mass | None = None
    """Mass of a rotor; omitted: the model's own."""
    gimbal_inertia_kg_m2: Moment | None = None
    """Inertia of a gimbal body about each axis, rotor not included; omitted: the model's own."""
    gimbal_mass_kg: Mass | None = None
    """Mass of a gimbal body, rotor not included; omitted: the model's own."""

    @model_validator(mode="after")
    def _consistent(self) -> Cluster:
        refuse(self._conflicts())
        return self

    def _conflicts(self) -> Iterator[Conflict]:
        yield from self._array_conflicts()
        spin, transverse = self.rotor_spin_inertia_kg_m2, self.rotor_transverse_inertia_kg_m2
        yield from self.number_conflicts(self.units, spin, transverse)

    def _array_conflicts(self) -> Iterator[Conflict]:
        if self.array == "line":
            text = 'is "line", whose gimbal axes are all along z: no torque about z can be given; use another array'
            yield Conflict(key="array", text=text)
        if self.array in _ROWS and self.units % 2:
            yield Conflict(
                key="units", text=f"is {self.units}, but a {self.array} has two equal rows; use an even number"
            )
        if self.array in _ROWS and self.units == len(_ROWS):
            text = f"is 2, one in each row of a {self.array}, which loses some direction of torque at any angle; use 4"
            yield Conflict(key="units", text=text)
        if self.array == "box" and self.skew_deg is not None:
            text = 'has no effect on a box, whose axes are tilted by 45°; omit it, or use the array "roof"'
            yield Conflict(key="skew_deg", text=text)


NO_CLUSTER = Cluster.model_construct(
    units=0,
    rotor_momentum_N_m_s=0.0,
    rotor_momentum_limit_N_m_s=math.inf,
    gimbal_rate_limit_rad_s=1.0,
    gimbal_torque_limit_N_m=math.inf,
    gimbal_servo_bandwidth_rad_s=1.0,
    rotors="constant_speed",
)
"""The cluster of a platform without control moment gyros: no unit, so that none of its numbers matters."""


def stated_conflicts(cluster: Cluster, model: object) -> Iterator[Conflict]:
    """Find an array that is not the shipped model's and does not say where its units stand.

    Args:
        cluster: the units.
        model: the platform's own MJCF, in which they stand; None for the shipped one.
    """
    if model is not None or (cluster.array, cluster.units) == ("pyramid", Cluster.model_fields["units"].default):
        return
    for key in ("skew_deg", "mounting_radius_m"):
        if getattr(cluster, key) is None and (key, cluster.array) != ("skew_deg", "box"):
            text = (
                f"is missing; the shipped model has its own for six units in a pyramid only, not for {cluster.units} "
            )
            yield Conflict(key=f"cluster.{key}", text=f"{text}in a {cluster.array}: add it")


class Limits(Section):
    """What the cluster may be asked for, per body axis."""

    cluster_torque_N_m: Three[Torque]
    """Largest cluster torque along each body axis."""
    cluster_momentum_N_m_s: Three[Momentum]
    """Largest cluster momentum along each body axis."""
