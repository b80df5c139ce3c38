"""The gyro's samples show the body rate of a moment ago."""

from __future__ import annotations

from typing import final

from typing_extensions import override

from testbed.arrays import Array
from testbed.effects.contract import Effect, Extension, Parameter
from testbed.prediction.hooks import Hooks
from testbed.scenario.scenario import Scenario


class _Delayed(Hooks):
    @override
    def gyro_delay(self, value: Array) -> Array:
        return value[:, 0]


@final
class GyroLatency(Effect):
    """ω̄(t) = ω(t - τ)."""

    id = "gyro_latency"
    components = ("gyro",)
    parameters = (Parameter(name="delay_s", unit="s", typical=0.01, lower=0.0, upper=0.5, plausible=(0.0, 0.1)),)
    sentence = "The gyro's samples are late: they show the body rate of a moment ago."
    look_alikes = ("gyro_bandwidth", "actuator_delay", "telemetry_skew", "gyro_averaging")
    confirm = "A maneuver with faster reversals: a delay shifts all frequencies alike, a low-pass damps the fast ones."

    @override
    def hooks(self, component: str) -> Hooks:
        return _Delayed()

    @override
    def extension(self, component: str, values: Array, scenario: Scenario) -> Extension:
        return Extension(scenario={"gyro": {"latency_s": float(values[0])}})
