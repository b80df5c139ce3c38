"""The centre of mass of one wheel lies beside its axis: a force turns with it, and the platform trembles."""

from __future__ import annotations

from math import ceil
from typing import final

import numpy as np
import scipy
from typing_extensions import override

from testbed.arrays import Array, Matrix3
from testbed.cmg.wheels import wheel_turning_directions
from testbed.effects.contract import WHEELS, Extension, Parameter, wheel_index
from testbed.effects.lines import LineEffect, tremor
from testbed.effects.noise_effect import Readings
from testbed.estimation.telemetry import Telemetry
from testbed.scenario.actuators import reaction_wheels
from testbed.scenario.scenario import Scenario
from testbed.scenario.timing import STEP_TURN
from testbed.scenario.values import per_unit


@final
class WheelImbalance(LineEffect):
    """J ω = ... - U Ω r × (f cos φ + (a × f) sin φ), φ = ∫ Ω dt + φ₀, f normal to a, with a φ₀ of every run's own.

    The total angular momentum does not change by it, so that what the unbalanced rotor takes the body gives.
    """

    id = "wheel_imbalance"
    components = WHEELS
    # Data sheets of small satellites' wheels state 1e-8 to 5e-7 kg·m.
    parameters = (Parameter(name="static_kg_m", unit="kg·m", typical=2e-7, lower=0.0),)
    needs = ("wheel_speed",)
    sentence = (
        "The rotor of {component} is out of balance: the gyro shows a line at its speed, or at the alias of that."
    )
    look_alikes = ("gyro_noise",)
    confirm = "Run that wheel at another speed: the line moves with it."

    @override
    def line(self, component: str, readings: Readings, part: int) -> Array | None:
        return _columns(readings.runs[part], wheel_index(component), readings.inertia)

    @override
    def extension(self, component: str, values: Array, scenario: Scenario) -> Extension:
        arrays = reaction_wheels(scenario.actuators)
        imbalance = np.array(per_unit(scenario.truth.wheel_imbalance_kg_m, sum(each.wheels for each in arrays), 0.0))
        imbalance[wheel_index(component)] += values[0]
        longest = STEP_TURN * min(each.spin_inertia_kg_m2 / each.momentum_limit_N_m_s for each in arrays)
        period, step = 1.0 / scenario.simulation.control_rate_hz, scenario.simulation.step_s
        return Extension(
            scenario={
                "truth": {"wheel_imbalance_kg_m": imbalance.tolist()},
                "simulation": {"step_s": step if step <= longest else period / ceil(period / longest)},
            }
        )


def _columns(run: Telemetry, wheel: int, inertia: Matrix3) -> Array | None:
    """Return the body rates at the gyro's samples for an imbalance of one kg·m at φ₀ of 0 and 90 degrees, (N, 3, 2)."""
    if run.wheels is None or run.wheels.wheels.position_B is None:
        return None
    speed, angle = _turned(run, run.wheels.momentum[:, wheel] / run.wheels.wheels.spin_inertia[wheel])
    axis_B, position_B = run.wheels.wheels.axis_B[wheel], run.wheels.wheels.position_B[wheel]
    across_B = wheel_turning_directions(axis_B[None])[1, 0]
    return tremor(position_B, across_B, np.cross(axis_B, across_B), speed[:, None], angle, inertia)


def _turned(run: Telemetry, speed: Array) -> tuple[Array, Array]:
    """Return speed, rad/s, and angle, rad, of a wheel at the gyro's samples, each of shape (N,).

    A motor holds its torque from one sample to the next: the speed changes along a line.

    Args:
        run: its times.
        speed: at the actuators' samples, shape (K,), rad/s.
    """
    time = run.actuator_time
    before = np.clip(np.searchsorted(time, run.gyro_time, side="right") - 1, 0, len(time) - 2)
    angle, since = scipy.integrate.cumulative_trapezoid(speed, time, initial=0.0)[before], run.gyro_time - time[before]
    slope = np.diff(speed)[before] / np.diff(time)[before]
    return speed[before] + slope * since, angle + speed[before] * since + 0.5 * slope * since**2
