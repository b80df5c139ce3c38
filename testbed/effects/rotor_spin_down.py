"""One rotor is not driven any more and slows down, against its telemetry."""

from __future__ import annotations

from dataclasses import replace
from typing import final

import numpy as np
from typing_extensions import override

from testbed.arrays import Array
from testbed.effects.contract import UNITS, Effect, Extension, Parameter, only_unit, unit_index
from testbed.plant.unit_additions import RotorDrag
from testbed.prediction.grid import Gimbals, Grid
from testbed.prediction.hooks import Hooks
from testbed.scenario.scenario import Scenario


class _Slowing(Hooks):
    def __init__(self, component: str) -> None:
        self._component = component

    @override
    def gimbals(self, gimbals: Gimbals, value: Array, grid: Grid) -> Gimbals:
        elapsed = (grid.time - grid.time[:, :1])[:, None, :, None]
        decay = np.exp(-only_unit(self._component, value[:, 0], gimbals.angle.shape[-1])[:, None] * elapsed)
        return replace(gimbals, rotor_momentum=gimbals.rotor_momentum * decay)


@final
class RotorSpinDown(Effect):
    """h_i → h_i exp(-k (t - t0)), t0 the first sample of each run; with tachometers, against their readings."""

    id = "rotor_spin_down"
    components = UNITS
    parameters = (Parameter(name="decay_1_s", unit="1/s", typical=0.01, lower=0.0, upper=10.0, plausible=(0.0, 1.0)),)
    needs = ("gimbal_angle",)
    sentence = "The rotor of {component} slows down during the flight and its telemetry does not say so."
    look_alikes = ("rotor_speed", "gyro_drift")
    confirm = (
        "Read that unit's tachometer, or fly the maneuver twice in one flight: the second time the error is larger."
    )

    @override
    def hooks(self, component: str) -> Hooks:
        return _Slowing(component)

    @override
    def extension(self, component: str, values: Array, scenario: Scenario) -> Extension:
        if values[0] == 0.0:
            return Extension()
        return Extension(platform=(RotorDrag(unit=unit_index(component), decay=float(values[0])),))
