"""Actuators that hold momentum change it no faster than their greatest torque lets them: wheels at their limit."""

from __future__ import annotations

from typing import final

import numpy as np
from typing_extensions import override

from testbed.arrays import Array
from testbed.effects.contract import Effect, Extension, Parameter
from testbed.prediction.grid import Grid
from testbed.prediction.hooks import Hooks
from testbed.prediction.smooth import Smooth
from testbed.scenario.scenario import Scenario

_LEVELS = (0.3, 0.5, 0.7, 0.9)
"""Of the greatest torque that the recorded momentum asks for, from which searches begin: below a third of it hardly
anything of a maneuver is left, above nine tenths a limit shows in few samples."""
_PARTS = 4
"""Of a half step of the grid: how late a limit sets in stays until the momentum has caught up. With 1, a wheel of
0.03 N·m left a gap of 1.38 and 1.4 ms of lag that is not there (`concealing/rig.py`, seeds 101 to 103)."""


class _Limited(Hooks):
    @override
    def cluster_momentum(self, momentum_B: Array, value: Array, grid: Grid) -> Array:
        if grid.gimbals is not None:
            return momentum_B
        most = value[:, 1, None] * (grid.step / 2.0)[:, None, None]
        return np.asarray(momentum_B + value[:, 0, None, None] * (_limited(momentum_B, most) - momentum_B))


def _limited(asked_B: Array, most: Array) -> Array:
    """Return what follows a momentum by no more than so much a half step, shape (R, P, T, 3).

    Args:
        asked_B: shape (R, P, T, 3), N·m·s.
        most: shape (R, P, 1), N·m·s.
    """
    runs, sets, times, _ = asked_B.shape
    every = asked_B.reshape(-1, times, 3)
    fine = np.arange(_PARTS * (times - 1) + 1) / _PARTS
    asked = Smooth(np.arange(float(times)), every).between(np.broadcast_to(fine, (len(every), len(fine))))
    asked = asked.reshape(runs, sets, -1, 3)
    begin = np.broadcast_to(asked[:, :, 0], np.broadcast_shapes(asked[:, :, 0].shape, most.shape))
    held, kept = begin, [begin]
    for step in range(1, asked.shape[2]):
        ahead = asked[:, :, step] - held
        beyond = np.abs(ahead.real) > most.real / _PARTS
        held = held + np.where(beyond, np.sign(ahead.real) * most / _PARTS, ahead)
        if step % _PARTS == 0:
            kept.append(held)
    return np.stack(kept, axis=2)


@final
class ActuatorRateLimit(Effect):
    """|ḣ_k| <= τ on each axis; found as a share of what such a limit changes, which is one where there is a limit."""

    id = "actuator_rate_limit"
    components = ("actuators",)
    parameters = (
        Parameter(name="share", unit="1", typical=1.0, lower=0.0, upper=1.0, plausible=(0.0, 1.0)),
        Parameter(name="greatest_torque_N_m", unit="N·m", typical=1e-2, lower=1e-6, absent=1e-2, scanned=True),
    )
    needs = ("cluster_momentum",)
    measured_by = ("gimbal_angle", "applied_torque")  # which hold no momentum, or show it
    sentence = "The actuators change their momentum no faster than a greatest torque lets them, whatever is recorded."
    look_alikes = ("actuator_lag", "actuator_delay")
    confirm = "The same maneuver at half its size: no limit is reached then."
    flies = False  # a flight's gimbals have a limit of their own, that telemetry shows

    @override
    def hooks(self, component: str) -> Hooks:
        return _Limited()

    @override
    def starts(self, component: str, grid: Grid) -> Array:
        rates = np.diff(grid.cluster_momentum_B[:, 0], axis=1) / (grid.step / 2.0)[:, None, None]
        return np.array([[0.0, level * float(np.abs(rates).max())] for level in _LEVELS])

    @override
    def extension(self, component: str, values: Array, scenario: Scenario) -> Extension:
        return Extension()
