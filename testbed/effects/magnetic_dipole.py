"""On orbit the platform has a magnetic dipole that is not known of: the Earth's field turns it."""

from __future__ import annotations

from typing import final

import numpy as np
from typing_extensions import override

from testbed.arrays import Array
from testbed.dynamics.environment import dipole_torque
from testbed.effects.contract import Effect, Extension, Parameter
from testbed.prediction.environment import field_in_body, orbit_of
from testbed.prediction.hooks import Hooks, Instant
from testbed.scenario.environment import Orbit
from testbed.scenario.scenario import Scenario


class _Magnet(Hooks):
    needs_attitude = True
    needs_rate = False

    @override
    def torque(self, value: Array, at: Instant) -> Array:
        orbit = orbit_of(at)
        return dipole_torque(value, field_in_body(orbit, at))


@final
class MagneticDipole(Effect):
    """T = m × B, m fixed in the body and B in the local axes of the orbit."""

    id = "magnetic_dipole"
    components = ("platform",)
    # CubeSats have some 0.01 A·m² left over from their wires and magnets; spacecraft of tons, whose magnetics nobody
    # controls, some ten (NASA SP-8018, table of estimates by mass). 1e4 is beyond any magnetorquer.
    parameters = tuple(
        Parameter(
            name=f"dipole_{axis}_A_m2", unit="A·m²", typical=0.01, lower=-1e4, upper=1e4, plausible=(-100.0, 100.0)
        )
        for axis in "xyz"
    )
    sentence = "{component} has a magnetic dipole that is not known of: the Earth's field turns it."
    look_alikes = ("inertial_torque", "body_torque", "gravity_gradient")
    confirm = "The same flight along another field line: about the field itself a dipole has no torque."
    environment = "orbit"

    @override
    def hooks(self, component: str) -> Hooks:
        return _Magnet()

    @override
    def extension(self, component: str, values: Array, scenario: Scenario) -> Extension:
        believed = scenario.truth.magnetic_dipole_A_m2
        if believed is None:
            assert isinstance(scenario.environment, Orbit)
            believed = scenario.environment.magnetic_dipole_A_m2
        return Extension(scenario={"truth": {"magnetic_dipole_A_m2": (np.array(believed) + values).tolist()}})
