"""What flies in Basilisk, and what can be hidden in it: numbers of the engine's modules, or modules more."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from concealing.craft import Array
from concealing.inner_effects import point_inertia
from concealing.power import UnreachableError
from concealing.wheel_case import WheelPlatform
from concealing.wheels import Wheels
from testbed.dynamics.environment import EARTH, EARTH_RADIUS

_FARTHEST = -0.9
"""Relative error of the gravity gradient on an orbit of twice the radius, the highest that is flown."""
_PANEL = (0.8, 0.4)
"""Length and width, m; its hinge as far from the centre of the satellite as its own centre is from the hinge."""
STEPS = tuple(
    sorted({50_000_000 // (2**a * 5**b) for a in range(8) for b in range(8)} & set(range(50_000, 5_000_001)))[::-1]
)
"""ns, those of which half a control period is a whole number: 5 ms, 4 ms ... 0.05 ms."""
_BIAS, _TURNS = 0.5, np.array([1.0, -1.0, 1.0, -1.0])
"""Share of their limits at which wheels turn at release, and which way: in a pyramid of four no momentum in all. None
stands still then in a flight, as is usual in orbit; where one may stick, a diagnosis compares none."""
_LARGEST_SHARE = 0.3
"""Of the mass of the satellite, in parts that move."""


@dataclass(frozen=True, kw_only=True)
class Gyro:
    """Of the module imuSensor.

    Attributes:
        bias: rad/s.
        scale: of each axis.
        turn: rotation vector from the body's axes to its own, rad.
        late: s, from its sampling to its reading out.
    """

    bias: Array = field(default_factory=lambda: np.zeros(3))
    scale: Array = field(default_factory=lambda: np.ones(3))
    turn: Array = field(default_factory=lambda: np.zeros(3))
    late: float = 0.0


@dataclass(frozen=True, kw_only=True)
class Panel:
    """Of the module hingedRigidBodyStateEffector: a flat plate that stands outwards from its hinge.

    Attributes:
        mass: kg.
        outward: unit vector from the centre of the satellite to its hinge and its centre.
        hinge_axis: unit vector normal to that.
        frequency: of the mode with the satellite kept from turning, Hz.
        damping_ratio: of that mode.
    """

    mass: float
    outward: Array
    hinge_axis: Array
    frequency: float
    damping_ratio: float


@dataclass(frozen=True, kw_only=True)
class Tank:
    """Of three modules linearSpringMassDamper at one place, along x, y and z: a mass on springs in every direction.

    Attributes:
        mass: kg.
        place: from the centre of the satellite, m.
        frequency: of each with the satellite kept from turning, Hz.
        damping_ratio: of each.
    """

    mass: float
    place: Array
    frequency: float
    damping_ratio: float


@dataclass(frozen=True, kw_only=True)
class Craft:
    """What flies.

    Attributes:
        inertia: of all of it at rest, about its centre of mass, (3, 3), kg·m².
        mass: of all of it, kg.
        wheels: as they are.
        torque: from outside, constant in body axes, N·m.
        gyro: its errors.
        gradient_error: of the gravity gradient over what its scenario believes, less 1.
        panel: that is hinged, if any.
        tank: with liquid, if any.
    """

    inertia: Array
    mass: float
    wheels: Wheels
    torque: Array = field(default_factory=lambda: np.zeros(3))
    gyro: Gyro = field(default_factory=Gyro)
    gradient_error: float = 0.0
    panel: Panel | None = None
    tank: Tank | None = None


def flyable_delay(delay: float) -> float:
    """Return a delay of the gyro that is a whole number of the steps that `step_of` gives it, s."""
    step = step_of(delay)
    return 1e-9 * step * max(round(1e9 * delay / step), 1)


def step_of(delay: float) -> int:
    """Return the coarsest step in which a delay is a whole number of steps, but for 5 % of it, ns.

    The step is a whole part of half a control period of 0.1 s, and of a nanosecond a multiple.
    """
    return next(
        (step for step in STEPS if abs(step * max(round(1e9 * delay / step), 1) - 1e9 * delay) <= 0.05e9 * delay),
        STEPS[-1],
    )


def panel_mode(panel: Panel, mass: float) -> tuple[float, float, Array]:
    """Return what turns on the hinge, the inertia of the mode as the satellite feels it, kg·m², and its axis.

    The satellite moves along: a panel's mass m counts as m (1 - m/M). About the hinge then I_r = I + μ d²; a rotation ω
    feels δ = I + μ (2 d) d along the hinge, and the mode is that of a disc of the inertia δ²/I_r.
    """
    length, distance = _PANEL[0], 0.5 * _PANEL[0]
    own, reduced = panel.mass * length**2 / 12.0, panel.mass * (1.0 - panel.mass / mass)
    about_hinge, felt = own + reduced * distance**2, own + reduced * 2.0 * distance**2
    return about_hinge, felt**2 / about_hinge, panel.hinge_axis


def drawn_craft(platform: WheelPlatform, inertia: Array) -> Craft:
    """Return a platform as it is drawn, with another inertia."""
    return Craft(inertia=inertia, mass=platform.mass, wheels=platform.wheels)


def engine_craft(
    craft: Craft, platform: WheelPlatform, altitude: float | None, believed: Mapping[str, Any]
) -> dict[str, Any]:
    """Return a craft in the numbers of Basilisk's modules.

    Args:
        craft: what flies.
        platform: as it is believed.
        altitude: of the orbit that is believed, m; None of a satellite that flies freely.
        believed: gains, errors of the navigation, and lines of the encoders.

    Raises:
        UnreachableError: there is no such craft.
    """
    panels, particles = _panels(craft), _particles(craft)
    return {
        "hub": _hub(craft),
        "drawn_inertia_kg_m2": platform.inertia.tolist(),
        "orbit": None if altitude is None else _orbit(altitude, craft.gradient_error),
        "torque_N_m": craft.torque.tolist(),
        "panels": panels,
        "particles": particles,
        "wheels": _wheels(craft.wheels, platform),
        "drawn_wheels": _wheels(platform.wheels, platform),
        "gyro": {
            "noise_rad_s": platform.sensors.gyro_noise,
            "bias_rad_s": craft.gyro.bias.tolist(),
            "scale": craft.gyro.scale.tolist(),
            "dcm_PB": Rotation.from_rotvec(craft.gyro.turn).as_matrix().T.tolist(),
            "late_ns": round(1e9 * craft.gyro.late),
        },
        "control_period_s": 1.0 / platform.control_rate,
        **believed,
    }


def _wheels(wheels: Wheels, platform: WheelPlatform) -> list[dict[str, Any]]:
    speeds = _BIAS * _TURNS * platform.momentum_limit / platform.wheels.spin_inertia
    return [
        {
            "axis": wheels.axis[index].tolist(),
            "spin_inertia_kg_m2": float(wheels.spin_inertia[index]),
            "speed_rad_s": float(speeds[index]),
            "torque_limit_N_m": float(wheels.torque_limit[index]),
            "position_m": wheels.position[index].tolist(),
            "coulomb_N_m": float(wheels.coulomb[index]),
            "viscous_N_m_s_rad": float(wheels.viscous[index]),
            "imbalance_kg_m": float(wheels.imbalance[index]),
            "torque_factor": float(wheels.torque_factor[index]),
        }
        for index in range(len(speeds))
    ]


def _orbit(altitude: float, error: float) -> dict[str, Any]:
    """Return where a circular orbit begins, N its local axes there; μ/r³ is 1 + error as believed."""
    if error < _FARTHEST:
        raise UnreachableError(f"no orbit has {1.0 + error:.2f} of the gravity gradient that is believed")
    radius = (EARTH_RADIUS + altitude) * (1.0 + error) ** (-1.0 / 3.0)
    return {"position_m": [0.0, 0.0, -radius], "velocity_m_s": [float(np.sqrt(EARTH / radius)), 0.0, 0.0]}


def _hub(craft: Craft) -> dict[str, Any]:
    """Return the rigid rest, whose centre is where Basilisk counts from: whole less parts, about the common centre."""
    parts = [(mass, place, own) for mass, place, own in _parts(craft)]
    mass = craft.mass - sum(each for each, _, _ in parts)
    if mass < (1.0 - _LARGEST_SHARE) * craft.mass:
        raise UnreachableError(f"parts of {craft.mass - mass:.3g} kg in a satellite of {craft.mass:g} kg")
    centre = sum((each * place for each, place, _ in parts), np.zeros(3)) / craft.mass
    inertia = craft.inertia - point_inertia(mass, -centre)
    for each, place, own in parts:
        inertia = inertia - own - point_inertia(each, place - centre)
    if np.linalg.eigvalsh(inertia).min() <= 0.0:
        raise UnreachableError("the parts that move have more inertia than the satellite")
    return {"mass_kg": mass, "inertia_kg_m2": inertia.tolist()}


def _parts(craft: Craft) -> list[tuple[float, Array, Array]]:
    """Return mass, place and inertia about its own centre of each part that moves, as it rests."""
    parts = []
    if craft.panel is not None:
        turned = np.array(_panel_axes(craft.panel))
        own = turned.T @ np.diag(_plate(craft.panel.mass)) @ turned
        parts.append((craft.panel.mass, _PANEL[0] * craft.panel.outward, own))
    if craft.tank is not None:
        parts += [(craft.tank.mass, craft.tank.place, np.zeros((3, 3)))] * 3
    return parts


def _plate(mass: float) -> Array:
    length, width = _PANEL
    return mass / 12.0 * np.array([width**2, length**2, length**2 + width**2])


def _panel_axes(panel: Panel) -> list[Array]:
    """Return the panel's axes, rows: inwards, along the hinge, normal to the plate."""
    return [-panel.outward, panel.hinge_axis, np.cross(-panel.outward, panel.hinge_axis)]


