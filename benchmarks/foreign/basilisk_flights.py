"""Closed-loop flights in Basilisk, in an environment of its own: nothing of the testbed is imported here.

python basilisk_flights.py errors CASE.json   prints how far each step is from its own converged solution, as JSON
python basilisk_flights.py worker CASE.json     flies the case's runs for every line read (see benchmarks/paired.py)

The chain is simpleNav -> inertial3D -> attTrackingError -> mrpFeedback -> vscmgVelocitySteering -> vscmgGimbalRateServo
-> vscmgStateEffector, default RK4, no recorders. Flight software runs at the control rate in a task of its own, after
the dynamics; the effector is in that task too, first, because its speeds would otherwise be one integrator step old and
the loop would converge with the first power of the step only. With "control_step_s" null everything is in one task.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import numpy as np
from Basilisk.architecture import messaging
from Basilisk.fswAlgorithms import (
    attTrackingError,
    inertial3D,
    mrpFeedback,
    vscmgGimbalRateServo,
    vscmgVelocitySteering,
)
from Basilisk.simulation import simpleNav, spacecraft, vscmgStateEffector
from Basilisk.utilities import SimulationBaseClass, fswSetupVSCMGs

UNITS = 6


class Geometry:
    """Axes, places and inertias of the six-sided pyramid, from the case's numbers; shapes (6, 3)."""

    def __init__(self, platform: dict[str, Any]) -> None:
        skew, azimuth = platform["skew_rad"], np.deg2rad(60.0) * np.arange(UNITS)
        zero = np.zeros(UNITS)
        level = np.stack([np.cos(azimuth), np.sin(azimuth), zero], axis=1)
        self.gimbal_axis = np.sin(skew) * level + np.cos(skew) * np.array([0.0, 0.0, 1.0])
        self.spin_axis = np.stack([-np.sin(azimuth), np.cos(azimuth), zero], axis=1)
        self.transverse_axis = np.cross(self.gimbal_axis, self.spin_axis)
        self.position = platform["mounting_radius_m"] * level
        self.inertia = np.array(platform["inertia_kg_m2"])

    def hub_inertia(self, platform: dict[str, Any]) -> np.ndarray:
        """Return what the units leave of the platform's inertia, rotors locked, kg m2."""
        gimbal, mass = platform["gimbal_inertia_kg_m2"], platform["gimbal_mass_kg"] + platform["rotor_mass_kg"]
        spin, across = platform["rotor_spin_inertia_kg_m2"], platform["rotor_transverse_inertia_kg_m2"]
        hub = self.inertia.copy()
        for s, r in zip(self.spin_axis, self.position, strict=True):
            hub -= (gimbal + across) * np.eye(3) + (spin - across) * np.outer(s, s)
            hub -= mass * (r @ r * np.eye(3) - np.outer(r, r))
        return hub


def column(vector: Any) -> list[list[float]]:
    """Return a vector in the form that Basilisk takes."""
    return [[float(value)] for value in vector]


def unit(platform: dict[str, Any], geometry: Geometry, index: int) -> Any:
    """Return one unit: balanced, without friction or limits, gimbal at zero and at rest."""
    config = messaging.VSCMGConfigMsgPayload()
    config.VSCMGModel = vscmgStateEffector.vscmgBalancedWheels
    config.rGB_B = column(geometry.position[index])
    config.gsHat0_B, config.gtHat0_B = column(geometry.spin_axis[index]), column(geometry.transverse_axis[index])
    config.ggHat_B = column(geometry.gimbal_axis[index])
    config.massG, config.massW = platform["gimbal_mass_kg"], platform["rotor_mass_kg"]
    config.IG1 = config.IG2 = config.IG3 = platform["gimbal_inertia_kg_m2"]
    config.IW1 = platform["rotor_spin_inertia_kg_m2"]
    config.IW2 = config.IW3 = platform["rotor_transverse_inertia_kg_m2"]
    config.Omega = platform["rotor_momentum_N_m_s"] / platform["rotor_spin_inertia_kg_m2"]
    config.u_s_max = config.u_s_min = config.u_g_max = config.u_g_min = -1.0
    config.wheelLinearFrictionRatio = config.gimbalLinearFrictionRatio = -1.0
    config.Omega_max, config.gammaDot_max = 1.0e4, -1.0
    config.rGcG_G = column([0.0, 0.0, 0.0])
    return config


