"""A torque of constant size against the body rate, about each axis: the bearing of a rig, a cable that rubs."""

from __future__ import annotations

from typing import final

import numpy as np
from typing_extensions import override

from testbed.arrays import Array
from testbed.effects.contract import Effect, Extension, Parameter
from testbed.prediction.hooks import Hooks, Instant
from testbed.scenario.scenario import Scenario

_WIDTH = 0.02
"""rad/s, from which the search for the width begins: a bearing that sticks creeps, at half of its torque by a degree a
second or less. With the width held there, another one of 0.01 rad/s left a gap of 1.9 (wheel rig of
`concealing/rig.py`, 4e-3 N·m on 0.052 kg·m², seeds 101 to 103)."""


class _Dry(Hooks):
    @override
    def torque(self, value: Array, at: Instant) -> Array:
        """T = -τ ω / (ω⁴ + w⁴)^¼: beyond three widths within 0.3 % of τ."""
        rate, width = at.body_rate * at.body_rate, value[:, 3:] * value[:, 3:]
        return np.asarray(-value[:, :3] * at.body_rate / np.sqrt(np.sqrt(rate * rate + width * width)))


@final
class DryFriction(Effect):
    """T = -τ sign(ω) on each body axis, rounded over a width of rates, which without friction shows nowhere."""

    id = "dry_friction"
    components = ("platform",)
    parameters = (
        *(Parameter(name=f"torque_{axis}_N_m", unit="N·m", typical=5e-5, lower=0.0) for axis in "xyz"),
        Parameter(
            name="width_rad_s",
            unit="rad/s",
            typical=_WIDTH,
            lower=2e-3,
            upper=0.3,
            absent=_WIDTH,
            scanned=True,
            plausible=(0.0, 0.2),
            usual_at_bound=True,
        ),
    )
    sentence = "Dry friction opposes the body rate with the same torque at any rate, as a rig's bearing does."
    look_alikes = ("viscous_drag", "quadratic_drag", "tether")
    confirm = "Let it coast: dry friction stops it at a constant deceleration, a drag slows it ever less."
    flies = False  # MuJoCo rubs joints, and a free platform has none

    @override
    def hooks(self, component: str) -> Hooks:
        return _Dry()

    @override
    def extension(self, component: str, values: Array, scenario: Scenario) -> Extension:
        return Extension()
