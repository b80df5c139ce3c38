"""Fly the platform in Basilisk, with free gimbals and free rotors, and freeze the trajectory beside this file.

Basilisk's `vscmgStateEffector` derives its own equations of motion, in another formalism (back-substitution on the
hub) than a multibody engine's. It needs an environment of its own: see README.md here.
"""

from __future__ import annotations

import io
from importlib.metadata import version
from pathlib import Path

import numpy as np
from Basilisk.architecture import messaging
from Basilisk.simulation import spacecraft, vscmgStateEffector
from Basilisk.utilities import SimulationBaseClass, macros

DURATION_NS = 5_000_000_000
SAMPLE_PERIOD_NS = 40_000_000  # whole nanoseconds: a float time rounds to the step before
STEP = 1.0e-3  # s
CHECK_STEP = 2.5e-4  # s

# The nominal platform (models/platform.xml), written down once more: the two must not share a derivation.
MASS = 4.0  # kg, all of it
INERTIA = np.diag([0.022, 0.022, 0.027])  # kg m2, rotors locked, gimbal angles zero. Source: paper eq. (30)
SKEW = np.deg2rad(63.9)
MOUNTING_RADIUS = 0.06  # m
GIMBAL_MASS, ROTOR_MASS = 0.020, 0.040  # kg
GIMBAL_INERTIA = 3.0e-6  # kg m2, each axis, rotor not included
ROTOR_SPIN_INERTIA, ROTOR_TRANSVERSE_INERTIA = 1.0e-5, 5.3e-6  # kg m2

# The initial state: nothing zero and nothing symmetric, so that no term of the dynamics hides. Free gimbals swing like
# compass needles about the total momentum: five times this body rate takes them to 12 rad/s and into chaos, where two
# exact codes part after a few seconds; here they stay near their limit of 2 rad/s.
BODY_RATE = [0.02, -0.04, 0.03]  # rad/s
GIMBAL_ANGLE = [0.3, -0.5, 0.8, -0.2, 0.6, -0.9]  # rad
GIMBAL_RATE = [0.80, -0.55, 0.35, -0.70, 0.20, -0.45]  # rad/s
ROTOR_SPEED = 471.4  # rad/s, relative to the gimbal

AZIMUTH = np.deg2rad(60.0) * np.arange(6)
GIMBAL_AXIS = np.stack(
    [np.sin(SKEW) * np.cos(AZIMUTH), np.sin(SKEW) * np.sin(AZIMUTH), np.full(6, np.cos(SKEW))], axis=1
)
SPIN_AXIS = np.stack([-np.sin(AZIMUTH), np.cos(AZIMUTH), np.zeros(6)], axis=1)
TRANSVERSE_AXIS = np.cross(GIMBAL_AXIS, SPIN_AXIS)
POSITION = MOUNTING_RADIUS * np.stack([np.cos(AZIMUTH), np.sin(AZIMUTH), np.zeros(6)], axis=1)


def hub_inertia() -> np.ndarray:
    """Return what the six units leave of the platform's inertia, shape (3, 3), kg m2, body axes."""
    hub = INERTIA.copy()
    for s, t, g, r in zip(SPIN_AXIS, TRANSVERSE_AXIS, GIMBAL_AXIS, POSITION, strict=True):
        spin = (GIMBAL_INERTIA + ROTOR_SPIN_INERTIA) * np.outer(s, s)
        across = (GIMBAL_INERTIA + ROTOR_TRANSVERSE_INERTIA) * (np.outer(t, t) + np.outer(g, g))
        offset = (GIMBAL_MASS + ROTOR_MASS) * (r @ r * np.eye(3) - np.outer(r, r))
        hub -= spin + across + offset
    return hub


def column(vector: np.ndarray | list[float]) -> list[list[float]]:
    """Return a vector in the form that Basilisk takes."""
    return [[float(value)] for value in vector]


