"""The gyro shows the mean of the body rate over its sample period, as integrating gyros do."""

from __future__ import annotations

from typing import final

from typing_extensions import override

from testbed.arrays import Array
from testbed.effects.contract import Effect, Extension, Parameter
from testbed.prediction.hooks import Hooks
from testbed.scenario.scenario import Scenario


class _Averaging(Hooks):
    @override
    def gyro_averaging(self, value: Array) -> Array:
        return value[:, 0]


@final
class GyroAveraging(Effect):
    """ω̄(t) = 1/(s P) ∫ ω over the share s of the sample period P before t."""

    id = "gyro_averaging"
    components = ("gyro",)
    parameters = (Parameter(name="share_of_period", unit="1", typical=1.0, lower=0.0, upper=1.0, plausible=(0.0, 1.0)),)
    sentence = "The gyro's samples are means over a share of its sample period, and late by half of it."
    look_alikes = ("gyro_latency", "gyro_bandwidth")
    confirm = "The same maneuver at another sample rate: what averages is late in proportion to the period."
    yields_to = ("gyro_latency", "gyro_bandwidth")
    flies = False  # the flown gyro samples

    @override
    def hooks(self, component: str) -> Hooks:
        return _Averaging()

    @override
    def extension(self, component: str, values: Array, scenario: Scenario) -> Extension:
        return Extension()
