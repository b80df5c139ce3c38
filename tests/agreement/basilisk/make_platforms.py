"""Fly the six platforms of platforms.toml in Basilisk and freeze their trajectories in the folder platforms.

Basilisk's `reactionWheelStateEffector` (fully coupled wheels, each with its mass where it stands) and
`vscmgStateEffector` derive their own equations of motion, in another formalism (back-substitution on the hub) than a
multibody engine's. Geometry and the hub's share of mass and inertia are worked out here, not taken from the testbed. It
needs an environment of its own: see README.md here.
"""

from __future__ import annotations

import io
import sys
import tomllib
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
from Basilisk.architecture import messaging
from Basilisk.simulation import (
    dragDynamicEffector,
    reactionWheelStateEffector,
    spacecraft,
    vscmgStateEffector,
)
from Basilisk.utilities import SimulationBaseClass

HERE = Path(__file__).parent
STEP_NS, CHECK_STEP_NS = 250_000, 625_000
"""The frozen step and the one that it is checked with. A rule of the fourth order: the frozen one's error is 1/38 less
1/39 of what the two differ by."""
ANCHOR = 1e13
"""kg, on the pivot of an air bearing: what does not move in 10 s holds a platform as a ball joint does."""
SPEED = 1e3
"""m/s, of the flight through the air that stands for gravity: the drag slows it down by 4e-13 of itself in 10 s."""

Numbers = dict[str, Any]


def main() -> None:
    """Write a file for each platform, and print how well it has converged."""
    cases = tomllib.loads((HERE / "platforms.toml").read_text(encoding="utf-8"))
    (HERE / "platforms").mkdir(exist_ok=True)
    for name in sys.argv[1:] or cases["platforms"]:
        columns, trajectory = Flight(cases, cases["platforms"][name], STEP_NS).fly()
        _, check = Flight(cases, cases["platforms"][name], CHECK_STEP_NS).fly()
        error = np.abs(trajectory - check)[:, 1:4].max()
        path = HERE / "platforms" / f"{name}.csv"
        made = text("make_platforms.py", (STEP_NS, CHECK_STEP_NS), columns, trajectory, error)
        path.write_text(made, encoding="utf-8")
        print(f"{name}: body rate up to {np.abs(trajectory[:, 1:4]).max():.2f} rad/s, step error {error:.1e} rad/s")


class Units:
    """Where units stand and how their axes point, body axes; the origin is the platform's centre of mass."""

    def __init__(self, cases: Numbers, platform: Numbers) -> None:
        wheels, cmgs = platform.get("wheels"), platform.get("cmgs")
        self.wheel_axis = np.zeros((0, 3)) if wheels is None else wheel_axes(wheels)
        self.wheel_place = np.zeros((0, 3)) if wheels is None else np.array(wheels["position_m"])
        empty = (np.zeros((0, 3)),) * 3
        self.gimbal_axis, self.spin_axis, self.cmg_place = empty if cmgs is None else cmg_geometry(cmgs)
        self.transverse_axis = np.cross(self.gimbal_axis, self.spin_axis)
        self.wheel, self.cmg = cases["wheel"], cases["cmg"]

    def first_moment(self) -> np.ndarray:
        """Return sum(m r), shape (3,), kg m."""
        cmg_mass = self.cmg["gimbal_mass_kg"] + self.cmg["rotor_mass_kg"]
        return self.wheel["mass_kg"] * self.wheel_place.sum(axis=0) + cmg_mass * self.cmg_place.sum(axis=0)

    def mass(self) -> float:
        """Return the mass of all units, kg."""
        cmg_mass = self.cmg["gimbal_mass_kg"] + self.cmg["rotor_mass_kg"]
        return self.wheel["mass_kg"] * len(self.wheel_axis) + cmg_mass * len(self.cmg_place)

    def inertia(self) -> np.ndarray:
        """Return their inertia about the origin, gimbals at zero, shape (3, 3), kg m2."""
        total, wheel, cmg = np.zeros((3, 3)), self.wheel, self.cmg
        for axis, place in zip(self.wheel_axis, self.wheel_place, strict=True):
            spin = np.outer(axis, axis)
            total += wheel["spin_inertia_kg_m2"] * spin + wheel["transverse_inertia_kg_m2"] * (np.eye(3) - spin)
            total += wheel["mass_kg"] * parallel(place)
        for s, place in zip(self.spin_axis, self.cmg_place, strict=True):
            spin = np.outer(s, s)
            total += cmg["gimbal_inertia_kg_m2"] * np.eye(3) + cmg["rotor_spin_inertia_kg_m2"] * spin
            total += cmg["rotor_transverse_inertia_kg_m2"] * (np.eye(3) - spin)
            total += (cmg["gimbal_mass_kg"] + cmg["rotor_mass_kg"]) * parallel(place)
        return total


