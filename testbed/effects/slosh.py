"""A loose mass, such as propellant in a tank: on a spring and damper in every direction."""

from __future__ import annotations

from typing import final

import numpy as np
from typing_extensions import override

from testbed.arrays import Array
from testbed.effects.contract import Effect, Extension, Parameter, Quantity
from testbed.effects.direction import beyond_speck, mode_parameters, scanned, size_and_direction, size_std
from testbed.plant.added_parts import SprungMass
from testbed.prediction.grid import Grid
from testbed.prediction.hooks import Hooks, Instant, column
from testbed.prediction.kernels import cross
from testbed.scenario.scenario import Scenario

ARM = 0.08
"""m, from the centre of the rest to the mass. Only mass times its square shows: another arm is another mass."""
_SCANNED = (0.3, 3.0)
"""Hz: from the slowest that turns once in a run of 3 s to an octave beyond the 0.3 to 1.5 Hz of the blind sets."""
_SCANNED_MASS = 0.05
"""kg: the typical size, of which a speck of 1e-9 is started from; where the search ends does not depend on it."""
_SCANNED_DAMPING = 0.15
"""A tank's mode is damped by 0.05 to 0.3: of 28 the refit from here lost none."""


class _Loose(Hooks):
    """States: displacement ξ, m, and relative velocity in N, u = ξ̇ + ω × ρ, m/s, ρ = r + ξ; it holds m ρ × u."""

    states = 6
    quadratic = True

    @override
    def initial_state(self, value: Array, body_rate: Array) -> Array:
        """At rest in the body."""
        moving = cross(body_rate, np.broadcast_to(_arm(value), body_rate.shape[:1] + _arm(value).shape))
        return np.concatenate([np.zeros_like(moving), moving], axis=-1)

    @override
    def hidden_inertia(self, value: Array) -> Array:
        """Return m (r² 1 - r rᵀ)."""
        mass, place = size_and_direction(value[:, 2:])
        outer = place[:, :, None] * place[:, None, :]
        return np.asarray(ARM**2 * mass[..., None] * (np.eye(3) - outer))

    @override
    def hidden_momentum(self, value: Array, state: Array) -> Array:
        mass, _ = size_and_direction(value[:, 2:])
        return np.asarray(mass * cross(_arm(value) + state[..., :3], state[..., 3:]))

    @override
    def state_rate(self, value: Array, at: Instant) -> Array:
        """u̇ = -ωn² ξ - 2 ζ ωn ξ̇ - ω × u in body axes: the spring is all that acts between the two."""
        circular = 2.0 * np.pi * column(value, 0)
        displacement, moving = at.state[..., :3], at.state[..., 3:]
        speed = moving - cross(at.body_rate, _arm(value) + displacement)
        spring = circular * (circular * displacement + 2.0 * column(value, 1) * speed)
        return np.concatenate([speed, -spring - cross(at.body_rate, moving)], axis=-1)


def _arm(value: Array) -> Array:
    return ARM * size_and_direction(value[:, 2:])[1]


@final
class Slosh(Effect):
    """A reduced mass m (M - m)/M at ARM from the rest's centre; m times the direction to it are the parameters."""

    id = "slosh"
    components = ("platform",)
    parameters = (
        *mode_parameters(1.0, (0.2, 5.0), 0.05),
        *(
            Parameter(name=f"mass_{axis}_kg", unit="kg", typical=typical, lower=-0.9, upper=0.9)
            for axis, typical in zip("xyz", (0.04, 0.03, -0.05), strict=True)
        ),
    )
    sentence = (
        "A loose mass moves inside the platform, as propellant in a tank does; the mass is that which, at "
        f"{ARM} m from the centre of mass of the rest, would do the same."
    )
    look_alikes = ("flexible_appendage",)
    confirm = (
        "The same maneuver at two rates: a loose mass moves outward with the square of the rate, a hinge does not."
    )

    @override
    def hooks(self, component: str) -> Hooks:
        return _Loose()

    @override
    def starts(self, component: str, grid: Grid) -> Array:
        return scanned(grid, *_SCANNED, _SCANNED_DAMPING, _SCANNED_MASS)

    @override
    def reach(self, start: Array) -> tuple[Array, Array]:
        return beyond_speck(start, super().reach(start))

    @override
    def quantities(self, values: Array, std: Array) -> tuple[Quantity, ...]:
        """The mass instead of its vector."""
        size, place = size_and_direction(values[2:])
        mass = Quantity(name="mass_kg", unit="kg", value=float(size[0]), std=size_std(place, std[2:]))
        return (*super().quantities(values, std)[:2], mass)

    @override
    def extension(self, component: str, values: Array, scenario: Scenario) -> Extension:
        size, place = size_and_direction(values[2:])
        mass, circular = float(size[0]), 2.0 * np.pi * float(values[0])
        if mass == 0.0:
            return Extension()
        loose = SprungMass(
            reduced_mass=mass,
            arm_B=ARM * place,
            stiffness=mass * circular**2,
            damping=2.0 * float(values[1]) * mass * circular,
        )
        return Extension(platform=(loose,))
