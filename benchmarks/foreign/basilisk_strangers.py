"""Flights of a craft with wheels in Basilisk, in an environment of its own: nothing of the testbed is imported here.

python basilisk_strangers.py    reads lines of two paths from standard input, what is to be flown (JSON) and where its
                                channels go (.npz), and answers each with a line `done`

Everything that flies is a module of Basilisk: waypointReference -> attTrackingError -> mrpFeedback -> rwMotorTorque ->
rwMotorVoltage -> motorVoltageInterface -> reactionWheelStateEffector, closed over simpleNav and its errors; the gyro is
imuSensor, the tachometers are encoder. What is hidden is a number of one of these modules, or a module more:
extForceTorque, hingedRigidBodyStateEffector, linearSpringMassDamper, another orbit under GravityGradientEffector.

The software runs at the control rate, after the dynamics of the same instant, so that a command acts from the instant
of the reading that it answers to. A late gyro is one that is called some time before the recorders: these find its last
message.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import numpy as np
from Basilisk.architecture import messaging
from Basilisk.fswAlgorithms import attTrackingError, mrpFeedback, rwMotorTorque, rwMotorVoltage, waypointReference
from Basilisk.simulation import (
    GravityGradientEffector,
    encoder,
    extForceTorque,
    hingedRigidBodyStateEffector,
    imuSensor,
    linearSpringMassDamper,
    motorVoltageInterface,
    reactionWheelStateEffector,
    simpleNav,
    spacecraft,
)
from Basilisk.utilities import SimulationBaseClass, macros, simIncludeGravBody, simIncludeRW

VOLTS = 12.0
"""Of a motor at its torque limit: any, as command and torque are both in N m."""
SIGMA, OMEGA, NAVIGATED = slice(6, 9), slice(9, 12), 18
"""Places of attitude and rate among the states of simpleNav."""


def column(vector: Any) -> list[list[float]]:
    """Return a vector in the form that Basilisk takes."""
    return [[float(value)] for value in vector]


class Flight:
    """One flight, ready to go. Basilisk keeps no references of its own: what is built has to be kept here."""

    def __init__(self, craft: dict[str, Any], run: dict[str, Any]) -> None:
        self.craft, self.run = craft, run
        self.body = self._spacecraft()
        self.around = [*self._orbit(), *self._external_torque()]
        self.parts = [*self._panels(), *self._particles()]
        self.wheels, self.factory = self._wheels()
        self.instruments = self._instruments()
        self.software = self._software()
        self.simulation = self._schedule()

    def fly(self) -> dict[str, np.ndarray]:
        """Return the channels of the whole flight, each from its first reading on."""
        self.simulation.InitializeSimulation()
        end, late = macros.sec2nano(self.run["duration_s"]), self.craft["gyro"]["late_ns"]
        if late:
            self._read_gyro_early(late, end)
        self._go_on(end)
        count = len(self.craft["wheels"])
        return {
            "time": self.gyro.times() * macros.NANO2SEC,
            "body_rate": np.array(self.gyro.AngVelPlatform),
            "wheel_speed": np.array(self.tachometers.wheelSpeeds)[:, :count],
            "wheel_torque_command": np.array(self.commands.motorTorque)[:, :count],
            "attitude_mrp": np.array(self.attitude.sigma_BN),
            "true_time": self.motion.times() * macros.NANO2SEC,
            "true_body_rate": np.array(self.motion.omega_BN_B),
            "true_attitude_mrp": np.array(self.motion.sigma_BN),
            "true_wheel_speed": np.array(self.turning.wheelSpeeds)[:, :count],
        }

    def _read_gyro_early(self, early: int, end: int) -> None:
        """Call the gyro so long before the recorders, ns; a task's first start is lost when a simulation begins."""
        self.simulation.disableTask("gyro")
        period = macros.sec2nano(self.craft["control_period_s"])
        for instant in range(period, end + 1, period):
            self._go_on(instant - early)
            self.imu.UpdateState(instant - early)

    def _go_on(self, instant: int) -> None:
        self.simulation.ConfigureStopTime(instant)
        self.simulation.ExecuteSimulation()

    def _spacecraft(self) -> Any:
        body, hub, orbit = spacecraft.Spacecraft(), self.craft["hub"], self.craft["orbit"]
        body.hub.mHub, body.hub.r_BcB_B = hub["mass_kg"], column([0.0, 0.0, 0.0])
        body.hub.IHubPntBc_B = hub["inertia_kg_m2"]
        body.hub.r_CN_NInit = column(orbit["position_m"] if orbit else [0.0, 0.0, 0.0])
        body.hub.v_CN_NInit = column(orbit["velocity_m_s"] if orbit else [0.0, 0.0, 0.0])
        body.hub.sigma_BNInit = column(self.run["attitude_mrp"])
        body.hub.omega_BN_BInit = column(self.run["body_rate_rad_s"])
        return body

    def _orbit(self) -> list[Any]:
        if not self.craft["orbit"]:
            return []
        self.gravity = simIncludeGravBody.gravBodyFactory()
        earth = self.gravity.createEarth()
        earth.isCentralBody = True
        self.gravity.addBodiesTo(self.body)
        gradient = GravityGradientEffector.GravityGradientEffector()
        gradient.addPlanetName(earth.planetName)
        self.body.addDynamicEffector(gradient)
        return [gradient]

    def _external_torque(self) -> list[Any]:
        pushed = extForceTorque.ExtForceTorque()
        pushed.extTorquePntB_B = column(self.craft["torque_N_m"])
        self.body.addDynamicEffector(pushed)
        return [pushed]

    def _panels(self) -> list[Any]:
        panels = []
        for index, given in enumerate(self.craft["panels"]):
            panel = hingedRigidBodyStateEffector.HingedRigidBodyStateEffector()
            panel.mass, panel.d = given["mass_kg"], given["distance_m"]
            panel.k, panel.c = given["stiffness_N_m_rad"], given["damping_N_m_s_rad"]
            panel.IPntS_S, panel.dcm_HB = given["inertia_kg_m2"], given["dcm_HB"]
            panel.r_HB_B = column(given["hinge_m"])
            panel.nameOfThetaState, panel.nameOfThetaDotState = f"theta{index}", f"thetaDot{index}"
            self.body.addStateEffector(panel)
            panels.append(panel)
        return panels

    def _particles(self) -> list[Any]:
        particles = []
        for index, given in enumerate(self.craft["particles"]):
            particle = linearSpringMassDamper.LinearSpringMassDamper()
            particle.k, particle.c = given["stiffness_N_m"], given["damping_N_s_m"]
            particle.massInit = given["mass_kg"]
            particle.r_PB_B, particle.pHat_B = column(given["place_m"]), column(given["direction"])
            particle.nameOfRhoState, particle.nameOfRhoDotState = f"rho{index}", f"rhoDot{index}"
            particle.nameOfMassState = f"mass{index}"
            self.body.addStateEffector(particle)
            particles.append(particle)
        return particles

    def _wheels(self) -> tuple[Any, Any]:
        """Return the wheels as they are, and the factory of those that the software believes in."""
        factory, effector = simIncludeRW.rwFactory(), reactionWheelStateEffector.ReactionWheelStateEffector()
        believed = simIncludeRW.rwFactory()
        for is_so, drawn in zip(self.craft["wheels"], self.craft["drawn_wheels"], strict=True):
            model = messaging.JitterSimple if is_so["imbalance_kg_m"] else messaging.BalancedWheels
            for each, given, kind in ((factory, is_so, model), (believed, drawn, messaging.BalancedWheels)):
                wheel = each.create(
                    "custom",
                    given["axis"],
                    Js=given["spin_inertia_kg_m2"],
                    Omega=given["speed_rad_s"] / macros.RPM,
                    u_max=given["torque_limit_N_m"],
                    rWB_B=given["position_m"],
                    RWModel=kind,
                    useRWfriction=True,
                )
                wheel.fCoulomb, wheel.cViscous = given["coulomb_N_m"], given["viscous_N_m_s_rad"]
                wheel.U_s = given["imbalance_kg_m"]
        factory.addToSpacecraft("wheels", effector, self.body)
        self.actual = factory
        return effector, believed

    def _instruments(self) -> list[Any]:
        given, count = self.craft["gyro"], len(self.craft["wheels"])
        self.imu, self.encoders = imuSensor.ImuSensor(), encoder.Encoder()
        self.imu.RNGSeed = self.run["seeds"][0]
        self.imu.PMatrixGyro = (given["noise_rad_s"] * np.eye(3)).tolist()
        self.imu.AMatrixGyro = np.zeros((3, 3)).tolist()
        self.imu.senRotBias, self.imu.gyroScale = given["bias_rad_s"], given["scale"]
        self.imu.dcm_PB = given["dcm_PB"]
        self.imu.scStateInMsg.subscribeTo(self.body.scStateOutMsg)
        self.encoders.clicksPerRotation, self.encoders.numRW = self.craft["encoder_clicks"], count
        self.encoders.rwSpeedInMsg.subscribeTo(self.wheels.rwSpeedOutMsg)
        return [self.imu, self.encoders]

    def _software(self) -> list[Any]:
        self.parameters, belief = self.factory.getConfigMessage(), messaging.VehicleConfigMsgPayload()
        belief.ISCPntB_B = np.ravel(self.craft["drawn_inertia_kg_m2"]).tolist()
        self.vehicle = messaging.VehicleConfigMsg().write(belief)
        navigation = self._navigation()
        reference, error = waypointReference.WaypointReference(), attTrackingError.attTrackingError()
        reference.dataFileName, reference.useReferenceFrame = self.run["waypoints"], True
        feedback, share = mrpFeedback.mrpFeedback(), rwMotorTorque.rwMotorTorque()
        error.attNavInMsg.subscribeTo(navigation.attOutMsg)
        error.attRefInMsg.subscribeTo(reference.attRefOutMsg)
        feedback.guidInMsg.subscribeTo(error.attGuidOutMsg)
        feedback.vehConfigInMsg.subscribeTo(self.vehicle)
        feedback.rwParamsInMsg.subscribeTo(self.parameters)
        feedback.rwSpeedsInMsg.subscribeTo(self.encoders.rwSpeedOutMsg)
        feedback.K, feedback.P, feedback.Ki = *self.craft["gains"], -1.0
        share.controlAxes_B = np.eye(3).ravel().tolist()
        share.rwParamsInMsg.subscribeTo(self.parameters)
        share.vehControlInMsg.subscribeTo(feedback.cmdTorqueOutMsg)
        self.share, self.navigation = share, navigation
        return [navigation, reference, error, feedback, share, *self._motors(share)]

    def _navigation(self) -> Any:
        navigation, given = simpleNav.SimpleNav(), self.craft["navigation"]
        steps, bounds = np.zeros(NAVIGATED), np.zeros(NAVIGATED)
        for place, name in ((SIGMA, "attitude_mrp"), (OMEGA, "body_rate_rad_s")):
            steps[place], bounds[place] = given[name] / 5.0, given[name]
        navigation.PMatrix, navigation.walkBounds = np.diag(steps).tolist(), column(bounds)
        navigation.RNGSeed = self.run["seeds"][1]
        navigation.scStateInMsg.subscribeTo(self.body.scStateOutMsg)
        return navigation

    def _motors(self, share: Any) -> list[Any]:
        limits = np.array([wheel["torque_limit_N_m"] for wheel in self.craft["wheels"]])
        voltage, motor = rwMotorVoltage.rwMotorVoltage(), motorVoltageInterface.MotorVoltageInterface()
        voltage.VMin, voltage.VMax = 0.0, VOLTS
        voltage.torqueInMsg.subscribeTo(share.rwMotorTorqueOutMsg)
        voltage.rwParamsInMsg.subscribeTo(self.parameters)
        motor.setGains((limits / VOLTS).tolist())
        motor.setScaleFactors([wheel["torque_factor"] for wheel in self.craft["wheels"]])
        motor.setBiases([0.0] * len(limits))
        motor.motorVoltageInMsg.subscribeTo(voltage.voltageOutMsg)
        self.wheels.rwMotorCmdInMsg.subscribeTo(motor.motorTorqueOutMsg)
        return [voltage, motor]

    def _schedule(self) -> Any:
        """Dynamics first; the wheels in it before the body, as they take their commands when they are called."""
        simulation = SimulationBaseClass.SimBaseClass()
        process, period = simulation.CreateNewProcess("process"), macros.sec2nano(self.craft["control_period_s"])
        process.addTask(simulation.CreateNewTask("dynamics", self.run["step_ns"]), 30)
        process.addTask(simulation.CreateNewTask("gyro", period), 20)
        process.addTask(simulation.CreateNewTask("software", period), 10)
        process.addTask(simulation.CreateNewTask("truth", period // 2), 5)
        self.gyro, self.attitude = self.imu.sensorOutMsg.recorder(), self.navigation.attOutMsg.recorder()
        self.tachometers, self.commands = (
            self.encoders.rwSpeedOutMsg.recorder(),
            self.share.rwMotorTorqueOutMsg.recorder(),
        )
        self.motion, self.turning = self.body.scStateOutMsg.recorder(), self.wheels.rwSpeedOutMsg.recorder()
        order = [("dynamics", module) for module in (self.wheels, *self.around, *self.parts, self.body)]
        order += [("gyro", self.imu), ("software", self.wheels), ("software", self.encoders)]
        order += [("software", module) for module in self.software]
        order += [("software", each) for each in (self.gyro, self.tachometers, self.commands, self.attitude)]
        order += [("truth", self.wheels), ("truth", self.motion), ("truth", self.turning)]
        for task, module in order:
            simulation.AddModelToTask(task, module)
        return simulation


def main() -> None:
    for line in sys.stdin:
        asked, out = line.split()
        content = json.loads(Path(asked).read_text(encoding="utf-8"))
        flown = [Flight(content["craft"], run).fly() for run in content["runs"]]
        channels = {f"{index}_{name}": values for index, run in enumerate(flown) for name, values in run.items()}
        np.savez(out, **channels)
        print("done", flush=True)


if __name__ == "__main__":
    main()