class Flight:
    """One flight, ready to go. Basilisk keeps no references of its own: what is built has to be kept here."""

    def __init__(self, case: dict[str, Any], step_ns: int, attitude: list[float]) -> None:
        platform, geometry = case["platform"], Geometry(case["platform"])
        self.body = self._spacecraft(platform, geometry, attitude)
        self.units = vscmgStateEffector.VSCMGStateEffector()
        fswSetupVSCMGs.clearSetup()
        for index in range(UNITS):
            config = unit(platform, geometry, index)
            self.units.AddVSCMG(config)
            self._announce(config)
        self.body.addStateEffector(self.units)
        self.software = self._software(case, geometry)
        self.simulation = self._schedule(case, step_ns)

    def body_rate(self) -> np.ndarray:
        """Return the integrator's own body rate, rad/s: messages lag."""
        return np.ravel(self.body.dynManager.getStateObject("hubOmega").getState())

    def gimbal_rate(self) -> np.ndarray:
        """Return the integrator's own gimbal rates, rad/s."""
        return np.ravel(self.body.dynManager.getStateObject(self.units.nameOfVSCMGGammaDotsState).getState())

    def fly_to(self, nanoseconds: int) -> None:
        """Go on to a time."""
        self.simulation.ConfigureStopTime(nanoseconds)
        self.simulation.ExecuteSimulation()

    def _spacecraft(self, platform: dict[str, Any], geometry: Geometry, attitude: list[float]) -> Any:
        body = spacecraft.Spacecraft()
        body.hub.mHub = platform["mass_kg"] - UNITS * (platform["gimbal_mass_kg"] + platform["rotor_mass_kg"])
        body.hub.r_BcB_B = body.hub.r_CN_NInit = body.hub.v_CN_NInit = column([0.0, 0.0, 0.0])
        body.hub.omega_BN_BInit = column([0.0, 0.0, 0.0])
        body.hub.sigma_BNInit = column(attitude)
        body.hub.IHubPntBc_B = geometry.hub_inertia(platform).tolist()
        return body

    def _announce(self, config: Any) -> None:
        fswSetupVSCMGs.create(
            *(np.ravel(axis) for axis in (config.gsHat0_B, config.gtHat0_B, config.ggHat_B)),
            *(config.IG1, config.IG2, config.IG3, config.IW1, config.IW2, config.IW3, config.Omega, 0.0, 0.0),
        )

    def _software(self, case: dict[str, Any], geometry: Geometry) -> list[Any]:
        self.parameters = fswSetupVSCMGs.writeConfigMessage()
        vehicle = messaging.VehicleConfigMsgPayload()
        vehicle.ISCPntB_B = geometry.inertia.ravel().tolist()
        self.vehicle = messaging.VehicleConfigMsg().write(vehicle)
        navigation, reference = simpleNav.SimpleNav(), inertial3D.inertial3D()
        error, feedback = attTrackingError.attTrackingError(), mrpFeedback.mrpFeedback()
        steering, servo = vscmgVelocitySteering.VscmgVelocitySteering(), vscmgGimbalRateServo.VscmgGimbalRateServo()
        navigation.scStateInMsg.subscribeTo(self.body.scStateOutMsg)
        reference.sigma_R0N = [0.0, 0.0, 0.0]
        error.attNavInMsg.subscribeTo(navigation.attOutMsg)
        error.attRefInMsg.subscribeTo(reference.attRefOutMsg)
        feedback.guidInMsg.subscribeTo(error.attGuidOutMsg)
        feedback.vehConfigInMsg.subscribeTo(self.vehicle)
        feedback.K, feedback.P, feedback.Ki = case["attitude_gain_N_m"], case["rate_gain_N_m_s"], -1.0
        steering.setMu(0.0)
        steering.setW0_s([0.0] * UNITS)  # the rotors keep their speed: control moment gyros only
        steering.setW_g([1.0] * UNITS)
        steering.vehControlInMsg.subscribeTo(feedback.cmdTorqueOutMsg)
        steering.attGuideInMsg.subscribeTo(error.attGuidOutMsg)
        steering.vscmgParamsInMsg.subscribeTo(self.parameters)
        servo.vsmcgParamsInMsg.subscribeTo(self.parameters)
        servo.setK_gammaDot(case["servo_gain_1_s"])
        servo.vscmgRefStatesInMsg.subscribeTo(steering.vscmgRefStatesOutMsg)
        for module, message in ((steering, steering.attNavInMsg), (servo, servo.attInMsg)):
            message.subscribeTo(navigation.attOutMsg)
            module.speedsInMsg.subscribeTo(self.units.speedOutMsg)
        servo.cmdsOutMsg.write(messaging.VSCMGArrayTorqueMsgPayload())  # an unwritten command is an error
        self.units.cmdsInMsg.subscribeTo(servo.cmdsOutMsg)
        return [navigation, reference, error, feedback, steering, servo]

    def _schedule(self, case: dict[str, Any], step_ns: int) -> Any:
        simulation = SimulationBaseClass.SimBaseClass()
        process = simulation.CreateNewProcess("process")
        process.addTask(simulation.CreateNewTask("dynamics", step_ns), 10)
        if case["control_step_s"] is None:
            order = [("dynamics", module) for module in [*self.software, self.units, self.body]]
        else:
            process.addTask(simulation.CreateNewTask("software", round(1e9 * case["control_step_s"])), 5)
            order = [("dynamics", self.units), ("dynamics", self.body)]
            order += [("software", module) for module in [self.units, *self.software]]
        for task, module in order:
            simulation.AddModelToTask(task, module)
        simulation.InitializeSimulation()
        return simulation


