"""The momentum of one rotor differs from nominal: its speed from the tachometer's reading, or its spin inertia."""

from __future__ import annotations

from dataclasses import replace
from typing import final

import numpy as np
from typing_extensions import override

from testbed.arrays import Array
from testbed.effects.contract import UNITS, Effect, Extension, Parameter, only_unit
from testbed.prediction.grid import Gimbals, Grid
from testbed.prediction.hooks import Hooks
from testbed.scenario.scenario import Scenario
from testbed.scenario.values import per_unit


class _Scaled(Hooks):
    def __init__(self, component: str) -> None:
        self._component = component

    @override
    def gimbals(self, gimbals: Gimbals, value: Array, grid: Grid) -> Gimbals:
        scale = 1.0 + only_unit(self._component, value[:, 0], gimbals.angle.shape[-1])
        return replace(gimbals, rotor_momentum=gimbals.rotor_momentum * scale[:, None])


@final
class RotorSpeed(Effect):
    """h_i → (1 + e) h_i against telemetry."""

    id = "rotor_speed"
    components = UNITS
    parameters = (
        Parameter(name="relative_error", unit="1", typical=0.01, lower=-1.0, upper=0.5, plausible=(-0.3, 0.3)),
    )
    needs = ("gimbal_angle",)
    sentence = "The rotor of {component} does not have the momentum that its tachometer and its drawing state."
    look_alikes = ("inertia", "gimbal_zero")
    confirm = "Null motion of that unit; an outside measurement for an error common to all rotors."

    @override
    def hooks(self, component: str) -> Hooks:
        return _Scaled(component)

    @override
    def extension(self, component: str, values: Array, scenario: Scenario) -> Extension:
        units = scenario.gyros.units
        scale = 1.0 + only_unit(component, values[0], units)
        stated = scenario.truth.rotor_momentum_N_m_s
        momentum = np.broadcast_to(scenario.gyros.rotor_momentum if stated is None else stated, units)
        shown = 1.0 + np.array(per_unit(scenario.tachometer.scale_factor_error, units, 0.0))
        return Extension(
            scenario={
                "truth": {"rotor_momentum_N_m_s": (momentum * scale).tolist()},
                "tachometer": {"scale_factor_error": (shown / scale - 1.0).tolist()},
            }
        )
