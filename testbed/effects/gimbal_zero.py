"""One gimbal encoder reads an angle where its gimbal stands at zero."""

from __future__ import annotations

from dataclasses import replace
from typing import final

import numpy as np
from typing_extensions import override

from testbed.arrays import Array
from testbed.effects.contract import UNITS, Effect, Extension, Parameter, only_unit
from testbed.prediction.grid import Gimbals, Grid
from testbed.prediction.hooks import Hooks
from testbed.scenario.scenario import Scenario
from testbed.scenario.values import per_unit


class _Shifted(Hooks):
    def __init__(self, component: str) -> None:
        self._component = component

    @override
    def gimbals(self, gimbals: Gimbals, value: Array, grid: Grid) -> Gimbals:
        zero = only_unit(self._component, value[:, 0], gimbals.angle.shape[-1])
        return replace(gimbals, angle=gimbals.angle - zero[:, None])


@final
class GimbalZero(Effect):
    """d̄_i = d_i + z."""

    id = "gimbal_zero"
    components = UNITS
    parameters = (Parameter(name="zero_rad", unit="rad", typical=0.01, lower=-0.5, upper=0.5, plausible=(-0.3, 0.3)),)
    needs = ("gimbal_angle",)
    sentence = "The gimbal encoder of {component} has its zero in the wrong place."
    look_alikes = ("gimbal_misalignment", "rotor_speed")
    confirm = "Turn that gimbal alone through a large angle: the error follows sine and cosine of its angle."

    @override
    def hooks(self, component: str) -> Hooks:
        return _Shifted(component)

    @override
    def extension(self, component: str, values: Array, scenario: Scenario) -> Extension:
        units = scenario.gyros.units
        zero = np.array(per_unit(scenario.encoder.zero_rad, units, 0.0)) + only_unit(component, values[:1], units)[0]
        return Extension(scenario={"encoder": {"zero_rad": zero.tolist()}})
