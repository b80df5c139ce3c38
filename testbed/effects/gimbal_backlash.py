"""One gimbal has play between its encoder and its axis."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from typing import final

import numpy as np
from scipy.interpolate import CubicSpline
from typing_extensions import override

from testbed.arrays import Array
from testbed.cmg.cluster import Cluster
from testbed.effects.contract import UNITS, Effect, Extension, Parameter, only_unit
from testbed.estimation.telemetry import Telemetry
from testbed.prediction.grid import Gimbals, Grid
from testbed.prediction.hooks import Hooks
from testbed.scenario.scenario import Scenario

_REVERSAL = 0.05
"""rad/s, in which the axis crosses the play."""
_WINDOW = 1.0 / 16.0
"""s. Angles so far apart tell a rate to 0.05 rad/s behind an encoder noise of 1e-3 rad."""


class _Loose(Hooks):
    def __init__(self, component: str) -> None:
        self._component = component

    @override
    def gimbals(self, gimbals: Gimbals, value: Array, grid: Grid, cluster: Cluster) -> Gimbals:
        half = 0.5 * only_unit(self._component, value[:, 0])[:, None]
        lead = np.stack([_lead(run)(time) for run, time in zip(grid.runs, grid.time, strict=True)])[:, None]
        return replace(gimbals, angle=gimbals.angle - half * lead)


@lru_cache(maxsize=64)
def _lead(run: Telemetry) -> CubicSpline:
    """Return on which side of the play a run's encoders are, from -1 to 1, as the spline of their samples takes it.

    A reversal's jump lies between two samples. The side is told from samples that came before, which it has not moved.
    """
    assert run.gimbal_angle is not None
    time, angle = run.actuator_time, np.unwrap(run.gimbal_angle, axis=0)
    apart = max(1, round(_WINDOW / float(np.median(np.diff(time)))))
    mean = np.empty_like(angle)
    mean[apart:] = (angle[apart:] - angle[:-apart]) / (time[apart:] - time[:-apart])[:, None]
    mean[:apart] = mean[apart]
    before = np.concatenate([mean[:apart], mean[:-apart]])
    return CubicSpline(time, np.tanh((1.5 * mean - 0.5 * before) / _REVERSAL))


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
