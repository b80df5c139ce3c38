"""The gyro reads something where the platform does not turn."""

from __future__ import annotations

from typing import final

import numpy as np
from typing_extensions import override

from testbed.arrays import Array, Series
from testbed.effects.contract import AXES, Effect, Extension, Parameter
from testbed.prediction.hooks import Hooks
from testbed.scenario.scenario import Scenario


class _Biased(Hooks):
    @override
    def gyro_reading(self, reading: Array, value: Array, time: Series, run: int) -> Array:
        return reading + value[:, None]


@final
class GyroBias(Effect):
    """ω̄ = ω + b."""

    id = "gyro_bias"
    components = ("gyro",)
    parameters = tuple(
        Parameter(name=f"bias_{axis}_rad_s", unit="rad/s", typical=2e-3, plausible=(-0.2, 0.2)) for axis in AXES
    )
    sentence = "The gyro reads a constant rate where there is none."
    look_alikes = ("gyro_drift", "gyro_misalignment")
    confirm = "A record of the platform held still, before the release: a bias is all that it shows."

    @override
    def hooks(self, component: str) -> Hooks:
        return _Biased()

    @override
    def extension(self, component: str, values: Array, scenario: Scenario) -> Extension:
        return Extension(scenario={"gyro": {"bias_rad_s": (np.array(scenario.gyro.bias_rad_s) + values).tolist()}})