def _panels(craft: Craft) -> list[dict[str, Any]]:
    panel = craft.panel
    if panel is None:
        return []
    turning, circular = panel_mode(panel, craft.mass)[0], 2.0 * np.pi * panel.frequency
    return [
        {
            "mass_kg": panel.mass,
            "distance_m": 0.5 * _PANEL[0],
            "stiffness_N_m_rad": turning * circular**2,
            "damping_N_m_s_rad": 2.0 * panel.damping_ratio * turning * circular,
            "inertia_kg_m2": np.diag(_plate(panel.mass)).tolist(),
            "dcm_HB": np.array(_panel_axes(panel)).tolist(),
            "hinge_m": (0.5 * _PANEL[0] * panel.outward).tolist(),
        }
    ]


def _particles(craft: Craft) -> list[dict[str, Any]]:
    tank = craft.tank
    if tank is None:
        return []
    moving, circular = tank.mass * (1.0 - tank.mass / craft.mass), 2.0 * np.pi * tank.frequency
    return [
        {
            "mass_kg": tank.mass,
            "stiffness_N_m": moving * circular**2,
            "damping_N_s_m": 2.0 * tank.damping_ratio * moving * circular,
            "place_m": tank.place.tolist(),
            "direction": direction.tolist(),
        }
        for direction in np.eye(3)
    ]
