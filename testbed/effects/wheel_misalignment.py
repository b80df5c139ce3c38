"""One wheel does not stand as drawn: its axis is turned, and its momentum with it."""

from __future__ import annotations

from typing import final

import numpy as np
from typing_extensions import override

from testbed.arrays import Array
from testbed.cmg.wheels import turned_wheel_axes
from testbed.effects.contract import WHEELS, Effect, Extension, Parameter, wheel_index
from testbed.prediction.grid import Grid
from testbed.prediction.hooks import Hooks
from testbed.scenario.actuators import wheel_count
from testbed.scenario.scenario import Scenario
from testbed.scenario.values import per_unit


class _Turned(Hooks):
    def __init__(self, component: str) -> None:
        self._wheel = wheel_index(component)

    @override
    def cluster_momentum(self, momentum_B: Array, value: Array, grid: Grid) -> Array:
        drawn_B = grid.wheels.axis_B[self._wheel : self._wheel + 1]
        moved_B = turned_wheel_axes(drawn_B, value[:, None, :]) - drawn_B
        return momentum_B + grid.wheel_momentum[..., self._wheel, None] * moved_B


@final
class WheelMisalignment(Effect):
    """a → a turned about two axes normal to it, as in `cmg.wheels.turned_wheel_axes`."""

    id = "wheel_misalignment"
    components = WHEELS
    # Brackets of small satellites are drilled to some tenths of a degree; 0.3 rad is another place.
    parameters = (
        Parameter(name="about_first_rad", unit="rad", typical=0.01, lower=-0.3, upper=0.3, plausible=(-0.2, 0.2)),
        Parameter(name="about_second_rad", unit="rad", typical=0.01, lower=-0.3, upper=0.3, plausible=(-0.2, 0.2)),
    )
    needs = ("wheel_speed",)
    sentence = "The axis of {component} does not point where its drawing says."
    look_alikes = ("gyro_misalignment",)
    confirm = "Null motion of the wheels, or a flight in which that wheel alone changes its speed."

    @override
    def hooks(self, component: str) -> Hooks:
        return _Turned(component)

    @override
    def extension(self, component: str, values: Array, scenario: Scenario) -> Extension:
        wheels = wheel_count(scenario.actuators)
        turns = np.array(per_unit(scenario.truth.wheel_axis_misalignment_rad, wheels, (0.0, 0.0)))
        turns[wheel_index(component)] += values
        return Extension(scenario={"truth": {"wheel_axis_misalignment_rad": turns.tolist()}})
