"""On orbit the gravity gradient turns the platform more, or less, than is believed."""

from __future__ import annotations

from typing import final

import numpy as np
from typing_extensions import override

from testbed.arrays import Array
from testbed.dynamics.environment import gradient_torque
from testbed.effects.contract import Effect, Extension, Parameter
from testbed.prediction.environment import orbit_of, outward_in_body
from testbed.prediction.hooks import Hooks, Instant, column
from testbed.scenario.scenario import Scenario


class _Stronger(Hooks):
    needs_attitude = True
    needs_rate = False

    @override
    def torque(self, value: Array, at: Instant) -> Array:
        assert at.surroundings is not None
        orbit, inertia = (
            orbit_of(at),
            at.surroundings.inertia,
        )  # as the records show it without the effect: its error shows in second order
        return np.asarray(column(value, 0) * gradient_torque(orbit, inertia, outward_in_body(orbit, at)))


@final
class GravityGradient(Effect):
    """T → (1 + e) T, T = 3 n² r × J r."""

    id = "gravity_gradient"
    components = ("platform",)
    # Without a gradient it is -1; another orbit of the Earth would have 1 at the most, a boom that is out many times as
    # much.
    parameters = (
        Parameter(name="relative_error", unit="1", typical=1.0, lower=-1.0, upper=100.0, plausible=(-1.0, 30.0)),
    )
    sentence = "The gradient of gravity turns {component} more or less than its orbit and its inertia say."
    look_alikes = ("magnetic_dipole", "inertial_torque", "body_torque")
    confirm = "The same flight at another attitude: with a principal axis upright there is no torque."
    environment = "orbit"

    @override
    def hooks(self, component: str) -> Hooks:
        return _Stronger()

    @override
    def extension(self, component: str, values: Array, scenario: Scenario) -> Extension:
        factor = scenario.truth.gravity_gradient_factor
        changed = (1.0 if factor is None else factor) + float(values[0])
        return Extension(scenario={"truth": {"gravity_gradient_factor": changed}})
