"""The actuators do more or less than is recorded, about each body axis by a share of its own."""

from __future__ import annotations

from typing import final

import numpy as np
from typing_extensions import override

from testbed.arrays import Array
from testbed.effects.contract import SHOWING_UNITS, Effect, Extension, Parameter, Quantity
from testbed.prediction.grid import Grid
from testbed.prediction.hooks import Hooks
from testbed.scenario.scenario import Scenario


class _Stronger(Hooks):
    @override
    def actuator_response(self, asked_B: Array, value: Array, grid: Grid) -> Array:
        return np.asarray(asked_B * np.exp(value[:, None]))

    @override
    def cluster_momentum(self, momentum_B: Array, value: Array, grid: Grid) -> Array:
        if grid.gimbals is not None or not momentum_B.any():  # what holds no momentum holds none with more of it
            return momentum_B
        return np.asarray(momentum_B * np.exp(value[:, None]))


@final
class ActuatorGain(Effect):
    """τ_k = exp(q_k) τ_k,recorded; of actuators that hold momentum, h_k = exp(q_k) h_k,recorded.

    No actuator is reversed by it, and half as much is as far as twice as much: what torque a command gives may be known
    to a factor only. A gain that is common to all axes is a scale of J, which no motion shows: about one axis nothing
    is left of it.
    """

    id = "actuator_gain"
    components = ("actuators",)
    # Plausible are a gain of 0.4 to one of 2; the search goes to a factor of 150.
    parameters = tuple(
        Parameter(name=f"log_gain_{axis}", unit="1", typical=0.03, lower=-5.0, upper=5.0, plausible=(-0.9, 0.7))
        for axis in "xyz"
    )
    needs = ("applied_torque_or_cluster_momentum",)
    measured_by = SHOWING_UNITS
    sentence = "The actuators do more or less than is recorded, about each axis by a share of its own."
    look_alikes = ("inertia", "gyro_scale")
    confirm = "A known load on the platform: the inertia then is known, and the gain is not taken for it."
    flies = False  # the flown platform's actuators are its gimbals

    @override
    def hooks(self, component: str) -> Hooks:
        return _Stronger()

    @override
    def quantities(self, values: Array, std: Array) -> tuple[Quantity, ...]:
        gain = np.exp(values)
        of_axes = zip("xyz", gain, gain * std, strict=True)
        return tuple(
            Quantity(name=f"gain_error_{axis}", unit="1", value=float(value - 1.0), std=float(error))
            for axis, value, error in of_axes
        )

    @override
    def extension(self, component: str, values: Array, scenario: Scenario) -> Extension:
        return Extension()
