"""The actuators do more or less than is recorded, about each body axis by a share of its own."""

from __future__ import annotations

from typing import final

import numpy as np
from typing_extensions import override

from testbed.arrays import Array
from testbed.effects.contract import Effect, Extension, Parameter
from testbed.prediction.grid import Grid
from testbed.prediction.hooks import Hooks
from testbed.scenario.scenario import Scenario


class _Stronger(Hooks):
    @override
    def actuator_response(self, asked_B: Array, value: Array, grid: Grid) -> Array:
        return np.asarray(asked_B * (1.0 + value[:, None]))

    @override
    def cluster_momentum(self, momentum_B: Array, value: Array, grid: Grid) -> Array:
        return momentum_B if grid.gimbals is not None else np.asarray(momentum_B * (1.0 + value[:, None]))


@final
class ActuatorGain(Effect):
    """τ_k = (1 + g_k) τ_k,recorded; of actuators that hold momentum, h_k = (1 + g_k) h_k,recorded.

    A gain that is common to all axes is a scale of J, which no motion shows: about one axis nothing is left of it.
    """

    id = "actuator_gain"
    components = ("actuators",)
    parameters = tuple(
        Parameter(name=f"gain_error_{axis}", unit="1", typical=0.03, lower=-1.0, upper=3.0, plausible=(-0.6, 1.0))
        for axis in "xyz"
    )
    needs = ("applied_torque_or_cluster_momentum",)
    measured_by = ("gimbal_angle",)
    sentence = "The actuators do more or less than is recorded, about each axis by a share of its own."
    look_alikes = ("inertia", "gyro_scale")
    confirm = "A known load on the platform: the inertia then is known, and the gain is not taken for it."
    flies = False  # the flown platform's actuators are its gimbals

    @override
    def hooks(self, component: str) -> Hooks:
        return _Stronger()

    @override
    def extension(self, component: str, values: Array, scenario: Scenario) -> Extension:
        return Extension()
