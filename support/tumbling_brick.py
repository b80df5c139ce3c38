"""NASA's check cases of a tumbling brick, and the same flown by our integrators.

Source: NASA/TM-2015-218675, "Check-Cases for Verification of 6-Degree-of-Freedom Flight Vehicle Simulations",
atmospheric cases 02 and 03; numbers of the brick from brick_inertia.dml and brick_aero.dml of the public repository
nasa/simupy-flight.
"""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
from scipy.interpolate import CubicSpline

from testbed.arrays import Array, Series
from testbed.dynamics.inertia import theta_of
from testbed.estimation.motion import drive_of, simulate
from testbed.estimation.telemetry import Telemetry
from testbed.plant.added_torques import RateTorque
from testbed.plant.additions import add
from testbed.plant.build import shipped_model, specification
from testbed.plant.layout import layout_of
from testbed.plant.properties import PlatformProperties

FOLDER = Path(__file__).resolve().parents[1] / "tests" / "agreement" / "nasa"
SLUG, FOOT = 14.593902937, 0.3048
INERTIA = np.diag([0.00189422, 0.006211019, 0.007194665]) * SLUG * FOOT**2
MASS = 0.155404754 * SLUG
SPAN, CHORD = 4.0 / 12.0 * FOOT, 8.0 / 12.0 * FOOT
AREA = SPAN * CHORD
"""Of a face of 4 by 8 inches; the file rounds them to five digits."""
START = np.radians([10.0, 20.0, 30.0])


def published(case: str) -> Array:
    """Return a case's table, `case02` or `case03`, by column name; rates in deg/s as published."""
    lines = (FOLDER / f"{case}.csv").read_text(encoding="utf-8").splitlines()
    return np.genfromtxt([line for line in lines if not line.startswith("#")], delimiter=",", names=True)


def rates(table: Array) -> Array:
    """Return a table's body rates, shape (N, 3), rad/s."""
    return np.radians(np.stack([table[f"body_rate_{axis}_deg_s"] for axis in "xyz"], axis=1))


def tumbled(time: Series, step: float, damping: Array | None = None) -> Array:
    """Return the body rate in MuJoCo, shape (N, 3), rad/s, at multiples of a step.

    Args:
        time: shape (N,), s, from 0 on.
        step: s.
        damping: torque over rate about each axis, shape (2P+1, 3), N·m·s/rad, at every half step; none where None.
    """
    spec = specification(PlatformProperties(inertia=INERTIA, mass=MASS, units=0, step=step), shipped_model())
    add(spec, [RateTorque(coefficient=np.ones(3))])
    model = spec.compile()
    layout, data = layout_of(model), mujoco.MjData(model)
    torques = [model.actuator(f"added1_{axis}").id for axis in "xyz"]
    data.qvel[layout.body_rate] = START
    rows, wanted = [], set(np.rint(time / step).astype(int).tolist())
    for number in range(max(wanted) + 1):
        if number in wanted:
            rows.append(data.qvel[layout.body_rate].copy())
        model.actuator_biasprm[torques, 2] = 0.0 if damping is None else -damping[2 * number + 1]
        mujoco.mj_step(model, data)
    return np.array(rows)


def damping_of(table: Array, time: Series) -> Array:
    """Return the brick's aerodynamic damping from published density ρ and dynamic pressure, shape (N, 3), N·m·s/rad.

    M = -½ ρ V² S l (l ω / 2 V) about each axis, l the span in roll and yaw and the chord in pitch.
    """
    density = table["air_density_slug_ft3"] * SLUG / FOOT**3
    pressure = table["dynamic_pressure_lbf_ft2"] * SLUG / FOOT  # a pound-force is a slug foot per square second
    mass_flow = CubicSpline(table["time_s"], np.sqrt(2.0 * density * pressure))(time)
    return np.asarray(mass_flow[:, None] * AREA * np.array([SPAN, CHORD, SPAN]) ** 2 / 4.0)


def predicted(time: Series) -> Array:
    """Return the undamped body rate by the law that estimators integrate, dynamics.gyrostat, shape (N, 3), rad/s."""
    telemetry = Telemetry(
        gyro_time=time,
        body_rate=np.zeros((len(time), 3)),
        gyro_noise=1.0,
        actuator_time=time,
        gimbals=None,
        applied_torque=np.zeros((len(time), 3)),
    )
    return simulate(drive_of(telemetry), theta_of(INERTIA), INERTIA @ START).body_rate
