"""The gyro follows fast motions late and damped: a first-order low-pass."""

from __future__ import annotations

from math import inf, pi
from typing import final

import numpy as np
from typing_extensions import override

from testbed.arrays import Array
from testbed.effects.contract import Effect, Extension, Parameter, Quantity
from testbed.prediction.hooks import Hooks
from testbed.scenario.scenario import Scenario

_SLOWEST = 0.08
"""s, 2 Hz: rate gyros for control pass 10 Hz and more (MEMS ones 10 to 400 Hz by their data sheets), a logger's filter
5 Hz. A slower one is a rate that something else slowed down, such as a wheel that follows its command."""


class _Slow(Hooks):
    @override
    def gyro_time_constant(self, value: Array) -> Array:
        return value[:, 0]


@final
class GyroBandwidth(Effect):
    """T dω̄/dt = ω - ω̄; searched as the time constant T, zero where it is absent, and reported as 1 / (2π T)."""

    id = "gyro_bandwidth"
    components = ("gyro",)
    parameters = (
        Parameter(name="time_constant_s", unit="s", typical=0.01, lower=0.0, upper=1.0, plausible=(0.0, _SLOWEST)),
    )
    sentence = "The gyro follows fast motions late and damped, as behind a low-pass."
    look_alikes = ("gyro_latency", "actuator_lag", "gyro_averaging")
    confirm = "A maneuver with faster reversals: a low-pass damps them, a delay shifts all frequencies alike."

    @override
    def hooks(self, component: str) -> Hooks:
        return _Slow()

    @override
    def quantities(self, values: Array, std: Array) -> tuple[Quantity, ...]:
        bandwidth = 1.0 / (2.0 * pi * values[0]) if values[0] > 0.0 else inf
        error = bandwidth * std[0] / values[0] if values[0] > 0.0 else inf
        return (Quantity(name="bandwidth_hz", unit="Hz", value=float(bandwidth), std=float(error)),)

    @override
    def extension(self, component: str, values: Array, scenario: Scenario) -> Extension:
        if values[0] <= 0.0:
            return Extension()
        before = scenario.gyro.bandwidth_hz or inf
        # Two low-passes one after the other, as one: to first order their time constants add.
        bandwidth = 1.0 / (2.0 * np.pi * values[0] + 1.0 / before)
        return Extension(scenario={"gyro": {"bandwidth_hz": float(bandwidth)}})
