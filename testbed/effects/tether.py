"""A cable holds the platform: a torque back to the attitude of release, and against the rate."""

from __future__ import annotations

from typing import final

import numpy as np
from typing_extensions import override

from testbed.arrays import Array
from testbed.effects.contract import Effect, Extension, Parameter
from testbed.plant.added_torques import Tether as Addition
from testbed.prediction.hooks import Hooks, Instant, column
from testbed.scenario.scenario import Scenario

_NEARLY_ZERO = 1e-4
"""tan²(φ/2) below which a series replaces the arc: its first term left out is 1e-17."""


class _Cable(Hooks):
    needs_attitude = True

    @override
    def torque(self, value: Array, at: Instant) -> Array:
        return np.asarray(-column(value, 0) * rotation_vector(at.attitude) - column(value, 1) * at.body_rate)


def rotation_vector(rotation: Array) -> Array:
    """Return θ of rotation matrices by less than half a turn, shape (..., 3), rad, analytic in their entries.

    With t = tan(φ/2), t² = |v|²/(1 + cos φ)² and v = n sin φ, θ = v φ / sin φ = v (1 + t²) arctan(t) / t.
    """
    skew = rotation - np.swapaxes(rotation, -1, -2)
    sine = 0.5 * np.stack([skew[..., 2, 1], skew[..., 0, 2], skew[..., 1, 0]], axis=-1)
    cosine = 0.5 * (np.trace(rotation, axis1=-2, axis2=-1) - 1.0)
    square = (sine * sine).sum(axis=-1) / (1.0 + cosine) ** 2
    small = square.real < _NEARLY_ZERO
    tangent = np.sqrt(np.where(small, 1.0, square))
    series = 1.0 - square * (1.0 / 3.0 - square * (1.0 / 5.0 - square / 7.0))
    arc = np.where(small, series, np.arctan(tangent) / tangent)
    return np.asarray(sine * ((1.0 + square) * arc)[..., None])


@final
class Tether(Effect):
    """T = -K θ - C ω, θ the rotation vector from each run's first sample."""

    id = "tether"
    components = ("platform",)
    parameters = (
        Parameter(name="stiffness_N_m_rad", unit="N·m/rad", typical=2e-4, lower=0.0),
        Parameter(name="damping_N_m_s_rad", unit="N·m·s/rad", typical=5e-5, lower=0.0),
    )
    sentence = (
        "A cable or cord turns the platform back to the attitude of its release and damps it; where its stiffness is "
        "zero within its interval, this is a drag that is alike about all axes."
    )
    look_alikes = ("viscous_drag", "inertial_torque", "dry_friction")
    confirm = "Release it at rest and turned away from where the cable is slack: only a tether turns it back."

    @override
    def hooks(self, component: str) -> Hooks:
        return _Cable()

    @override
    def extension(self, component: str, values: Array, scenario: Scenario) -> Extension:
        slack = np.array(scenario.initial.attitude_quat_NB)
        stiffness, damping = (np.full(3, value) for value in values)
        return Extension(platform=(Addition(stiffness=stiffness, damping=damping, quat_NB=slack),))
