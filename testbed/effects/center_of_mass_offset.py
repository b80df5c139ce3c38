"""On an air bearing the centre of mass is not where it is believed: gravity turns the platform."""

from __future__ import annotations

from typing import final

import numpy as np
from typing_extensions import override

from testbed.arrays import Array
from testbed.dynamics.environment import Pivoted, parallel_axes
from testbed.effects.contract import Effect, Extension, Parameter
from testbed.prediction.environment import up_B
from testbed.prediction.grid import Grid
from testbed.prediction.hooks import Hooks, Instant
from testbed.prediction.kernels import cross
from testbed.scenario.environment import AirBearing
from testbed.scenario.scenario import Scenario


class _Displaced(Hooks):
    needs_attitude = True
    needs_rate = False

    @override
    def torque(self, value: Array, at: Instant) -> Array:
        assert at.surroundings is not None
        environment = at.surroundings.environment
        assert isinstance(environment, Pivoted)
        vertical_B = up_B(at)
        return cross(vertical_B, np.broadcast_to(environment.weight * value, vertical_B.shape))

    @override
    def added_inertia(self, value: Array, grid: Grid) -> Array:
        pivot = grid.runs[0].pivot
        assert pivot is not None
        return parallel_axes(pivot.mass, pivot.offset_B + value) - pivot.added_inertia


@final
class CenterOfMassOffset(Effect):
    """T = m g u × e, u the vertical and e from where the centre of mass is believed to be to where it is."""

    id = "center_of_mass_offset"
    components = ("platform",)
    # A table is balanced by hand to some 10 micrometres; its own size, metres, is another platform.
    parameters = tuple(
        Parameter(name=f"offset_{axis}_m", unit="m", typical=2e-5, lower=-1.0, upper=1.0, plausible=(-0.02, 0.02))
        for axis in "xyz"
    )
    sentence = "The centre of mass of the platform on its bearing is off from where it is believed: gravity turns it."
    look_alikes = ("body_torque", "inertial_torque", "tether")
    confirm = "Release it at rest, level and then tilted either way: it swings about the place where it hangs."
    environment = "air_bearing"

    @override
    def hooks(self, component: str) -> Hooks:
        return _Displaced()

    @override
    def extension(self, component: str, values: Array, scenario: Scenario) -> Extension:
        believed = scenario.truth.center_of_mass_offset_m
        if believed is None:
            assert isinstance(scenario.environment, AirBearing)
            believed = scenario.environment.center_of_mass_offset_m
        return Extension(scenario={"truth": {"center_of_mass_offset_m": (np.array(believed) + values).tolist()}})
