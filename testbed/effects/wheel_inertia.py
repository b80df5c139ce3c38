"""One wheel has another spin inertia than its drawing says: its momentum is off in proportion to its speed."""

from __future__ import annotations

from typing import final

import numpy as np
from typing_extensions import override

from testbed.arrays import Array
from testbed.effects.contract import WHEELS, Effect, Extension, Parameter, only_wheel, wheel_index
from testbed.prediction.grid import Grid
from testbed.prediction.hooks import Hooks, column
from testbed.scenario.actuators import wheel_count
from testbed.scenario.scenario import Scenario
from testbed.scenario.values import per_unit


class _Scaled(Hooks):
    def __init__(self, component: str) -> None:
        self._component, self._wheel = component, wheel_index(component)

    @override
    def cluster_momentum(self, momentum_B: Array, value: Array, grid: Grid) -> Array:
        held = grid.wheel_momentum[..., self._wheel, None] * grid.wheels.axis_B[self._wheel]
        return np.asarray(momentum_B + column(value, 0)[:, None] * held)

    @override
    def wheel_inertia_error(self, value: Array, wheels: int) -> Array:
        return only_wheel(self._component, value, wheels)


@final
class WheelInertia(Effect):
    """Jw → (1 + e) Jw, of the wheel's momentum and its motor's load; in J, which is estimated, it does not show."""

    id = "wheel_inertia"
    components = WHEELS
    # A machined rotor is known to some thousandths; 0.5 either way is another rotor.
    parameters = (
        Parameter(name="relative_error", unit="1", typical=0.01, lower=-0.5, upper=0.5, plausible=(-0.3, 0.3)),
    )
    needs = ("wheel_speed",)
    sentence = "The rotor of {component} does not have the spin inertia, and so the momentum, that its drawing states."
    look_alikes = ("inertia",)
    confirm = "Null motion of the wheels; an outside measurement for an error common to all of them."

    @override
    def hooks(self, component: str) -> Hooks:
        return _Scaled(component)

    @override
    def extension(self, component: str, values: Array, scenario: Scenario) -> Extension:
        wheels = wheel_count(scenario.actuators)
        factors = np.array(per_unit(scenario.truth.wheel_spin_inertia_factor, wheels, 1.0))
        factors[wheel_index(component)] *= 1.0 + values[0]
        return Extension(scenario={"truth": {"wheel_spin_inertia_factor": factors.tolist()}})
