"""An appendage that is not rigid: one mode of it, as a disc that turns about its axis on a spring and damper."""

from __future__ import annotations

from typing import final

import numpy as np
from typing_extensions import override

from testbed.arrays import Array
from testbed.effects.contract import Effect, Extension, Parameter, Quantity
from testbed.effects.direction import beyond_speck, mode_parameters, scanned, size_and_direction, size_std
from testbed.plant.added_parts import HingedMode
from testbed.prediction.algebra import dot
from testbed.prediction.grid import Grid
from testbed.prediction.hooks import Hooks, Instant, column
from testbed.scenario.scenario import Scenario

_SCANNED = (0.3, 5.0)
"""Hz: half an octave and more beyond the 0.8 to 4 Hz of the blind sets on the slow side, a quarter on the fast one,
where a gyro at 16 Hz shows little; `scanned` leaves out what does not turn once in the longest run."""
_SCANNED_INERTIA = 5e-4
"""kg·m²: the typical size, of which a speck of 1e-9 is started from; where the search ends does not depend on it."""
_SCANNED_DAMPING = 0.05
"""Of 28 modes damped by 0.005 to 0.05, refits that began at 0.15 lost 6 to another minimum; those from here 4."""


class _Mode(Hooks):
    """States: deflection η, rad, and rate in N about the axis, p = η̇ + a·ω, rad/s; the mode holds I a p."""

    states = 2
    quadratic = True

    @override
    def initial_state(self, value: Array, body_rate: Array) -> Array:
        """At rest in the body."""
        along = dot(size_and_direction(value[:, 2:])[1], body_rate)[..., 0]
        return np.stack([np.zeros_like(along), along], axis=-1)

    @override
    def hidden_inertia(self, value: Array) -> Array:
        return np.asarray(value[:, 2:, None] * size_and_direction(value[:, 2:])[1][:, None, :])

    @override
    def hidden_momentum(self, value: Array, state: Array) -> Array:
        return np.asarray(value[:, 2:] * state[..., 1:])

    @override
    def state_rate(self, value: Array, at: Instant) -> Array:
        """ṗ = -ωn² η - 2 ζ ωn η̇."""
        circular = 2.0 * np.pi * column(value, 0)
        axis_B = size_and_direction(value[:, 2:])[1]
        speed = at.state[..., 1:] - dot(axis_B, at.body_rate)
        change = -circular * (circular * at.state[..., :1] + 2.0 * column(value, 1) * speed)
        return np.concatenate([speed, change], axis=-1)


@final
class FlexibleAppendage(Effect):
    """The inertia I a aᵀ hangs on a hinge with its own frequency and damping; v = I a are the parameters."""

    id = "flexible_appendage"
    components = ("platform",)
    parameters = (
        *mode_parameters(2.0, (0.2, 6.0), 0.02),
        *(
            Parameter(name=f"inertia_{axis}_kg_m2", unit="kg·m²", typical=typical, lower=-0.02, upper=0.02)
            for axis, typical in zip("xyz", (4e-4, 2e-4, 3e-4), strict=True)
        ),
    )
    sentence = "A part of the platform is not rigid: it swings about an axis at its own frequency."
    look_alikes = ("slosh",)
    confirm = "A sudden stop: the platform then rings at the mode's frequency, with all gimbals at rest."

    @override
    def hooks(self, component: str) -> Hooks:
        return _Mode()

    @override
    def starts(self, component: str, grid: Grid) -> Array:
        return scanned(grid, *_SCANNED, _SCANNED_DAMPING, _SCANNED_INERTIA)

    @override
    def reach(self, start: Array) -> tuple[Array, Array]:
        return beyond_speck(start, super().reach(start))

    @override
    def quantities(self, values: Array, std: Array) -> tuple[Quantity, ...]:
        """Size and direction instead of v."""
        size, axis_B = size_and_direction(values[2:])
        inertia = Quantity(name="inertia_kg_m2", unit="kg·m²", value=float(size[0]), std=size_std(axis_B, std[2:]))
        return (*super().quantities(values, std)[:2], inertia, *_axis(axis_B, std[2:], float(size[0])))

    @override
    def extension(self, component: str, values: Array, scenario: Scenario) -> Extension:
        size, axis_B = size_and_direction(values[2:])
        inertia, circular = float(size[0]), 2.0 * np.pi * float(values[0])
        if inertia == 0.0:
            return Extension()
        mode = HingedMode(
            inertia=inertia,
            axis_B=axis_B,
            stiffness=inertia * circular**2,
            damping=2.0 * float(values[1]) * inertia * circular,
        )
        return Extension(platform=(mode,))


def _axis(axis_B: Array, std: Array, size: float) -> tuple[Quantity, ...]:
    """What an error of v across the axis turns it by; along it, none. Components that no sample shows are left out."""
    across = std * np.sqrt(1.0 - axis_B**2) / (size or np.inf)
    return tuple(
        Quantity(name=f"axis_{name}", unit="1", value=float(value), std=float(error))
        for name, value, error in zip("xyz", axis_B, across, strict=True)
        if np.isfinite(error)
    )
