"""The gyro's bias grows during the flight."""

from __future__ import annotations

from typing import final

import numpy as np
from typing_extensions import override

from testbed.arrays import Array, Series
from testbed.effects.contract import AXES, Effect, Extension, Parameter
from testbed.prediction.hooks import Hooks
from testbed.scenario.scenario import Scenario


class _Drifting(Hooks):
    @override
    def gyro_reading(self, reading: Array, value: Array, time: Series, run: int) -> Array:
        return np.asarray(reading + value[:, None] * (time - time[0])[:, None])


@final
class GyroDrift(Effect):
    """ω̄ = ω + ḃ (t - t0), t0 the first sample of each run."""

    id = "gyro_drift"
    components = ("gyro",)
    parameters = tuple(
        Parameter(name=f"drift_{axis}_rad_s2", unit="rad/s²", typical=1e-3, plausible=(-0.05, 0.05)) for axis in AXES
    )
    sentence = "The gyro's bias grows as time goes on, as when it warms up."
    look_alikes = ("gyro_bias", "body_torque")
    confirm = "A longer record of the platform held still: a drift shows there, a torque does not."

    @override
    def hooks(self, component: str) -> Hooks:
        return _Drifting()

    @override
    def extension(self, component: str, values: Array, scenario: Scenario) -> Extension:
        return Extension(scenario={"gyro": {"drift_rad_s2": (np.array(scenario.gyro.drift_rad_s2) + values).tolist()}})
