"""The craft as it really is: numbers of the platform, of its units and of its sensors, and what else acts on it.

Six units on a hexagonal pyramid; unit i has its gimbal axis at azimuth 60° i and at the skew angle from +z, and its
spin axis horizontal at gimbal angle zero. M is the number of units; 0 for a platform under applied torque.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from math import inf
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

ROTOR_SERVO_RATE = 300.0
"""1/s: bandwidth of the servo that holds a rotor's speed, as the shipped platform has it."""
SIGN_WIDTH = 0.01
"""rad/s over which dry friction changes its sign."""


@dataclass(frozen=True, kw_only=True)
class Units:
    """The CMG units, each attribute with a first axis of M.

    Attributes:
        gimbal_axis: (M, 3), body axes.
        spin_axis: (M, 3) at gimbal angle zero.
        position: (M, 3), m, from the centre of mass.
        spin_inertia, transverse_inertia: of the rotor, kg·m².
        gimbal_inertia: of the gimbal body about its axis, kg·m².
        rotor_speed: that the rotor's servo holds, rad/s.
        spin_down: decay of that speed, 1/s.
        rate_gain: of the tachometer loop in the gimbal motor, N·m·s/rad.
        torque_limit: of the gimbal motor, N·m.
        lag: of the motor behind its demand, s.
        viscous: friction, N·m·s/rad.
        coulomb: dry friction when sliding, N·m.
        stribeck: what dry friction has more at rest, N·m.
        stribeck_rate: at which that has gone, rad/s.
        static_imbalance: kg·m.
        dynamic_imbalance: kg·m².
        imbalance_phase: rad.
    """

    gimbal_axis: Array
    spin_axis: Array
    position: Array
    spin_inertia: Array
    transverse_inertia: Array
    gimbal_inertia: Array
    rotor_speed: Array
    rate_gain: Array
    torque_limit: Array
    spin_down: Array
    lag: Array
    viscous: Array
    coulomb: Array
    stribeck: Array
    stribeck_rate: Array
    static_imbalance: Array
    dynamic_imbalance: Array
    imbalance_phase: Array

    @property
    def transverse_axis(self) -> Array:
        """(M, 3) at gimbal angle zero."""
        return np.cross(self.gimbal_axis, self.spin_axis)

    @property
    def turning_inertia(self) -> Array:
        """What a gimbal motor turns, (M,), kg·m²."""
        return self.gimbal_inertia + self.transverse_inertia


class Motion(NamedTuple):
    """What a torque may depend on; B runs side by side.

    Attributes:
        time: since release, s.
        epoch: (B,), s, of the release on a clock that runs on between runs.
        attitude: (B, 3, 3), body to inertial.
        release_attitude: (B, 3, 3).
        body_rate: (B, 3), rad/s, body axes.
    """

    time: float
    epoch: Array
    attitude: Array
    release_attitude: Array
    body_rate: Array


Torque = Callable[[Motion], Array]
"""An external torque on the platform, (B, 3), N·m, body axes."""


class Attachment(Protocol):
    """Something that moves inside the craft, counted in its inertia as if it stood still where it was at release."""

    @property
    def width(self) -> int:
        """Number of its states."""
        ...

    @property
    def fastest(self) -> float:
        """Fastest rate of its own motion, 1/s."""
        ...

    def start(self, body_rate: Array) -> Array:
        """Return its state at release, (B, width)."""
        ...

    def released_inertia(self, time: float, epoch: Array) -> Array:
        """Return the inertia that does not turn with the body, (3, 3) or (B, 3, 3), kg·m²."""
        ...

    def momentum(self, time: float, epoch: Array, state: Array) -> Array:
        """Return its momentum about the centre of mass beyond what turns with the body, (B, 3), N·m·s, body axes."""
        ...

    def derivative(self, time: float, state: Array, body_rate: Array) -> Array:
        """Return the rate of change of its state, (B, width)."""
        ...


@dataclass(frozen=True, kw_only=True)
class Impulse:
    """A change of the platform's momentum in no time.

    Attributes:
        time: since release, s.
        momentum: (3,), N·m·s, body axes.
        run: that it happens in; None for all.
    """

    time: float
    momentum: Array
    run: int | None = None


@dataclass(frozen=True, kw_only=True)
class GyroErrors:
    """reading = round(clip(response · ω(t - latency), low-passed, + bias + drift + noises)).

    Attributes:
        response: (3, 3).
        bias: (3,), rad/s.
        drift: (3,), rad/s².
        random_walk: rad/s/√s.
        latency: s.
        bandwidth: Hz.
        extra_noise: (3,), standard deviation of white noise beside the nominal, rad/s.
        quantization: rad/s.
        saturation: rad/s.
        noise_correlation: of neighbouring samples of the nominal noise.
        averaging: share of the sample period over which a reading is the mean.
        clock_drift: share of the time by which the clock that stamps the readings is ahead.
    """

    response: Array = field(default_factory=lambda: np.eye(3))
    bias: Array = field(default_factory=lambda: np.zeros(3))
    drift: Array = field(default_factory=lambda: np.zeros(3))
    random_walk: float = 0.0
    latency: float = 0.0
    bandwidth: float = inf
    extra_noise: Array = field(default_factory=lambda: np.zeros(3))
    quantization: float = 0.0
    saturation: float = inf
    noise_correlation: float = 0.0
    averaging: float = 0.0
    clock_drift: float = 0.0


