"""A constant torque that does not turn with the body: from a field outside, or gravity on a body that is held."""

from __future__ import annotations

from typing import final

import numpy as np
from typing_extensions import override

from testbed.arrays import Array
from testbed.effects.contract import Effect, Extension, Parameter
from testbed.plant.added_torques import InertialTorque as Addition
from testbed.prediction.hooks import Hooks, Instant
from testbed.scenario.environment import Free
from testbed.scenario.scenario import Scenario


class _Constant(Hooks):
    needs_attitude = True
    needs_rate = False

    @override
    def torque(self, value: Array, at: Instant) -> Array:
        """Rᵀ T, row by row: without the conjugation of NumPy's vecmat, and faster than a sum over an axis of three."""
        at_start = np.matvec(np.swapaxes(at.first_NB, -1, -2), value)
        rows = (at_start[..., axis, None] * at.attitude[..., axis, :] for axis in range(3))
        return np.asarray(sum(rows, np.zeros(3)))


@final
class InertialTorque(Effect):
    """T_B = Rᵀ T, T constant in N.

    Where nothing tells the attitude, N has the body's axes at each run's first sample; in surroundings it is theirs,
    and runs that begin in other attitudes have the same torque.
    """

    id = "inertial_torque"
    components = ("platform",)
    parameters = tuple(Parameter(name=f"torque_{axis}_N_m", unit="N·m", typical=5e-5) for axis in "xyz")
    sentence = "A constant torque that does not turn with the body drives it, as a magnetic field outside does."
    look_alikes = ("body_torque", "tether")
    yields_to = ("center_of_mass_offset", "magnetic_dipole")
    includes = ("actuator_weak", "actuator_misaligned", "thrust_offset")
    confirm = (
        "A slow turn by half a revolution: a torque fixed in space stays where it was and changes sign in the body."
    )

    @override
    def hooks(self, component: str) -> Hooks:
        return _Constant()

    @override
    def extension(self, component: str, values: Array, scenario: Scenario) -> Extension:
        free = isinstance(scenario.environment, Free)
        axes = np.array(scenario.initial.attitude_quat_NB if free else (1.0, 0.0, 0.0, 0.0))
        return Extension(platform=(Addition(torque=values, quat_NA=axes),))
