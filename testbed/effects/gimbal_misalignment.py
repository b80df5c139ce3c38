"""One unit's gimbal axis does not stand as it is drawn."""

from __future__ import annotations

from dataclasses import replace
from typing import final

import numpy as np
from typing_extensions import override

from testbed.arrays import Array
from testbed.cmg.misalignment import turned_axes
from testbed.effects.contract import UNITS, Effect, Extension, Parameter, only_unit
from testbed.prediction.grid import Gimbals, Grid
from testbed.prediction.hooks import Hooks
from testbed.scenario.scenario import Scenario
from testbed.scenario.values import per_unit


class _Tilted(Hooks):
    def __init__(self, component: str) -> None:
        self._component = component

    @override
    def gimbals(self, gimbals: Gimbals, value: Array, grid: Grid) -> Gimbals:
        turns = np.moveaxis(only_unit(self._component, value, gimbals.angle.shape[-1]), 1, 2)
        axes = np.broadcast_arrays(gimbals.gimbal_axis_B, gimbals.spin_axis_B, turns[..., :1])[:2]
        turned = [turned_axes(*each) for each in zip(*axes, turns, strict=True)]
        return replace(
            gimbals,
            gimbal_axis_B=np.stack([each.gimbal_axis_B for each in turned]),
            spin_axis_B=np.stack([each.spin_axis_B for each in turned]),
        )


@final
class GimbalMisalignment(Effect):
    """The unit is turned by a about its s at gimbal angle zero, then by b about the t that this has made."""

    id = "gimbal_misalignment"
    components = UNITS
    parameters = (
        Parameter(name="about_spin_axis_rad", unit="rad", typical=0.01, lower=-0.5, upper=0.5, plausible=(-0.2, 0.2)),
        Parameter(
            name="about_transverse_axis_rad", unit="rad", typical=0.01, lower=-0.5, upper=0.5, plausible=(-0.2, 0.2)
        ),
    )
    needs = ("gimbal_angle",)
    sentence = "The gimbal axis of {component} does not stand as it is drawn."
    look_alikes = ("gimbal_zero", "rotor_speed", "gyro_misalignment")
    confirm = "Turn that gimbal alone through a large angle: the momentum that it changes lies in a tilted plane."

    @override
    def hooks(self, component: str) -> Hooks:
        return _Tilted(component)

    @override
    def extension(self, component: str, values: Array, scenario: Scenario) -> Extension:
        units = scenario.gyros.units
        turns = np.array(per_unit(scenario.truth.gimbal_axis_misalignment_rad, units, (0.0, 0.0)))
        turns = turns + only_unit(component, values, units).T
        return Extension(scenario={"truth": {"gimbal_axis_misalignment_rad": turns.tolist()}})
