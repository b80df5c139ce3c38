"""Flights of our plant that another engine has flown too, and what the two differ by."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from scipy.spatial.transform import Rotation

from testbed.arrays import Array
from testbed.cmg.wheels import wheel_axes
from testbed.dynamics.gravity_gradient import gravity_gradient_torque
from testbed.plant.build import build
from testbed.plant.geometry import composite_inertia
from testbed.plant.layout import layout_of
from testbed.plant.plant import Plant
from testbed.plant.properties import AirBearing, InitialState, PlatformProperties, WheelProperties

FOLDER = Path(__file__).resolve().parents[1] / "tests" / "agreement" / "basilisk"
CASES: dict[str, Any] = tomllib.loads((FOLDER / "platforms.toml").read_text(encoding="utf-8"))
PLATFORMS = tuple(CASES["platforms"])


@dataclass(frozen=True, kw_only=True)
class Motion:
    """A platform's motion, one row a sample.

    Attributes:
        time: shape (N,), s.
        body_rate: shape (N, 3), rad/s, body axes.
        gimbal_angle: shape (N, M), rad.
        rotor_speed: shape (N, M), rad/s.
        wheel_speed: shape (N, W), rad/s.
    """

    time: Array
    body_rate: Array
    gimbal_angle: Array
    rotor_speed: Array
    wheel_speed: Array


def frozen(name: str) -> Motion:
    """Return what Basilisk flew."""
    with (FOLDER / "platforms" / f"{name}.csv").open(encoding="utf-8") as lines:
        table = np.genfromtxt((line for line in lines if not line.startswith("#")), delimiter=",", names=True)

    def columns(signal: str) -> Array:
        found = [table[column] for column in table.dtype.names if column.startswith(signal)]
        return np.stack(found, axis=1) if found else np.zeros((len(table), 0))

    return Motion(
        time=table["time_s"],
        body_rate=columns("body_rate"),
        gimbal_angle=columns("gimbal_angle"),
        rotor_speed=columns("rotor_speed"),
        wheel_speed=columns("wheel_speed"),
    )


def flown(name: str, step: float, cases: dict[str, Any] = CASES) -> Motion:
    """Return what our plant flies with a step that divides the control period, s."""
    platform, cmg = cases["platforms"][name], cases["cmg"]
    plant = _plant(platform, cases, step)
    layout, period = plant.layout, cases["control_period_s"]
    gain = cmg["gimbal_gain_1_s"] * (cmg["gimbal_inertia_kg_m2"] + cmg["rotor_transverse_inertia_kg_m2"])
    rows = []
    for tick in range(round(cases["duration_s"] / period) + 1):
        if tick % cases["periods_per_sample"] == 0:
            rows.append((tick * period, plant.qpos[0].copy(), plant.qvel[0].copy()))
        wanted = _swings(platform.get("cmgs", {}).get("gimbal_rate_rad_s", []), tick * period)
        torque = _swings(platform.get("wheels", {}).get("torque_N_m", []), tick * period)
        plant.advance(gain * (wanted - plant.gimbal_rate[0]), round(period / step), torque)
    assert not plant.divergence, plant.divergence
    time, qpos, qvel = (np.array(each) for each in zip(*rows, strict=True))
    return Motion(
        time=time,
        body_rate=qvel[:, layout.body_rate],
        gimbal_angle=qpos[:, layout.gimbal_angle],
        rotor_speed=qvel[:, layout.rotor_speed],
        wheel_speed=qvel[:, layout.wheel_speed],
    )


def difference(name: str, step: float) -> float:
    """Return the largest difference of any body rate from Basilisk's, rad/s."""
    return float(np.abs(flown(name, step).body_rate - frozen(name).body_rate).max())