def body_rates(case: dict[str, Any], step_ns: int, attitude: list[float]) -> np.ndarray:
    """Return the body rate at the case's samples, shape (N, 3), rad/s."""
    flight = Flight(case, step_ns, attitude)
    rates = []
    for nanoseconds in range(0, round(1e9 * case["duration_s"]) + 1, round(1e9 * case["sample_s"])):
        flight.fly_to(nanoseconds)
        rates.append(flight.body_rate())
    return np.array(rates)


def largest_gimbal_rate(case: dict[str, Any], attitude: list[float]) -> float:
    """Return how fast a gimbal turns at most in a flight, rad/s."""
    flight, largest = Flight(case, 1_250_000, attitude), 0.0
    for nanoseconds in range(0, round(1e9 * case["duration_s"]) + 1, 12_500_000):
        flight.fly_to(nanoseconds)
        largest = max(largest, float(np.abs(flight.gimbal_rate()).max()))
    return largest


def errors(case: dict[str, Any]) -> dict[str, Any]:
    """Return each step's largest difference of the body rate to a tenth of the step, rad/s."""
    flown = case["attitudes"][: case["checked"]]
    steps = {
        str(step): max(
            float(np.abs(body_rates(case, step, start) - body_rates(case, step // 10, start)).max()) for start in flown
        )
        for step in case["steps_ns"]
    }
    return {"errors": steps, "gimbal_rate": max(largest_gimbal_rate(case, start) for start in flown)}


def serve(case: dict[str, Any]) -> None:
    """Fly all of the case's runs for every line that comes in."""
    Flight(case, case["step_ns"], case["attitudes"][0])
    print("ready", flush=True)
    for _ in sys.stdin:
        for attitude in case["attitudes"]:
            Flight(case, case["step_ns"], attitude).fly_to(round(1e9 * case["duration_s"]))
        print("done", flush=True)


if __name__ == "__main__":
    task, path = sys.argv[1:]
    content = json.loads(Path(path).read_text(encoding="utf-8"))
    if task == "errors":
        print(json.dumps(errors(content)))
    else:
        serve(content)