def wheel_axes(wheels: Numbers) -> np.ndarray:
    """Return the axes of wheels, shape (W, 3), as written or on a cone about z."""
    if "axis" in wheels:
        return np.array(wheels["axis"])
    skew, azimuth = np.deg2rad(wheels["pyramid_skew_deg"]), np.deg2rad([0.0, 90.0, 180.0, 270.0])
    return np.stack([np.sin(skew) * np.cos(azimuth), np.sin(skew) * np.sin(azimuth), np.full(4, np.cos(skew))], axis=1)


def cmg_geometry(cmgs: Numbers) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return gimbal axes, spin axes at gimbal angle zero and places of CMGs, each of shape (M, 3)."""
    units, skew, radius = len(cmgs["gimbal_angle_rad"]), np.deg2rad(cmgs["skew_deg"]), cmgs["mounting_radius_m"]
    if cmgs["array"] == "pyramid":
        azimuth = np.deg2rad(360.0 / units) * np.arange(units)
        c, s, zero = np.cos(azimuth), np.sin(azimuth), np.zeros(units)
        gimbal = np.stack([np.sin(skew) * c, np.sin(skew) * s, np.full(units, np.cos(skew))], axis=1)
        return gimbal, np.stack([-s, c, zero], axis=1), radius * np.stack([c, s, zero], axis=1)
    # A roof of two: gimbal axes to either side of z, spin axes along x and -x.
    gimbal = np.array([[0.0, np.sin(skew), np.cos(skew)], [0.0, -np.sin(skew), np.cos(skew)]])
    return gimbal, np.array([[1.0, 0, 0], [-1.0, 0, 0]]), 0.6 * radius * np.array([[0, 1.0, 0], [0, -1.0, 0]])


def parallel(place: np.ndarray) -> np.ndarray:
    """Return r^2 1 - r r^T of a place, shape (3, 3), m2."""
    return place @ place * np.eye(3) - np.outer(place, place)


class Flight:
    """A platform in Basilisk, flown by motors whose torques are set once in a control period."""

    def __init__(self, cases: Numbers, platform: Numbers, step_ns: int) -> None:
        self.cases, self.platform = cases, platform
        self.units = Units(cases, platform)
        self.simulation = SimulationBaseClass.SimBaseClass()
        self.simulation.CreateNewProcess("process").addTask(self.simulation.CreateNewTask("task", step_ns))
        self.pivot = platform.get("pivot")
        self.offset = np.array(self.pivot["center_of_mass_m"]) if self.pivot else np.zeros(3)
        self.body = self._hub()
        self.wheels, self.wheel_demand = self._wheels() if "wheels" in platform else (None, None)
        self.cmgs, self.cmg_demand = self._cmgs() if "cmgs" in platform else (None, None)
        if self.pivot:
            self._weigh()
        self.simulation.AddModelToTask("task", self.body)
        self.simulation.InitializeSimulation()

    def fly(self) -> tuple[list[str], np.ndarray]:
        """Return the names of columns and the trajectory, one row a sample.

        The states are read from the integrator itself: the effectors' output messages lag by one step.
        """
        period, each = round(1e9 * self.cases["control_period_s"]), self.cases["periods_per_sample"]
        states, columns = self._states()
        rows = []
        for tick in range(round(1e9 * self.cases["duration_s"]) // period + 1):
            self.simulation.ConfigureStopTime(tick * period)
            self.simulation.ExecuteSimulation()
            if tick % each == 0:
                rows.append(np.concatenate([[tick * period / 1e9], *(np.ravel(state.getState()) for state in states)]))
            self._demand(tick * period / 1e9, tick * period)
        return columns, np.array(rows)

    def _hub(self) -> spacecraft.Spacecraft:
        """Return what the units leave of the platform, and an anchor where the platform stands on a pivot."""
        body = spacecraft.Spacecraft()
        mass = self.cases["mass_kg"] - self.units.mass()
        center = -self.units.first_moment() / mass
        inertia = np.array(self.cases["inertia_kg_m2"]) - self.units.inertia() - mass * parallel(center)
        center = center + self.offset
        anchor = ANCHOR if self.pivot else 0.0
        body.hub.mHub = mass + anchor
        body.hub.r_BcB_B = column(mass / (mass + anchor) * center)
        body.hub.IHubPntBc_B = (inertia + mass * anchor / (mass + anchor) * parallel(center)).tolist()
        body.hub.r_CN_NInit = column([0.0, 0.0, 0.0])
        body.hub.v_CN_NInit = column([0.0, 0.0, SPEED if self.pivot else 0.0])
        body.hub.sigma_BNInit = column(mrp(self.cases["attitude_rad"]))
        body.hub.omega_BN_BInit = column(self.cases["body_rate_rad_s"])
        return body

    def _weigh(self) -> None:
        """Let gravity pull at the centre of mass.

        On a pivot that nothing can move, gravity is a force of constant size and direction at a point of the body.
        Basilisk's own effector of such a force is the drag on a sphere: against the velocity, here along z,
        which the anchor keeps, at the sphere's centre, here the centre of mass.
        """
        drag = self.drag = dragDynamicEffector.DragDynamicEffector()
        drag.coreParams.dragCoeff, drag.coreParams.projectedArea = 1.0, 1.0
        drag.coreParams.comOffset = self.offset.tolist()
        weight = self.cases["mass_kg"] * self.pivot["gravity_m_s2"]
        air = messaging.AtmoPropsMsgPayload()
        air.neutralDensity = 2.0 * weight / SPEED**2  # the drag is half of density and squared speed
        self.air = messaging.AtmoPropsMsg().write(air)
        drag.atmoDensInMsg.subscribeTo(self.air)
        self.body.addDynamicEffector(drag)
        self.simulation.AddModelToTask("task", drag)

    def _wheels(self) -> tuple[reactionWheelStateEffector.ReactionWheelStateEffector, messaging.ArrayMotorTorqueMsg]:
        effector, numbers = reactionWheelStateEffector.ReactionWheelStateEffector(), self.cases["wheel"]
        self._kept = []  # the effector keeps no wheel alive
        for axis, place, momentum in zip(
            self.units.wheel_axis, self.units.wheel_place, self.platform["wheels"]["momentum_N_m_s"], strict=True
        ):
            wheel = reactionWheelStateEffector.RWConfigPayload()
            wheel.RWModel = messaging.JitterFullyCoupled
            across = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
            across /= np.linalg.norm(across)
            wheel.gsHat_B, wheel.rWB_B = column(axis), column(place + self.offset)
            wheel.w2Hat0_B, wheel.w3Hat0_B = column(across), column(np.cross(axis, across))
            wheel.mass, wheel.Js = numbers["mass_kg"], numbers["spin_inertia_kg_m2"]
            wheel.Jt = wheel.Jg = numbers["transverse_inertia_kg_m2"]
            wheel.U_s = wheel.U_d = 0.0
            wheel.Omega = momentum / numbers["spin_inertia_kg_m2"]
            wheel.Omega_max, wheel.u_max, wheel.P_max = 1.0e4, numbers["torque_limit_N_m"], -1.0
            wheel.cViscous, wheel.betaStatic = numbers["viscous_friction_N_m_s"], -1.0
            effector.addReactionWheel(wheel)
            self._kept.append(wheel)
        demand = messaging.ArrayMotorTorqueMsg().write(messaging.ArrayMotorTorqueMsgPayload())
        effector.rwMotorCmdInMsg.subscribeTo(demand)
        self.body.addStateEffector(effector)
        self.simulation.AddModelToTask("task", effector)
        return effector, demand

    def _cmgs(self) -> tuple[vscmgStateEffector.VSCMGStateEffector, messaging.VSCMGArrayTorqueMsg]:
        effector, numbers = vscmgStateEffector.VSCMGStateEffector(), self.cases["cmg"]
        for index, angle in enumerate(self.platform["cmgs"]["gimbal_angle_rad"]):
            config = messaging.VSCMGConfigMsgPayload()
            config.VSCMGModel = vscmgStateEffector.vscmgBalancedWheels
            config.rGB_B = column(self.units.cmg_place[index] + self.offset)
            config.gsHat0_B, config.gtHat0_B = (
                column(self.units.spin_axis[index]),
                column(self.units.transverse_axis[index]),
            )
            config.ggHat_B = column(self.units.gimbal_axis[index])
            config.massG, config.massW = numbers["gimbal_mass_kg"], numbers["rotor_mass_kg"]
            config.IG1 = config.IG2 = config.IG3 = numbers["gimbal_inertia_kg_m2"]
            config.IW1 = numbers["rotor_spin_inertia_kg_m2"]
            config.IW2 = config.IW3 = numbers["rotor_transverse_inertia_kg_m2"]
            config.gamma, config.gammaDot = angle, 0.0
            config.Omega = numbers["rotor_momentum_N_m_s"] / numbers["rotor_spin_inertia_kg_m2"]
            config.u_s_max = config.u_s_min = config.u_g_max = config.u_g_min = -1.0
            config.wheelLinearFrictionRatio = config.gimbalLinearFrictionRatio = -1.0
            config.Omega_max, config.gammaDot_max = 1.0e4, -1.0
            config.rGcG_G = column([0.0, 0.0, 0.0])
            effector.AddVSCMG(config)
        demand = messaging.VSCMGArrayTorqueMsg().write(messaging.VSCMGArrayTorqueMsgPayload())
        effector.cmdsInMsg.subscribeTo(demand)
        self.body.addStateEffector(effector)
        self.simulation.AddModelToTask("task", effector)
        return effector, demand

    def _demand(self, time: float, nanoseconds: int) -> None:
        """Set the motors' torques for the period that begins."""
        if self.wheels is not None:
            torque = messaging.ArrayMotorTorqueMsgPayload()
            torque.motorTorque = swings(self.platform["wheels"]["torque_N_m"], time).tolist()
            self.wheel_demand.write(torque, nanoseconds)
        if self.cmgs is not None:
            numbers = self.cases["cmg"]
            inertia = numbers["gimbal_inertia_kg_m2"] + numbers["rotor_transverse_inertia_kg_m2"]
            rate = np.ravel(self.body.dynManager.getStateObject(self.cmgs.nameOfVSCMGGammaDotsState).getState())
            wanted = swings(self.platform["cmgs"]["gimbal_rate_rad_s"], time)
            torque = messaging.VSCMGArrayTorqueMsgPayload()
            torque.gimbalTorque = (inertia * numbers["gimbal_gain_1_s"] * (wanted - rate)).tolist()
            self.cmg_demand.write(torque, nanoseconds)

    def _states(self) -> tuple[list[Any], list[str]]:
        names, columns = ["hubOmega"], ["time_s", *(f"body_rate_{axis}_rad_s" for axis in "xyz")]
        if self.cmgs is not None:
            numbers = range(1, len(self.units.cmg_place) + 1)
            names += [self.cmgs.nameOfVSCMGGammasState, self.cmgs.nameOfVSCMGOmegasState]
            columns += [f"gimbal_angle_{number}_rad" for number in numbers]
            columns += [f"rotor_speed_{number}_rad_s" for number in numbers]
        if self.wheels is not None:
            names += [self.wheels.nameOfReactionWheelOmegasState]
            columns += [f"wheel_speed_{number}_rad_s" for number in range(1, len(self.units.wheel_axis) + 1)]
        return [self.body.dynManager.getStateObject(name) for name in names], columns


