"""The motor of one wheel gives another torque than it is commanded, and than its current shows."""

from __future__ import annotations

from typing import final

import numpy as np
from typing_extensions import override

from testbed.arrays import Array
from testbed.effects.contract import WHEELS, Effect, Extension, Parameter, only_wheel, wheel_index
from testbed.prediction.hooks import Hooks
from testbed.prediction.wheel_impulses import Impulses
from testbed.scenario.actuators import wheel_count
from testbed.scenario.scenario import Scenario
from testbed.scenario.values import per_unit


class _Scaled(Hooks):
    def __init__(self, component: str) -> None:
        self._component = component

    @override
    def wheel_impulse(self, impulse: Array, value: Array, of: Impulses) -> Array:
        return np.asarray(impulse + only_wheel(self._component, value, impulse.shape[-1])[:, None] * of.asked)


@final
class WheelTorqueScale(Effect):
    """u → (1 + e) u."""

    id = "wheel_torque_scale"
    components = WHEELS
    # A motor's torque constant is known to some hundredths; 0.5 either way is another winding.
    parameters = (
        Parameter(name="relative_error", unit="1", typical=0.01, lower=-0.5, upper=0.5, plausible=(-0.3, 0.3)),
    )
    needs = ("wheel_speed", "wheel_torque")
    measured_by = ("wheel_speed",)
    sentence = "The motor of {component} gives more or less torque than it is commanded, by a share."
    look_alikes = ("wheel_inertia",)
    confirm = "A step of that wheel's torque: the slope of its speed, with its spin inertia, is the torque."

    @override
    def hooks(self, component: str) -> Hooks:
        return _Scaled(component)

    @override
    def extension(self, component: str, values: Array, scenario: Scenario) -> Extension:
        wheels = wheel_count(scenario.actuators)
        factors = np.array(per_unit(scenario.truth.wheel_torque_factor, wheels, 1.0))
        factors[wheel_index(component)] *= 1.0 + values[0]
        return Extension(scenario={"truth": {"wheel_torque_factor": factors.tolist()}})
