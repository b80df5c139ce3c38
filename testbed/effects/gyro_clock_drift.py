"""The gyro's clock runs faster or slower than the actuators'."""

from __future__ import annotations

from typing import final

from typing_extensions import override

from testbed.arrays import Array
from testbed.effects.contract import Effect, Extension, Parameter
from testbed.prediction.hooks import Hooks
from testbed.scenario.scenario import Scenario


class _Drifting(Hooks):
    @override
    def gyro_clock_drift(self, value: Array) -> Array:
        return value[:, 0]


@final
class GyroClockDrift(Effect):
    """ω̄(t) = ω(t - d t), t the time of the records: at its zero the clocks agree.

    Crystals differ by 1e-5 to 1e-4, clocks that count by the RC oscillator of a microcontroller by 1e-2.
    """

    id = "gyro_clock_drift"
    components = ("gyro",)
    parameters = (Parameter(name="drift", unit="1", typical=2e-4, lower=-0.05, upper=0.05, plausible=(-0.02, 0.02)),)
    sentence = "The gyro's clock runs faster than the actuators', or slower where negative, by a share of the time."
    look_alikes = ("gyro_latency", "telemetry_skew")
    confirm = "A longer flight with the same motion at both ends: the lateness of the gyro's samples grows with time."
    yields_to = ("gyro_latency", "telemetry_skew")
    flies = False  # a flight has one clock

    @override
    def hooks(self, component: str) -> Hooks:
        return _Drifting()

    @override
    def extension(self, component: str, values: Array, scenario: Scenario) -> Extension:
        return Extension()