def swings(waves: list[list[float]], time: float) -> np.ndarray:
    """Return amplitude sin(frequency t + phase) of each wave."""
    amplitude, frequency, phase = np.array(waves).T
    return amplitude * np.sin(frequency * time + phase)


def column(vector: np.ndarray | list[float]) -> list[list[float]]:
    """Return a vector in the form that Basilisk takes."""
    return [[float(value)] for value in vector]


def mrp(rotation: list[float]) -> np.ndarray:
    """Return the modified Rodrigues parameters of a rotation vector."""
    angle = np.linalg.norm(rotation)
    return np.tan(angle / 4.0) * np.array(rotation) / angle


def text(script: str, steps_ns: tuple[int, int], columns: list[str], trajectory: np.ndarray, difference: float) -> str:
    """Return the frozen file: what made it, the column names, the numbers."""
    step, check = (nanoseconds / 1e6 for nanoseconds in steps_ns)
    buffer = io.StringIO()
    buffer.write(f"# Made by: {script}, with bsk {version('bsk')} and numpy {version('numpy')}\n")
    buffer.write(f"# RK4 at {step:g} ms; body rate differs by {difference:.1e} rad/s from that at {check:g} ms\n")
    buffer.write(",".join(columns) + "\n")
    np.savetxt(buffer, trajectory, fmt="%.13g", delimiter=",")
    return buffer.getvalue()


if __name__ == "__main__":
    main()
