"""The platform's inertia differs from the nominal one."""

from __future__ import annotations

from typing import final

from typing_extensions import override

from testbed.arrays import Array
from testbed.dynamics.inertia import PARAMETER_NAMES, inertia_of
from testbed.effects.contract import Effect, Extension, Parameter
from testbed.plant.added_parts import AddedInertia
from testbed.prediction.algebra import inertia_matrix
from testbed.prediction.hooks import Hooks
from testbed.scenario.scenario import Scenario


class _Further(Hooks):
    @override
    def hidden_inertia(self, value: Array) -> Array:
        return -inertia_matrix(value)


@final
class Inertia(Effect):
    """J → J + dJ; where J is estimated together with the effects, as in a diagnosis, it explains nothing more."""

    id = "inertia"
    components = ("platform",)
    parameters = tuple(
        Parameter(name=f"d{name}_kg_m2", unit="kg·m²", typical=2e-4, lower=-0.1, upper=0.1) for name in PARAMETER_NAMES
    )
    sentence = "The platform's inertia differs from the nominal one."
    look_alikes = ("rotor_speed", "gyro_scale", "gyro_misalignment")
    confirm = "Another maneuver: the same inertia has to explain it; a total momentum tells it from errors of the gyro."

    @override
    def hooks(self, component: str) -> Hooks:
        return _Further()

    @override
    def extension(self, component: str, values: Array, scenario: Scenario) -> Extension:
        return Extension(platform=(AddedInertia(inertia=inertia_of(values)),))
