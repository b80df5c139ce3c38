"""The gyro cannot show more than a certain rate: its readings have flat tops."""

from __future__ import annotations

from collections.abc import Sequence
from math import inf
from typing import final

import numpy as np
from typing_extensions import override

from testbed.arrays import Array, Flags, Series
from testbed.effects.contract import Effect, Extension, Parameter, Quantity
from testbed.estimation.telemetry import Telemetry
from testbed.prediction.grid import Grid
from testbed.prediction.hooks import Hooks, magnitude, sign_of
from testbed.scenario.scenario import Scenario

_FEWEST = 3
"""Samples at exactly the largest reading that make a flat top; in noise that is not clipped there is one."""
_ROUNDING = 1e-9
"""Relative; readings this close are the same number in a file."""


class _Clipped(Hooks):
    @override
    def gyro_reading(self, reading: Array, value: Array, time: Series, run: int) -> Array:
        inverse = value[:, 0, None, None]
        beyond = (magnitude(reading) * inverse).real > 1.0
        return np.where(beyond, sign_of(reading) / np.where(beyond, inverse, 1.0), reading)


@final
class GyroSaturation(Effect):
    """ω̄ = min(max(ω, -L), L) on each axis; searched as 1 / L, zero where it is absent, and reported as L.

    A clipped reading has no noise: the prediction behind the same limit meets it exactly.
    """

    id = "gyro_saturation"
    components = ("gyro",)
    parameters = (Parameter(name="inverse_limit_s_rad", unit="s/rad", typical=2.0, lower=0.0, plausible=(0.0, 20.0)),)
    sentence = "The gyro cannot show more than a certain rate: its readings have flat tops."
    confirm = "The same maneuver at half the rate: nothing of it is clipped then."

    @override
    def hooks(self, component: str) -> Hooks:
        return _Clipped()

    @override
    def starts(self, component: str, grid: Grid) -> Array:
        return np.array([[1.0 / _largest(grid.runs) if is_clipped(grid.runs) else 0.0]])

    @override
    def quantities(self, values: Array, std: Array) -> tuple[Quantity, ...]:
        limit = 1.0 / values[0] if values[0] > 0.0 else inf
        error = limit**2 * std[0] if values[0] > 0.0 else inf
        return (Quantity(name="limit_rad_s", unit="rad/s", value=float(limit), std=float(error)),)

    @override
    def extension(self, component: str, values: Array, scenario: Scenario) -> Extension:
        if values[0] <= 0.0:
            return Extension()
        limit = min(1.0 / float(values[0]), scenario.gyro.saturation_rad_s or inf)
        return Extension(scenario={"gyro": {"saturation_rad_s": limit}})


def is_clipped(runs: Sequence[Telemetry]) -> bool:
    """Return whether runs read the same largest rate so often that it has to be a limit."""
    return any(clipped.any() for clipped in flat_tops(runs))


def flat_tops(runs: Sequence[Telemetry]) -> list[Flags]:
    """Return which readings of each run are the largest of all, shape (N, 3); none if that is no limit.

    Args:
        runs: of one gyro.
    """
    limit = _largest(runs)
    at_limit = [np.abs(run.body_rate) > limit * (1.0 - _ROUNDING) for run in runs]
    enough = sum(int(each.sum()) for each in at_limit) >= _FEWEST
    return [np.logical_and(enough, each) for each in at_limit]


def _largest(runs: Sequence[Telemetry]) -> float:
    return max(float(np.abs(run.body_rate).max()) for run in runs)
