"""The unit in which an inertia is shown: kg·m² of a satellite of a hundred kilograms, thousandths of a CubeSat's."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from testbed.arrays import Array, Theta
from testbed.dynamics.inertia import PARAMETER_NAMES


@dataclass(frozen=True, kw_only=True)
class InertiaUnit:
    """A unit of inertia.

    Attributes:
        text: what stands behind a number in it.
        per_SI: numbers in it for one kg·m².
    """

    text: str
    per_SI: float

    def shown(self, value: float, decimals: int) -> str:
        """Return a value in kg·m² as a number in this unit; zero has no sign."""
        return f"{self.per_SI * value:z.{decimals}f}"


MICRO = InertiaUnit(text="1e-6 kg·m²", per_SI=1e6)
MILLI = InertiaUnit(text="1e-3 kg·m²", per_SI=1e3)
WHOLE = InertiaUnit(text="kg·m²", per_SI=1.0)
_LEAST_MILLI, _LEAST_WHOLE = 1e-4, 1.0
"""kg·m², of the largest parameter, from which thousandths and whole units are used.

Source: chosen: so that of nearly all platforms it has one to three digits before its point."""


def inertia_unit(theta: Theta | Sequence[float]) -> InertiaUnit:
    """Return the unit in which an inertia is shown, and all that is compared with it.

    Args:
        theta: of a platform that is known, such as the nominal one, shape (6,), kg·m².
    """
    largest = float(np.abs(theta).max())
    return MICRO if largest < _LEAST_MILLI else MILLI if largest < _LEAST_WHOLE else WHOLE


def inertia_words(theta: Theta, std: Array) -> str:
    """Return inertia parameters with their standard deviations in a line, such as `J11 = 21.98 ± 0.02, ...`.

    Args:
        theta: shape (6,), kg·m².
        std: likewise.
    """
    unit = inertia_unit(theta)
    pairs = zip(PARAMETER_NAMES, unit.per_SI * theta, unit.per_SI * std, strict=True)
    return ", ".join(f"{name} = {value:z.4g} ± {error:.2g}" for name, value, error in pairs) + f" in {unit.text}"
