"""Fly a rigid body around the Earth in Basilisk, under its own gravity gradient, and freeze the trajectory.

The orbit is integrated by Basilisk too: only its radius and the gravitational parameter are given to either side. It
needs an environment of its own: see README.md here.
"""

from __future__ import annotations

import tomllib

import numpy as np
from Basilisk.simulation import GravityGradientEffector, spacecraft
from Basilisk.utilities import SimulationBaseClass, simIncludeGravBody
from make_platforms import HERE, column, mrp, text

STEP_NS, CHECK_STEP_NS = 250_000_000, 500_000_000


def main() -> None:
    """Write orbit.csv into the folder platforms, and print how well it has converged."""
    trajectory, check = fly(STEP_NS), fly(CHECK_STEP_NS)
    error = np.abs(trajectory - check)[:, 1:4].max()
    columns = ["time_s", *(f"body_rate_{axis}_rad_s" for axis in "xyz")]
    made = text("make_orbit.py", (STEP_NS, CHECK_STEP_NS), columns, trajectory, error)
    (HERE / "platforms" / "orbit.csv").write_text(made, encoding="utf-8")
    print(f"orbit: body rate up to {np.abs(trajectory[:, 1:4]).max():.4f} rad/s, step error {error:.1e} rad/s")


def fly(step_ns: int) -> np.ndarray:
    """Return the trajectory: time and body rate, one row a sample."""
    cases = tomllib.loads((HERE / "platforms.toml").read_text(encoding="utf-8"))
    orbit = cases["orbit"]
    mu, radius = orbit["gravitational_parameter_m3_s2"], orbit["radius_m"]
    simulation = SimulationBaseClass.SimBaseClass()
    simulation.CreateNewProcess("process").addTask(simulation.CreateNewTask("task", step_ns))
    body = spacecraft.Spacecraft()
    body.hub.mHub, body.hub.IHubPntBc_B = cases["mass_kg"], cases["inertia_kg_m2"]
    body.hub.r_BcB_B = column([0.0, 0.0, 0.0])
    body.hub.r_CN_NInit = column([radius, 0.0, 0.0])
    body.hub.v_CN_NInit = column([0.0, np.sqrt(mu / radius), 0.0])
    body.hub.sigma_BNInit = column(mrp(cases["attitude_rad"]))
    body.hub.omega_BN_BInit = column(orbit["body_rate_rad_s"])
    bodies = simIncludeGravBody.gravBodyFactory()
    earth = bodies.createCustomGravObject("earth", mu)
    earth.isCentralBody = True
    bodies.addBodiesTo(body)
    gradient = GravityGradientEffector.GravityGradientEffector()
    gradient.addPlanetName(earth.planetName)
    body.addDynamicEffector(gradient)
    simulation.AddModelToTask("task", body)
    simulation.AddModelToTask("task", gradient)
    simulation.InitializeSimulation()
    rows, sample = [], round(1e9 * orbit["sample_s"])
    for nanoseconds in range(0, round(1e9 * orbit["duration_s"]) + 1, sample):
        simulation.ConfigureStopTime(nanoseconds)
        simulation.ExecuteSimulation()
        rate = np.ravel(body.dynManager.getStateObject("hubOmega").getState())
        rows.append(np.concatenate([[nanoseconds / 1e9], rate]))
    return np.array(rows)


if __name__ == "__main__":
    main()
