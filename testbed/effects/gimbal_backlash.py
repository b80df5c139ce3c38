"""One gimbal has play between its encoder and its axis."""

from __future__ import annotations

from dataclasses import replace
from typing import final

import numpy as np
from typing_extensions import override

from testbed.arrays import Array
from testbed.cmg.cluster import Cluster
from testbed.effects.contract import UNITS, Effect, Extension, Parameter, only_unit
from testbed.prediction.grid import Gimbals, Grid
from testbed.prediction.hooks import Hooks
from testbed.scenario.scenario import Scenario

_REVERSAL = 0.05
"""rad/s, in which the axis crosses the play."""


class _Loose(Hooks):
    def __init__(self, component: str) -> None:
        self._component = component

    @override
    def gimbals(self, gimbals: Gimbals, value: Array, grid: Grid, cluster: Cluster) -> Gimbals:
        half = 0.5 * only_unit(self._component, value[:, 0])[:, None]
        return replace(gimbals, angle=gimbals.angle - half * np.tanh(gimbals.rate / _REVERSAL))


@final
class GimbalBacklash(Effect):
    """d = d̄ - (b/2) sign(ḋ): the axis is dragged along, half the play behind the encoder."""

    id = "gimbal_backlash"
    flies = False
    components = UNITS
    parameters = (Parameter(name="dead_zone_rad", unit="rad", typical=0.02, lower=0.0, upper=0.5),)
    needs = ("gimbal_angle",)
    sentence = "The gimbal of {component} has play between its encoder and its axis."
    look_alikes = ("gimbal_zero", "gimbal_coulomb_friction")
    confirm = "Turn that gimbal slowly to and fro: behind each reversal the axis stands still while the encoder moves."

    @override
    def hooks(self, component: str) -> Hooks:
        return _Loose(component)

    @override
    def extension(self, component: str, values: Array, scenario: Scenario) -> Extension:
        return Extension()
