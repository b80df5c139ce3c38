"""A constant torque that turns with the body: a leak, a jet, a draught from a fan on board."""

from __future__ import annotations

from typing import final

from typing_extensions import override

from testbed.arrays import Array
from testbed.effects.contract import Effect, Extension, Parameter
from testbed.plant.added_torques import BodyTorque as Addition
from testbed.prediction.hooks import Hooks, Instant
from testbed.scenario.scenario import Scenario


class _Constant(Hooks):
    needs_rate = False

    @override
    def torque(self, value: Array, at: Instant) -> Array:
        return value


@final
class BodyTorque(Effect):
    """T is constant in body axes."""

    id = "body_torque"
    components = ("platform",)
    parameters = tuple(Parameter(name=f"torque_{axis}_N_m", unit="N·m", typical=5e-5) for axis in "xyz")
    sentence = "A constant torque that turns with the body drives it, as a leak or a jet does."
    look_alikes = ("inertial_torque", "gyro_drift")
    yields_to = ("center_of_mass_offset",)
    includes = ("actuator_weak", "actuator_misaligned", "thrust_offset")
    confirm = "A slow turn by half a revolution: a torque fixed in the body turns with it."

    @override
    def hooks(self, component: str) -> Hooks:
        return _Constant()

    @override
    def extension(self, component: str, values: Array, scenario: Scenario) -> Extension:
        return Extension(platform=(Addition(torque_B=values),))
