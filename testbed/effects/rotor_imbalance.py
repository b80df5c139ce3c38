"""The centre of mass of one rotor lies beside its axis: a force turns with it, and the platform trembles."""

from __future__ import annotations

from typing import final

import numpy as np
from typing_extensions import override

from testbed.arrays import Array, Matrix3
from testbed.effects.contract import UNITS, Extension, Parameter, unit_index
from testbed.effects.lines import LineEffect, tremor
from testbed.effects.noise_effect import Readings
from testbed.estimation.telemetry import Telemetry, has_gimbals
from testbed.plant.unit_additions import UnbalancedRotor
from testbed.scenario.scenario import Scenario


@final
class RotorImbalance(LineEffect):
    """J ω = ... - U Ω r × (g cos φ - t sin φ), φ = Ω t + φ₀, with a φ₀ of every run's own.

    Gyros sample far too slowly to follow the rotor: what shows is a line at its speed or at the alias, on the axes that
    the unit's place r and its axes g and t give. The platform's total angular momentum hardly changes within a turn, so
    that the rate is the momentum's, over the inertia.
    """

    id = "rotor_imbalance"
    components = UNITS
    parameters = (Parameter(name="static_kg_m", unit="kg·m", typical=2e-6, lower=0.0),)
    needs = ("gimbal_angle",)
    sentence = (
        "The rotor of {component} is out of balance: the gyro shows a line at its speed, or at the alias of that."
    )
    look_alikes = ("gyro_noise",)
    confirm = "Run that rotor at another speed: the line moves with it."

    @override
    def line(self, component: str, readings: Readings, part: int) -> Array | None:
        return _columns(readings.runs[part], unit_index(component), readings.inertia)

    @override
    def extension(self, component: str, values: Array, scenario: Scenario) -> Extension:
        return Extension(platform=(UnbalancedRotor(unit=unit_index(component), static=float(values[0])),))


def _columns(run: Telemetry, unit: int, inertia: Matrix3) -> Array | None:
    """Return the body rates at the gyro's samples for an imbalance of one kg·m at φ₀ of 0 and 90 degrees, (N, 3, 2)."""
    if not has_gimbals(run) or run.gimbals.cluster.position_B is None:
        return None
    cluster, spin = run.gimbals.cluster, run.gimbals.rotor_momentum
    momentum = cluster.rotor_momentum if spin is None else spin.mean(axis=0)
    speed = momentum[unit] / cluster.rotor_spin_inertia[unit]
    angle = run.through(np.unwrap(run.gimbals.angle, axis=0)[:, unit])(run.gyro_time)[:, None]
    transverse_B = np.cos(angle) * cluster.transverse_axis_B[unit] - np.sin(angle) * cluster.spin_axis_B[unit]
    position_B, across_B = run.gimbals.cluster.position_B[unit], cluster.gimbal_axis_B[unit]
    return tremor(position_B, across_B, -transverse_B, speed, speed * run.gyro_time, inertia)
