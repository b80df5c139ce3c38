"""Control moment gyros of [[actuators]], single or in arrays, and all gyros of a platform, however they are stated."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import accumulate
from math import radians
from typing import Annotated, Literal

import numpy as np
from pydantic import Field, model_validator

from testbed.arrays import Axes, Units, Vector3
from testbed.cmg.arrays import ArrayKind, UnitPlaces, unit_places
from testbed.quantities import Mass, Moment, Radius
from testbed.scenario.cluster import Cluster, GyroNumbers
from testbed.scenario.section import Conflict, refuse
from testbed.scenario.values import Places, UnitVector
from testbed.signals import MOST_UNITS

_NOT_NORMAL = 1e-6
"""Cosine of the angle between gimbal and spin axis up to which six written decimals leave them."""
_SHARED = (
    "gimbal_rate_limit_rad_s",
    "gimbal_torque_limit_N_m",
    "gimbal_servo_bandwidth_rad_s",
    "gimbal_servo_damping_ratio",
    "rotors",
)
"""Keys that all gyros have in common: one servo is laid out for them all, one limit for the steering of all."""


class ControlMomentGyros(GyroNumbers):
    """Equal control moment gyros: one of given axes, or an array about body z."""

    kind: Literal["cmg"]
    """What the actuators are."""
    array: ArrayKind | None = None
    """How the units stand, as in [cluster]; omitted: a single unit of gimbal_axis and spin_axis."""
    gimbal_axis: UnitVector | None = None
    """Axis about which the gimbal of a single unit turns, body axes."""
    spin_axis: UnitVector | None = None
    """Axis of a single unit's rotor at gimbal angle zero, body axes; normal to gimbal_axis."""
    units: Annotated[int, Field(ge=1, le=MOST_UNITS)] | None = None
    """Number of units of an array."""
    skew_deg: Annotated[float, Field(ge=0, le=90)] | None = None
    """Angle between body z and every gimbal axis of a pyramid or a roof."""
    mounting_radius_m: Radius | None = None
    """Distance of an array's units from body z; in two rows or a line, of the outermost ones."""
    position_m: Places | None = None
    """Place of a single unit from the centre of the bus, body axes; omitted: in it."""
    rotor_spin_inertia_kg_m2: Moment
    """Inertia of a rotor about its spin axis."""
    rotor_transverse_inertia_kg_m2: Moment | None = None
    """Inertia of a rotor about an axis normal to its spin axis; omitted: half of the spin inertia."""
    rotor_mass_kg: Mass
    """Mass of a rotor."""
    gimbal_inertia_kg_m2: Moment
    """Inertia of a gimbal body about each axis, rotor not included."""
    gimbal_mass_kg: Mass
    """Mass of a gimbal body, rotor not included."""

    @model_validator(mode="after")
    def _consistent(self) -> ControlMomentGyros:
        refuse(self._conflicts())
        return self

    @property
    def gyros(self) -> int:
        """Number of units."""
        return 1 if self.array is None else self.units or 0

    @property
    def transverse_inertia_kg_m2(self) -> float:
        """Inertia of a rotor about an axis normal to its spin axis, stated or of a thin disc."""
        stated = self.rotor_transverse_inertia_kg_m2
        return 0.5 * self.rotor_spin_inertia_kg_m2 if stated is None else stated

    @property
    def places(self) -> UnitPlaces:
        """Axes of the units, body axes, and their places in units of the mounting radius."""
        if self.array is not None:
            return unit_places(self.array, self.gyros, radians(self.skew_deg or 0.0))
        return UnitPlaces(
            gimbal_axis_B=np.array([self.gimbal_axis]),
            spin_axis_B=np.array([self.spin_axis]),
            direction_B=np.zeros((1, 3)),
        )

    @property
    def positions_B(self) -> Axes:
        """Places of the units from the centre of the bus, shape (M, 3), m, body axes."""
        if self.array is not None:
            return (self.mounting_radius_m or 0.0) * self.places.direction_B
        return np.array([self.position_m or (0.0, 0.0, 0.0)])

    def _conflicts(self) -> Iterator[Conflict]:
        yield from self._single_conflicts() if self.array is None else self._array_conflicts()
        spin, transverse = self.rotor_spin_inertia_kg_m2, self.rotor_transverse_inertia_kg_m2
        yield from self.number_conflicts(self.gyros, spin, transverse)

    def _single_conflicts(self) -> Iterator[Conflict]:
        for key in ("gimbal_axis", "spin_axis"):
            if getattr(self, key) is None:
                yield Conflict(key=key, text="is missing; add it, or state an array: each unit has two axes")
        for key in ("units", "skew_deg", "mounting_radius_m"):
            if getattr(self, key) is not None:
                yield Conflict(key=key, text="belongs to an array; state an array, or omit it: a single unit has axes")
        if self.gimbal_axis is not None and self.spin_axis is not None:
            gimbal, spin = np.array(self.gimbal_axis), np.array(self.spin_axis)
            if abs(gimbal @ spin) > _NOT_NORMAL:
                yield Conflict(key="spin_axis", text=_slanted(gimbal, spin))

    def _array_conflicts(self) -> Iterator[Conflict]:
        for key in ("gimbal_axis", "spin_axis", "position_m"):
            if getattr(self, key) is not None:
                yield Conflict(key=key, text="belongs to a single unit; omit it, or omit the array")
        if self.units is None:
            yield Conflict(key="units", text="is missing; add it: the number of units of the array")
        if self.array in {"roof", "box"} and self.gyros % 2:
            text = f"is {self.units}, but a {self.array} has two equal rows; use an even number"
            yield Conflict(key="units", text=text)
        if (self.array in {"pyramid", "roof"}) != (self.skew_deg is not None):
            missing = "is missing; add it: the angle between body z and every gimbal axis"
            surplus = f"has no effect on a {self.array}, whose axes are fixed; omit it"
            yield Conflict(key="skew_deg", text=missing if self.skew_deg is None else surplus)
        if self.mounting_radius_m is None:
            yield Conflict(key="mounting_radius_m", text="is missing; add it: the distance of the units from body z")


