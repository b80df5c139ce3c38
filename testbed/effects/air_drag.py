"""Air and the film of an air bearing drag more than is believed: one coefficient, the same about every axis."""

from __future__ import annotations

from typing import final

import numpy as np
from typing_extensions import override

from testbed.arrays import Array
from testbed.effects.contract import Effect, Extension, Parameter
from testbed.prediction.hooks import Hooks, Instant, column
from testbed.scenario.environment import AirBearing
from testbed.scenario.scenario import Scenario


class _Drag(Hooks):
    @override
    def torque(self, value: Array, at: Instant) -> Array:
        return np.asarray(-column(value, 0) * at.body_rate)


@final
class AirDrag(Effect):
    """T = -c ω with one c, where `viscous_drag` has one for each axis: a ball's film is alike about all of them."""

    id = "air_drag"
    components = ("platform",)
    # Negative where less drags than is believed; with 1 N·m·s/rad a table would stop within a second.
    parameters = (Parameter(name="coefficient_N_m_s_rad", unit="N·m·s/rad", typical=1e-3, lower=-1.0, upper=1.0),)
    sentence = "Air and the bearing's film drag {component} more than is believed, alike about every axis."
    look_alikes = ("viscous_drag", "quadratic_drag")
    confirm = "The same maneuver at half and at twice the rate: only a linear drag stays in proportion."
    environment = "air_bearing"

    @override
    def hooks(self, component: str) -> Hooks:
        return _Drag()

    @override
    def extension(self, component: str, values: Array, scenario: Scenario) -> Extension:
        drag = scenario.truth.drag_N_m_s_rad
        if drag is None:
            assert isinstance(scenario.environment, AirBearing)
            drag = scenario.environment.drag_N_m_s_rad
        return Extension(scenario={"truth": {"drag_N_m_s_rad": drag + float(values[0])}})
