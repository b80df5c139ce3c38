"""The cluster of control moment gyros and what it may be asked for."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Literal

from pydantic import Field, Strict, model_validator

from testbed.quantities import Bandwidth, DampingRatio, Mass, Moment, Momentum, Radius, RateLimit, Torque
from testbed.scenario.section import Conflict, Section, refuse
from testbed.scenario.values import Distinct, Three


class Cluster(Section):
    """Six equal control moment gyros in a hexagonal pyramid about body z.

    A number marked "omitted: the model's own" keeps the value of the MJCF model.
    """

    units: Literal[6] = 6
    """Number of units."""
    skew_deg: Annotated[float, Field(ge=0.1, le=90)] | None = None
    """Angle between body z and every gimbal axis; omitted: the model's own."""
    mounting_radius_m: Radius | None = None
    """Distance of every unit from body z; omitted: the model's own."""
    rotor_momentum_N_m_s: Momentum
    """Momentum of each rotor about its spin axis, from its speed relative to the gimbal."""
    rotor_momentum_limit_N_m_s: Momentum
    """What a rotor's servo may carry; a rotor that would exceed it is clamped there."""
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
    failed: Annotated[tuple[Annotated[int, Field(ge=1, le=6)], ...], Strict(False), Field(max_length=3), Distinct] = ()
    """Numbers (1 to 6) of failed units, at most 3: rotor at rest, gimbal locked at zero."""

    @model_validator(mode="after")
    def _consistent(self) -> Cluster:
        refuse(self._conflicts())
        return self

    def _conflicts(self) -> Iterator[Conflict]:
        if self.rotor_momentum_N_m_s > self.rotor_momentum_limit_N_m_s:
            yield Conflict(
                key="rotor_momentum_N_m_s",
                text=f"{self.rotor_momentum_N_m_s} exceeds rotor_momentum_limit_N_m_s = "
                f"{self.rotor_momentum_limit_N_m_s}; lower the one or raise the other",
            )
        spin, transverse = self.rotor_spin_inertia_kg_m2, self.rotor_transverse_inertia_kg_m2
        if spin is not None and transverse is not None and spin > 2.0 * transverse:
            yield Conflict(
                key="rotor_transverse_inertia_kg_m2",
                text=f"{transverse} is less than half of rotor_spin_inertia_kg_m2 = {spin}; no rigid rotor has that",
            )


class Limits(Section):
    """What the cluster may be asked for, per body axis."""

    cluster_torque_N_m: Three[Torque]
    """Largest cluster torque along each body axis."""
    cluster_momentum_N_m_s: Three[Momentum]
    """Largest cluster momentum along each body axis."""
