"""Torques by formulas on simulated platforms: evaluated at every stage of the integration, as gravity is.

MuJoCo holds an applied torque over a step. With formulas, the stages of the classical Runge-Kutta rule are taken here
instead, each with the torque at its own state, and a formula's memory is integrated with them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from testbed.arrays import Array, Vectors3
from testbed.formulas.motion import Moment
from testbed.formulas.torque import NO_CONSTANTS, Torque
from testbed.plant.layout import Layout
from testbed.rotation.quaternion import matrix_or_identity

Slopes: TypeAlias = tuple[Array, ...]
"""Rates of change of the parts of a state, in order."""

_STAGES = ((0.0, 1.0 / 6.0), (0.5, 1.0 / 3.0), (0.5, 1.0 / 3.0), (1.0, 1.0 / 6.0))
"""Place of each stage in the step and its weight: the classical fourth-order rule, which MuJoCo's RK4 is."""


@dataclass(frozen=True, kw_only=True, eq=False)
class FormulaTorques:
    """Formulas on B platforms side by side.

    Attributes:
        torques: which add up, the same on all platforms.
        layout: of the platforms' state vectors.
        first_NA: R_NA, the body's axes when the flight started, shape (B, 3, 3).
    """

    torques: tuple[Torque, ...]
    layout: Layout
    first_NA: Array

    def moment(self, time: Array, qpos: Array, qvel: Array) -> Moment:
        """Return what the formulas read of the platforms' states, shapes (B,), (B, nq) and (B, nv)."""
        attitude_NB = matrix_or_identity(qpos[:, self.layout.attitude])
        return Moment(
            time=time,
            body_rate=qvel[:, self.layout.body_rate],
            attitude=np.swapaxes(self.first_NA, -1, -2) @ attitude_NB,
            gimbal_angle=qpos[:, self.layout.gimbal_angle],
            gimbal_rate=qvel[:, self.layout.gimbal_rate],
        )

    def first_memory(self, at: Moment) -> Array:
        """Return the formulas' memories at the start, shape (B, states of all)."""
        return self._joined([each.law.first_state(at, NO_CONSTANTS) for each in self.torques], len(at.time))

    def torque(self, at: Moment, memory: Array) -> Vectors3:
        """Return what they add up to, shape (B, 3), N·m, body axes."""
        pairs = zip(self.torques, self._own(memory), strict=True)
        total = np.zeros((len(at.time), 3))
        for each, own in pairs:
            total = total + each.value(at, own)
        return total

    def memory_rate(self, at: Moment, memory: Array) -> Array:
        """Return the rates of change of the memories, shape (B, states of all)."""
        pairs = zip(self.torques, self._own(memory), strict=True)
        return self._joined([each.law.state_rate(at, own, NO_CONSTANTS) for each, own in pairs], len(at.time))

    def _own(self, memory: Array) -> Sequence[Array]:
        return np.split(memory, np.cumsum([each.law.states for each in self.torques])[:-1], axis=-1)

    def _joined(self, parts: Sequence[Array], platforms: int) -> Array:
        return np.concatenate([np.zeros((platforms, 0)), *parts], axis=-1)


def stepped(
    step: float,
    state: Slopes,
    slopes_at: Callable[[float, Slopes], Slopes],
    moved: Callable[[Slopes, Slopes, float], Slopes],
) -> Slopes:
    """Return a state after one step of the classical fourth-order rule.

    Args:
        step: s.
        state: at its beginning.
        slopes_at: from the place in the step, as a share of it, and the state there to the rates of change.
        moved: from a state, rates of change and a time to the state after that time; quaternions stay of unit length.
    """
    slopes: Slopes = ()
    total: Slopes | None = None
    for share, weight in _STAGES:
        slopes = slopes_at(share, moved(state, slopes, share * step) if share else state)
        weighted = tuple(weight * slope for slope in slopes)
        total = weighted if total is None else tuple(map(np.add, total, weighted))
    assert total is not None
    return moved(state, total, step)