@dataclass(frozen=True, kw_only=True)
class Encoders:
    """reading = axis angle + zero ± half the backlash.

    Attributes:
        zero: (M,), rad.
        backlash: whole width of the dead zone, (M,), rad.
    """

    zero: Array
    backlash: Array


@dataclass(frozen=True, kw_only=True)
class AppliedTorque:
    """How actuators that store no momentum follow what is asked of them.

    Attributes:
        lag: s.
        delay: s.
    """

    lag: float = 0.0
    delay: float = 0.0


@dataclass(frozen=True, kw_only=True)
class Craft:
    """Everything that is true of one platform.

    Attributes:
        inertia: (3, 3), whole platform, rotors locked, gimbals at zero, kg·m².
        mass: kg.
        units: as they are.
        torques: external ones.
        attachments: what moves inside.
        impulses: blows.
        gyro, encoders: sensor errors beside their noise.
        tachometer_scale: (M,), true over shown rotor speed.
        applied: actuators that store no momentum.
        telemetry_late: by which the actuators' channels are recorded late against the gyro, s; negative where early.
    """

    inertia: Array
    mass: float
    units: Units
    encoders: Encoders
    tachometer_scale: Array
    torques: tuple[Torque, ...] = ()
    attachments: tuple[Attachment, ...] = ()
    impulses: tuple[Impulse, ...] = ()
    gyro: GyroErrors = field(default_factory=GyroErrors)
    applied: AppliedTorque = field(default_factory=AppliedTorque)
    telemetry_late: float = 0.0


class PlatformNumbers(NamedTuple):
    """What a scenario says of its platform, as plain numbers in SI units and degrees."""

    inertia: Array
    mass: float
    units: int
    skew_deg: float
    mounting_radius: float
    rotor_momentum: float
    spin_inertia: float
    transverse_inertia: float
    gimbal_inertia: float
    torque_limit: float
    servo_bandwidth: float


def nominal_craft(numbers: PlatformNumbers) -> Craft:
    """Return the platform without any effect."""
    units = _units(numbers)
    return Craft(
        inertia=numbers.inertia,
        mass=numbers.mass,
        units=units,
        encoders=Encoders(zero=np.zeros(numbers.units), backlash=np.zeros(numbers.units)),
        tachometer_scale=np.ones(numbers.units),
    )


def _units(numbers: PlatformNumbers) -> Units:
    azimuth = np.deg2rad(60.0) * np.arange(numbers.units)
    skew = np.deg2rad(numbers.skew_deg)
    radial = np.stack([np.cos(azimuth), np.sin(azimuth), np.zeros(numbers.units)], axis=1)
    tangential = np.stack([-np.sin(azimuth), np.cos(azimuth), np.zeros(numbers.units)], axis=1)

    def each(value: float) -> Array:
        return np.full(numbers.units, value)

    return Units(
        gimbal_axis=np.sin(skew) * radial + np.cos(skew) * np.array([0.0, 0.0, 1.0]),
        spin_axis=tangential,
        position=numbers.mounting_radius * radial,
        spin_inertia=each(numbers.spin_inertia),
        transverse_inertia=each(numbers.transverse_inertia),
        gimbal_inertia=each(numbers.gimbal_inertia),
        rotor_speed=each(numbers.rotor_momentum / numbers.spin_inertia),
        rate_gain=each((numbers.gimbal_inertia + numbers.transverse_inertia) * numbers.servo_bandwidth),
        torque_limit=each(numbers.torque_limit),
        stribeck_rate=each(0.05),
        **{
            name: each(0.0)
            for name in (
                "spin_down",
                "lag",
                "viscous",
                "coulomb",
                "stribeck",
                "static_imbalance",
                "dynamic_imbalance",
                "imbalance_phase",
            )
        },
    )


def cross(a: Array, b: Array) -> Array:
    """Return a × b, (..., 3), in a quarter of the time of NumPy's own, which looks after axes and dimensions first."""
    x, y, z = a[..., 0], a[..., 1], a[..., 2]
    u, v, w = b[..., 0], b[..., 1], b[..., 2]
    first = y * w - z * v
    product = np.empty((*first.shape, 3), dtype=first.dtype)
    product[..., 0], product[..., 1], product[..., 2] = first, z * u - x * w, x * v - y * u
    return product
