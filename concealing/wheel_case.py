"""A blind case of a craft with wheels as plain data, and the platform of its scenario, read by this package itself."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from concealing.craft import Array
from concealing.effect import EffectKind, HiddenEffect
from concealing.sensors import SensorNumbers
from concealing.wheel_effects import BY_NAME, FLYING, STANDING
from concealing.wheels import Pivot, Wheels

_GRAVITY = 9.80665
"""m/s², the standard value (ISO 80000-3), where a scenario does not state another."""


@dataclass(frozen=True, kw_only=True)
class WheelRun:
    """One run.

    Attributes:
        duration: s.
        motion: seed of the motion that its wheel speeds are planned for.
        at_rest: whether the craft is released at rest, but for the error.
        release_error: what the body rate at release is beside the planned one, rad/s.
    """

    duration: float
    motion: int
    at_rest: bool = True
    release_error: tuple[float, float, float] = (0.0, 0.0, 0.0)


@dataclass(frozen=True, kw_only=True)
class WheelCase:
    """One data set.

    Attributes:
        scenario: the nominal one.
        seed: of noise, dropouts and outliers.
        runs: in the order of their files.
        effects: hidden in it.
        theta_error: true minus nominal J11, J22, J33, J23, J13, J12, kg·m².
        dropouts: share of rows that are lost, in short bursts.
        outliers: share of gyro samples that are spikes.
        stated_noise: stated over actual gyro noise; None where nothing is stated.
        stratum: which part of the score card the case belongs to.
        notes: what the stratum's generator knows of it, such as its size in detectable sizes.
    """

    scenario: Path
    seed: int
    runs: tuple[WheelRun, ...]
    effects: tuple[HiddenEffect, ...] = ()
    theta_error: tuple[float, ...] = (0.0,) * 6
    dropouts: float = 0.0
    outliers: float = 0.0
    stated_noise: float | None = 1.0
    stratum: str = "null"
    notes: dict[str, float | str] = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True)
class WheelPlatform:
    """What a scenario says of a platform with wheels.

    Attributes:
        inertia: of all of it, about the centre of mass, (3, 3), kg·m².
        mass: kg.
        wheels: as drawn.
        momentum_limit: of each wheel, (W,), N·m·s.
        held_momentum: of each wheel at release, (W,), N·m·s.
        pivot: None where it flies freely.
        tilt_limit: rad.
        sensors: their noise.
        bias_instability: standard deviation of the gyro's wandering bias, rad/s.
        bias_time: its correlation time, s.
        gyro_rate, control_rate: Hz.
    """

    inertia: Array
    mass: float
    wheels: Wheels
    momentum_limit: Array
    held_momentum: Array
    pivot: Pivot | None
    tilt_limit: float
    sensors: SensorNumbers
    bias_instability: float
    bias_time: float
    gyro_rate: float
    control_rate: float

    @property
    def kinds(self) -> dict[str, EffectKind]:
        """Effects that can be hidden in it."""
        return self.drawn | BY_NAME

    @property
    def drawn(self) -> dict[str, EffectKind]:
        """Those that random sets draw."""
        return FLYING if self.pivot is None else STANDING


@lru_cache(maxsize=4)
def platform_of(scenario: Path) -> WheelPlatform:
    """Read the numbers of a scenario whose only actuators are one pyramid of wheels."""
    known = tomllib.loads(scenario.read_text(encoding="utf-8"))
    (wheels,), gyro = known["actuators"], known["gyro"]
    count = wheels["units"]
    around, platform = known.get("environment", {}), known["platform"]
    pivot = None
    if around.get("kind") == "air_bearing":
        pivot = Pivot(offset=np.array(around["center_of_mass_offset_m"]), gravity=around.get("gravity_m_s2", _GRAVITY))
    return WheelPlatform(
        inertia=np.array(platform["inertia_kg_m2"]),
        mass=platform["mass_kg"],
        wheels=_pyramid(wheels, count),
        momentum_limit=np.full(count, wheels["momentum_limit_N_m_s"]),
        held_momentum=np.array(known["initial"]["wheel_momentum_N_m_s"]),
        pivot=pivot,
        tilt_limit=around.get("tilt_limit_rad", np.inf),
        sensors=SensorNumbers(
            gyro_noise=gyro["noise_rad_s"],
            encoder_noise=0.0,
            encoder_step=0.0,
            tachometer_noise=known["wheel_tachometer"]["noise_rad_s"],
            torque_noise=0.0,
        ),
        bias_instability=gyro.get("bias_instability_rad_s", 0.0),
        bias_time=gyro.get("bias_correlation_time_s", np.inf),
        gyro_rate=gyro["sample_rate_hz"],
        control_rate=known["simulation"]["control_rate_hz"],
    )


def _pyramid(wheels: dict[str, Any], count: int) -> Wheels:
    """Return wheels whose axes stand on a cone about z, the first towards x, each out along its axis."""
    around, skew = 2.0 * np.pi * np.arange(count) / count, np.deg2rad(wheels["skew_deg"])
    axis = np.stack([np.sin(skew) * np.cos(around), np.sin(skew) * np.sin(around), np.full(count, np.cos(skew))], 1)
    return Wheels(
        axis=axis,
        spin_inertia=np.full(count, wheels["spin_inertia_kg_m2"]),
        torque_limit=np.full(count, wheels["torque_limit_N_m"]),
        viscous=np.full(count, wheels["viscous_friction_N_m_s_rad"]),
        coulomb=np.full(count, wheels["coulomb_friction_N_m"]),
        speed_bias=np.zeros(count),
        position=wheels["mounting_radius_m"] * axis,
        torque_factor=np.ones(count),
        lag=np.zeros(count),
        imbalance=np.zeros(count),
        late=0.0,
    )
