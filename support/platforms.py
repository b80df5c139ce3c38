"""The shipped platform and a smooth gimbal motion, for tests of every kind."""

from __future__ import annotations

import mujoco
import numpy as np

from testbed.arrays import Array, Units, Vector3
from testbed.plant.build import build
from testbed.plant.geometry import cluster_of
from testbed.plant.plant import Plant, RotorMode
from testbed.plant.properties import InitialState, PlatformProperties

ROTOR_MOMENTUM = 0.004714
"""Nominal momentum of each rotor, N·m·s (shared nominal platform)."""


def shipped() -> mujoco.MjModel:
    """The shipped platform, compiled as it stands."""
    return build(PlatformProperties())


def initial(
    body_rate: Vector3 | None = None, gimbal_angle: Units | None = None, velocity: Vector3 | None = None
) -> InitialState:
    """A start at the origin, at rest unless stated otherwise."""
    return InitialState(
        body_rate=np.zeros(3) if body_rate is None else body_rate,
        attitude=np.array([1.0, 0.0, 0.0, 0.0]),
        position=np.zeros(3),
        velocity=np.zeros(3) if velocity is None else velocity,
        gimbal_angle=np.zeros(6) if gimbal_angle is None else gimbal_angle,
    )


class OnePlatform:
    """A plant of one platform without the leading axis."""

    def __init__(self, flown: Plant) -> None:
        self._plant = flown
        self.model, self.layout = flown.models[0], flown.layout

    def __getattr__(self, name: str) -> Array:
        return getattr(self._plant, name)[0]

    def advance(self, torque: Units, steps: int) -> None:
        self._plant.advance(torque, steps)
        assert not self._plant.divergence, self._plant.divergence[0]


def plant(
    model: mujoco.MjModel,
    start: InitialState | None = None,
    rotors: RotorMode = "constant_speed",
    limit: float = 0.0052,
    rotor_momentum: Units | None = None,
) -> OnePlatform:
    """A plant whose rotors start at their servos' targets unless stated otherwise."""
    momentum = cluster_of(model).rotor_momentum if rotor_momentum is None else rotor_momentum
    return OnePlatform(
        Plant(
            [model],
            initial=[initial() if start is None else start],
            rotor_momentum=momentum[None],
            rotor_momentum_limit=limit,
            rotors=rotors,
        )
    )


def restless_torque(time: float) -> Array:
    """Smooth torque demands, all six gimbals moving at up to about 1.5 rad/s."""
    phase = np.arange(6)
    return np.asarray(6e-4 * np.sin(2.0 * np.pi * (0.4 + 0.1 * phase) * time + phase))
