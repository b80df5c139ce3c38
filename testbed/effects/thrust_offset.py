"""The centre of mass is not where the thrusts are counted from."""

from __future__ import annotations

from typing import final

import numpy as np
from typing_extensions import override

from testbed.arrays import Array
from testbed.effects.contract import HOLDING_MOMENTUM, Effect, Extension, Parameter
from testbed.effects.single_actuator import thrusters_of
from testbed.prediction.grid import Grid
from testbed.prediction.hooks import Hooks
from testbed.prediction.kernels import cross
from testbed.scenario.scenario import Scenario


class _Offset(Hooks):
    @override
    def asked_torque(self, asked_B: Array, value: Array, grid: Grid) -> Array:
        assert grid.thrust is not None
        force_B = grid.thrust @ thrusters_of(grid).direction_B
        return np.asarray(asked_B - cross(value[:, None], force_B))


@final
class ThrustOffset(Effect):
    """T = -r × ΣF, r from the stated to the true centre of mass."""

    id = "thrust_offset"
    components = ("platform",)
    parameters = tuple(
        Parameter(name=f"offset_{axis}_m", unit="m", typical=1e-3, lower=-10.0, upper=10.0, plausible=(-0.5, 0.5))
        for axis in "xyz"
    )
    needs = ("thrust",)
    measured_by = HOLDING_MOMENTUM
    sentence = "The centre of mass lies beside where it is stated, so that the summed thrust turns the platform."
    look_alikes = ("body_torque", "actuator_weak")
    confirm = (
        "The same hover with more and with less thrust: the torque grows in proportion to it; or weigh the platform."
    )
    flies = False

    @override
    def hooks(self, component: str) -> Hooks:
        return _Offset()

    @override
    def extension(self, component: str, values: Array, scenario: Scenario) -> Extension:
        return Extension()
