"""A torque against the body rate, in proportion to its square, with a coefficient on each axis."""

from __future__ import annotations

from typing import final

import numpy as np
from typing_extensions import override

from testbed.arrays import Array
from testbed.effects.contract import Effect, Extension, Parameter
from testbed.plant.added_torques import QuadraticRateTorque
from testbed.prediction.hooks import Hooks, Instant, magnitude
from testbed.scenario.scenario import Scenario


class _Drag(Hooks):
    @override
    def torque(self, value: Array, at: Instant) -> Array:
        return np.asarray(-value * at.body_rate * magnitude(at.body_rate))


@final
class QuadraticDrag(Effect):
    """T = -k ω |ω| on each body axis, each with its own rate."""

    id = "quadratic_drag"
    components = ("platform",)
    parameters = tuple(
        Parameter(name=f"coefficient_{axis}_N_m_s2_rad2", unit="N·m·s²/rad²", typical=5e-4, lower=0.0) for axis in "xyz"
    )
    sentence = "A drag torque opposes the body rate in proportion to its square, as fast air does."
    look_alikes = ("viscous_drag",)
    confirm = "The same maneuver at half and at twice the rate: a quadratic drag grows fourfold when the rate doubles."

    @override
    def hooks(self, component: str) -> Hooks:
        return _Drag()

    @override
    def extension(self, component: str, values: Array, scenario: Scenario) -> Extension:
        return Extension(platform=(QuadraticRateTorque(coefficient=values),))
