"""One wheel's tachometer is off by a constant: telemetry has a momentum, fixed in the body, that the wheel has not."""

from __future__ import annotations

from typing import final

import numpy as np
from typing_extensions import override

from testbed.arrays import Array
from testbed.effects.contract import WHEELS, Effect, Extension, Parameter, only_wheel, wheel_index
from testbed.prediction.grid import Grid
from testbed.prediction.hooks import Hooks, column
from testbed.prediction.wheel_impulses import Impulses
from testbed.scenario.actuators import wheel_count
from testbed.scenario.scenario import Scenario
from testbed.scenario.values import per_unit


class _Biased(Hooks):
    def __init__(self, component: str) -> None:
        self._component, self._wheel = component, wheel_index(component)

    @override
    def cluster_momentum(self, momentum_B: Array, value: Array, grid: Grid) -> Array:
        held = grid.wheels.spin_inertia[self._wheel] * grid.wheels.axis_B[self._wheel]
        return np.asarray(momentum_B - column(value, 0)[:, None] * held)

    @override
    def wheel_impulse(self, impulse: Array, value: Array, of: Impulses) -> Array:
        unseen = only_wheel(self._component, value, impulse.shape[-1])[:, None] * of.viscous * of.interval[:, None]
        return np.asarray(impulse + unseen)


@final
class WheelSpeedBias(Effect):
    """Ω̄ = Ω + b: the wheel holds Jw (Ω̄ - b), and its bearing takes c b less than Ω̄ says."""

    id = "wheel_speed_bias"
    components = WHEELS
    # A Hall sensor that loses pulses is off by some turns a second; 1,000 rad/s is all that small wheels reach.
    parameters = (
        Parameter(name="bias_rad_s", unit="rad/s", typical=5.0, lower=-1e3, upper=1e3, plausible=(-100.0, 100.0)),
    )
    needs = ("wheel_speed",)
    sentence = "The tachometer of {component} is off by a constant speed."
    look_alikes = ("gyro_bias",)
    confirm = "A flight that starts with all wheels at rest."

    @override
    def hooks(self, component: str) -> Hooks:
        return _Biased(component)

    @override
    def extension(self, component: str, values: Array, scenario: Scenario) -> Extension:
        wheels = wheel_count(scenario.actuators)
        bias = np.array(per_unit(scenario.wheel_tachometer.bias_rad_s, wheels, 0.0))
        bias[wheel_index(component)] += values[0]
        return Extension(scenario={"wheel_tachometer": {"bias_rad_s": bias.tolist()}})