def unit(index: int) -> messaging.VSCMGConfigMsgPayload:
    """Return unit `index`: balanced, without friction or limits."""
    config = messaging.VSCMGConfigMsgPayload()
    config.VSCMGModel = vscmgStateEffector.vscmgBalancedWheels
    config.rGB_B = column(POSITION[index])
    config.gsHat0_B, config.gtHat0_B = column(SPIN_AXIS[index]), column(TRANSVERSE_AXIS[index])
    config.ggHat_B = column(GIMBAL_AXIS[index])
    config.massG, config.massW = GIMBAL_MASS, ROTOR_MASS
    config.IG1 = config.IG2 = config.IG3 = GIMBAL_INERTIA
    config.IW1 = ROTOR_SPIN_INERTIA
    config.IW2 = config.IW3 = ROTOR_TRANSVERSE_INERTIA
    config.gamma, config.gammaDot, config.Omega = GIMBAL_ANGLE[index], GIMBAL_RATE[index], ROTOR_SPEED
    config.u_s_max = config.u_s_min = config.u_g_max = config.u_g_min = -1.0
    config.wheelLinearFrictionRatio = config.gimbalLinearFrictionRatio = -1.0
    config.Omega_max, config.gammaDot_max = 1.0e4, -1.0
    config.rGcG_G = column([0.0, 0.0, 0.0])
    return config


def hub() -> spacecraft.Spacecraft:
    """Return the spacecraft without its units, its centre of mass at the origin and at rest."""
    body = spacecraft.Spacecraft()
    body.hub.mHub = MASS - 6 * (GIMBAL_MASS + ROTOR_MASS)
    body.hub.r_BcB_B = column([0.0, 0.0, 0.0])
    body.hub.IHubPntBc_B = hub_inertia().tolist()
    body.hub.r_CN_NInit = body.hub.v_CN_NInit = body.hub.sigma_BNInit = column([0.0, 0.0, 0.0])
    body.hub.omega_BN_BInit = column(BODY_RATE)
    return body


def fly(step: float) -> np.ndarray:
    """Return the trajectory, one row per sample: time, body rate, gimbal angles, gimbal rates, rotor speeds.

    The states are read from the integrator itself: the effector's output message lags by one step.
    """
    simulation = SimulationBaseClass.SimBaseClass()
    simulation.CreateNewProcess("process").addTask(simulation.CreateNewTask("task", macros.sec2nano(step)))
    body, units = hub(), vscmgStateEffector.VSCMGStateEffector()
    for index in range(6):
        units.AddVSCMG(unit(index))
    body.addStateEffector(units)
    torques = messaging.VSCMGArrayTorqueMsg().write(messaging.VSCMGArrayTorqueMsgPayload())
    units.cmdsInMsg.subscribeTo(torques)
    simulation.AddModelToTask("task", units)
    simulation.AddModelToTask("task", body)
    simulation.InitializeSimulation()
    names = ("hubOmega", units.nameOfVSCMGGammasState, units.nameOfVSCMGGammaDotsState, units.nameOfVSCMGOmegasState)
    states = [body.dynManager.getStateObject(name) for name in names]
    rows = []
    for nanoseconds in range(0, DURATION_NS + 1, SAMPLE_PERIOD_NS):
        simulation.ConfigureStopTime(nanoseconds)
        simulation.ExecuteSimulation()
        rows.append(np.concatenate([[nanoseconds / 1e9], *(np.ravel(state.getState()) for state in states)]))
    return np.array(rows)


def text(trajectory: np.ndarray, step_error: float) -> str:
    """Return the frozen file: what made it, the column names, the numbers."""
    columns = ["time_s", *(f"body_rate_{axis}_rad_s" for axis in "xyz")]
    for name, suffix in (("gimbal_angle", "rad"), ("gimbal_rate", "rad_s"), ("rotor_speed", "rad_s")):
        columns += [f"{name}_{number}_{suffix}" for number in range(1, 7)]
    buffer = io.StringIO()
    buffer.write(f"# Made by: python make_trajectory.py, with bsk {version('bsk')} and numpy {version('numpy')}\n")
    buffer.write(f"# RK4 at {STEP:g} s; body rate differs by {step_error:.1e} rad/s from that at {CHECK_STEP:g} s\n")
    buffer.write(",".join(columns) + "\n")
    np.savetxt(buffer, trajectory, fmt="%.14g", delimiter=",")
    return buffer.getvalue()


def main() -> None:
    """Write trajectory.csv beside this script and print how well it has converged."""
    trajectory, check = fly(STEP), fly(CHECK_STEP)
    step_error = np.abs(trajectory - check)[:, 1:4].max()
    Path(__file__).with_name("trajectory.csv").write_text(text(trajectory, step_error), encoding="utf-8")
    print(f"{len(trajectory)} samples; step error of the body rate {step_error:.1e} rad/s")


if __name__ == "__main__":
    main()
