"""One axis of the gyro reads too much or too little of what it feels."""

from __future__ import annotations

from typing import final

import numpy as np
from typing_extensions import override

from testbed.arrays import Array, Series
from testbed.effects.contract import AXES, Effect, Extension, Parameter
from testbed.prediction.hooks import Hooks
from testbed.scenario.scenario import Scenario


class _Scaled(Hooks):
    def __init__(self, component: str) -> None:
        self._on_axis = np.arange(3) == AXES.index(component)

    @override
    def gyro_reading(self, reading: Array, value: Array, time: Series, run: int) -> Array:
        return np.asarray(reading * (1.0 + value[:, None] * self._on_axis))


@final
class GyroScale(Effect):
    """ω̄_k = (1 + s) ω_k on one axis k."""

    id = "gyro_scale"
    components = AXES
    parameters = (
        Parameter(name="scale_factor_error", unit="1", typical=0.01, lower=-0.5, upper=0.5, plausible=(-0.2, 0.2)),
    )
    sentence = "{component} reads too much or too little of the rate."
    look_alikes = ("inertia", "gyro_misalignment")
    confirm = "A release with a spin: at zero total momentum a scale is the same as a different inertia."

    @override
    def hooks(self, component: str) -> Hooks:
        return _Scaled(component)

    @override
    def extension(self, component: str, values: Array, scenario: Scenario) -> Extension:
        scale = np.array(scenario.gyro.scale_factor_error)
        scale[AXES.index(component)] += values[0] * (1.0 + scale[AXES.index(component)])
        return Extension(scenario={"gyro": {"scale_factor_error": scale.tolist()}})