def _plant(platform: dict[str, Any], cases: dict[str, Any], step: float) -> Plant:
    cmgs, wheels, pivot = platform.get("cmgs"), platform.get("wheels"), platform.get("pivot")
    units, cmg = len(cmgs["gimbal_angle_rad"]) if cmgs else 0, cases["cmg"]
    properties = PlatformProperties(
        inertia=np.array(cases["inertia_kg_m2"]),
        mass=cases["mass_kg"],
        units=units,
        array=cmgs["array"] if cmgs else "pyramid",
        skew=np.radians(cmgs["skew_deg"]) if cmgs else None,
        mounting_radius=cmgs["mounting_radius_m"] if cmgs else None,
        rotor_spin_inertia=cmg["rotor_spin_inertia_kg_m2"],
        rotor_transverse_inertia=cmg["rotor_transverse_inertia_kg_m2"],
        rotor_mass=cmg["rotor_mass_kg"],
        gimbal_inertia=cmg["gimbal_inertia_kg_m2"],
        gimbal_mass=cmg["gimbal_mass_kg"],
        gimbal_servo_bandwidth=0.0,  # the tachometer loop is off: a torque demand is the motor's torque
        step=step,
        wheels=_wheels(wheels, cases["wheel"]) if wheels else (),
        air_bearing=_bearing(pivot) if pivot else None,
    )
    start = InitialState(
        body_rate=np.array(cases["body_rate_rad_s"]),
        attitude=Rotation.from_rotvec(cases["attitude_rad"]).as_quat(scalar_first=True),
        position=np.zeros(3),
        velocity=np.zeros(3),
        gimbal_angle=np.array(cmgs["gimbal_angle_rad"] if cmgs else []),
    )
    return Plant(
        [build(properties)],
        initial=[start],
        rotor_momentum=np.full((1, units), cmg["rotor_momentum_N_m_s"]),
        rotors="free",
        wheel_momentum=np.array([wheels["momentum_N_m_s"] if wheels else []]),
    )


def _bearing(pivot: dict[str, Any]) -> AirBearing:
    return AirBearing(center_of_mass_B=np.array(pivot["center_of_mass_m"]), gravity=pivot["gravity_m_s2"])


def _wheels(wheels: dict[str, Any], wheel: dict[str, Any]) -> tuple[WheelProperties, ...]:
    axes = wheels["axis"] if "axis" in wheels else wheel_axes("pyramid", 4, np.radians(wheels["pyramid_skew_deg"]))
    return tuple(
        WheelProperties(
            axis_B=np.asarray(axis),
            position_B=np.array(position),
            mass=wheel["mass_kg"],
            spin_inertia=wheel["spin_inertia_kg_m2"],
            transverse_inertia=wheel["transverse_inertia_kg_m2"],
            torque_limit=wheel["torque_limit_N_m"],
            viscous_friction=wheel["viscous_friction_N_m_s"],
        )
        for axis, position in zip(axes, wheels["position_m"], strict=True)
    )


def _swings(waves: list[list[float]], time: float) -> Array:
    amplitude, frequency, phase = np.array(waves).reshape(-1, 3).T
    return np.asarray(amplitude * np.sin(frequency * time + phase))


def orbited(step: float, cases: dict[str, Any] = CASES) -> Array:
    """Return the body rate of our plant on the orbit, shape (N, 3), rad/s, with a step that divides a sample, s.

    The torque is taken at the middle of each step, by its last two values.
    """
    orbit = cases["orbit"]
    model = build(
        PlatformProperties(inertia=np.array(cases["inertia_kg_m2"]), mass=cases["mass_kg"], units=0, step=step)
    )
    inertia, layout, data = composite_inertia(model), layout_of(model), mujoco.MjData(model)
    rate = np.sqrt(orbit["gravitational_parameter_m3_s2"] / orbit["radius_m"] ** 3)
    data.qpos[layout.attitude] = Rotation.from_rotvec(cases["attitude_rad"]).as_quat(scalar_first=True)
    data.qvel[layout.body_rate] = orbit["body_rate_rad_s"]
    each, before, rows = round(orbit["sample_s"] / step), None, []
    for number in range(round(orbit["duration_s"] / step) + 1):
        if number % each == 0:
            rows.append(data.qvel[layout.body_rate].copy())
        outward_N = np.array([np.cos(rate * data.time), np.sin(rate * data.time), 0.0])
        turn_NB = Rotation.from_quat(data.qpos[layout.attitude], scalar_first=True)
        torque = gravity_gradient_torque(inertia, turn_NB.inv().apply(outward_N), rate)
        data.qfrc_applied[layout.body_rate] = torque if before is None else 1.5 * torque - 0.5 * before
        before = torque
        mujoco.mj_step(model, data)
    return np.array(rows)