@dataclass(frozen=True, kw_only=True)
class Gyros:
    """All control moment gyros of a platform, of [cluster] or of [[actuators]], in the order of the file.

    Attributes:
        units: M, how many there are.
        rotor_momentum: of each rotor, shape (M,), N·m·s.
        rotor_momentum_limit: what each rotor's servo may carry, shape (M,), N·m·s.
        gimbal_rate_limit: rad/s.
        gimbal_torque_limit: of each motor, N·m.
        servo_bandwidth: of the gimbal servos, rad/s.
        servo_damping_ratio: likewise.
        rotors: whether a servo holds each rotor's speed, or the rotors turn freely.
        failed: numbers of failed units, from 1.
        places: axes at gimbal angle zero; of a model that has a skew of its own, those without any.
        skewed: whether those are the axes.
    """

    units: int
    rotor_momentum: Units
    rotor_momentum_limit: Units
    gimbal_rate_limit: float
    gimbal_torque_limit: float
    servo_bandwidth: float
    servo_damping_ratio: float
    rotors: Literal["constant_speed", "free"]
    failed: tuple[int, ...]
    places: UnitPlaces
    skewed: bool


@lru_cache(maxsize=8)  # every part of a flight asks for those of its scenario
def gyros_of(cluster: Cluster, entries: tuple[ControlMomentGyros, ...]) -> Gyros:
    """Return all gyros of a platform.

    Args:
        cluster: the short form; without units where there are entries.
        entries: of [[actuators]].
    """
    if not entries:
        return _gathered(cluster, ((cluster, cluster.units, _cluster_places(cluster)),), _is_skewed(cluster))
    return _gathered(entries[0], tuple((each, each.gyros, each.places) for each in entries), skewed=True)


def _gathered(shared: GyroNumbers, parts: Sequence[tuple[GyroNumbers, int, UnitPlaces]], skewed: bool) -> Gyros:
    counts = [count for _, count, _ in parts]
    before = accumulate(counts, initial=0)
    return Gyros(
        units=sum(counts),
        rotor_momentum=np.repeat([each.rotor_momentum_N_m_s for each, _, _ in parts], counts),
        rotor_momentum_limit=np.repeat([each.rotor_momentum_limit_N_m_s for each, _, _ in parts], counts),
        gimbal_rate_limit=shared.gimbal_rate_limit_rad_s,
        gimbal_torque_limit=shared.gimbal_torque_limit_N_m,
        servo_bandwidth=shared.gimbal_servo_bandwidth_rad_s,
        servo_damping_ratio=shared.gimbal_servo_damping_ratio,
        rotors=shared.rotors,
        failed=tuple(first + unit for first, (each, _, _) in zip(before, parts, strict=False) for unit in each.failed),
        places=UnitPlaces(
            gimbal_axis_B=np.concatenate([places.gimbal_axis_B for _, _, places in parts]),
            spin_axis_B=np.concatenate([places.spin_axis_B for _, _, places in parts]),
            direction_B=np.concatenate([places.direction_B for _, _, places in parts]),
        ),
        skewed=skewed,
    )


def _cluster_places(cluster: Cluster) -> UnitPlaces:
    if cluster.units == 0:
        return UnitPlaces(gimbal_axis_B=np.zeros((0, 3)), spin_axis_B=np.zeros((0, 3)), direction_B=np.zeros((0, 3)))
    return unit_places(cluster.array, cluster.units, radians(cluster.skew_deg or 0.0))


def _is_skewed(cluster: Cluster) -> bool:
    return cluster.skew_deg is not None or cluster.array == "box"


def gyro_conflicts(entries: Sequence[ControlMomentGyros], cluster: Cluster) -> Iterator[Conflict]:
    """Find gyros that are stated in both forms, too many of them, or such as do not go together."""
    if not entries:
        return
    if cluster.units:
        text = "of kind cmg and [cluster], the short form of a single array: state all gyros as [[actuators]]"
        yield Conflict(key="actuators", text=text)
    count = sum(each.gyros for each in entries)
    if count > MOST_UNITS:
        yield Conflict(
            key="actuators", text=f"have {count} control moment gyros in all; at most {MOST_UNITS} are flown"
        )
    for key in _SHARED:
        stated = sorted({str(getattr(each, key)) for each in entries})
        if len(stated) > 1:
            text = f"of kind cmg have {' and '.join(stated)} for {key}; state one value: it is shared by all gyros"
            yield Conflict(key="actuators", text=text)


def _slanted(gimbal: Vector3, spin: Vector3) -> str:
    angle = np.degrees(np.arccos(np.clip(gimbal @ spin, -1.0, 1.0)))
    across = spin - (gimbal @ spin) * gimbal
    length = np.linalg.norm(across)
    text = f"is {angle:.4g}° from gimbal_axis, and must be 90° from it"
    if length < _NOT_NORMAL:
        return f"{text}; state an axis normal to it"
    nearest = ", ".join(f"{part + 0.0:.9g}" for part in across / length)
    return f"{text}; the nearest axis that is so is [{nearest}]"
