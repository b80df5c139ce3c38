"""One gimbal has play between its encoder and its axis."""

from __future__ import annotations

from dataclasses import replace
from typing import final

import numpy as np
from scipy.interpolate import CubicSpline
from typing_extensions import override

from testbed.arrays import Array
from testbed.effects.contract import UNITS, Effect, Extension, Parameter, only_unit, unit_index
from testbed.estimation.telemetry import GimbalRun
from testbed.prediction.grid import Gimbals, Grid
from testbed.prediction.hooks import Hooks
from testbed.scenario.scenario import Scenario
from testbed.scenario.values import per_unit

_SPECK = 5e-4
"""rad. No gyro shows so small a play, and no encoder's noise of 1e-4 rad takes the axis along behind it."""


class _Loose(Hooks):
    predicts_gimbals = False  # a servo that sees its encoder jump hunts, at instants that no sample shows

    def __init__(self, component: str) -> None:
        self._unit = unit_index(component)

    @override
    def gimbals(self, gimbals: Gimbals, value: Array, grid: Grid) -> Gimbals:
        splines = [_behind(run, self._unit, value[:, 0]) for run in grid.gimbal_runs]
        angle, rate = (
            np.stack([spline(time, order) for spline, time in zip(splines, grid.time, strict=True)]) for order in (0, 1)
        )
        only = np.arange(gimbals.angle.shape[-1]) == self._unit
        return replace(
            gimbals,
            angle=gimbals.angle + only * angle[..., None],
            rate=gimbals.rate + only * rate[..., None],
        )


def _behind(run: GimbalRun, unit: int, dead_zone: Array) -> CubicSpline:
    """Return by how much an axis differs from a run's encoder, rad, as the spline of its samples, for widths of (P,).

    The encoder's side drags the axis along behind it; within the play the axis stands still. It starts in the middle.
    """
    encoder = np.unwrap(run.gimbals.angle[:, unit])
    contacts = np.array([_contacts(encoder.tolist(), 0.5 * width) for width in dead_zone.real.tolist()])
    axis = encoder[contacts[..., 0]] - 0.5 * dead_zone[:, None] * contacts[..., 1]
    return CubicSpline(run.actuator_time, axis - encoder, axis=1)


def _contacts(encoder: list[float], half: float) -> list[tuple[int, int]]:
    """Return at which sample the axis was last dragged along, and to which side, up to every sample."""
    axis, contact = encoder[0], (0, 0)
    contacts = []
    for sample, angle in enumerate(encoder):
        side = (angle - axis > half) - (angle - axis < -half)
        if side:
            axis, contact = angle - half * side, (sample, side)
        contacts.append(contact)
    return contacts


@final
class GimbalBacklash(Effect):
    """d̄ = d + (b/2) sign(ḋ): the axis is dragged along, half the play behind the encoder.

    A flown servo that sees the encoder jump hunts about each slow reversal, at the rate of its control loop.
    """

    id = "gimbal_backlash"
    components = UNITS
    parameters = (
        Parameter(name="dead_zone_rad", unit="rad", typical=0.02, lower=0.0, upper=0.5, plausible=(0.0, 0.1)),
    )
    needs = ("gimbal_angle",)
    sentence = "The gimbal of {component} has play between its encoder and its axis."
    look_alikes = ("gimbal_zero", "gimbal_coulomb_friction")
    confounds = ("gimbal_lag", "gimbal_viscous_friction", "gimbal_coulomb_friction")  # a servo that hunts
    confirm = "Turn that gimbal slowly to and fro: behind each reversal the axis stands still while the encoder moves."

    @override
    def starts(self, component: str, grid: Grid) -> Array:
        return np.array([[_SPECK]])

    @override
    def hooks(self, component: str) -> Hooks:
        return _Loose(component)

    @override
    def extension(self, component: str, values: Array, scenario: Scenario) -> Extension:
        units, present = scenario.gyros.units, scenario.encoder.dead_zone_rad
        dead_zone = np.array(per_unit(present, units, 0.0)) + only_unit(component, values[:1], units)[0]
        return Extension(scenario={"encoder": {"dead_zone_rad": dead_zone.tolist()}})
