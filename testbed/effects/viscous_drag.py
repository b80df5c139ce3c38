"""A torque against the body rate, in proportion to it, with a coefficient on each axis."""

from __future__ import annotations

from typing import final

import numpy as np
from typing_extensions import override

from testbed.arrays import Array
from testbed.effects.contract import Effect, Extension, Parameter
from testbed.plant.added_torques import RateTorque
from testbed.prediction.hooks import Hooks, Instant
from testbed.scenario.scenario import Scenario


class _Drag(Hooks):
    @override
    def torque(self, value: Array, at: Instant) -> Array:
        return np.asarray(-value * at.body_rate)


@final
class ViscousDrag(Effect):
    """T = -c ω on each body axis."""

    id = "viscous_drag"
    components = ("platform",)
    parameters = tuple(
        Parameter(name=f"coefficient_{axis}_N_m_s_rad", unit="N·m·s/rad", typical=2e-4, lower=0.0) for axis in "xyz"
    )
    sentence = "A drag torque opposes the body rate in proportion to it, as slow air or eddy currents do."
    look_alikes = ("quadratic_drag",)
    confirm = "The same maneuver at half and at twice the rate: only a linear drag stays in proportion."

    @override
    def hooks(self, component: str) -> Hooks:
        return _Drag()

    @override
    def extension(self, component: str, values: Array, scenario: Scenario) -> Extension:
        return Extension(platform=(RateTorque(coefficient=values),))
