"""Which combinations of inertia and alignments a record determines, and in words those that it leaves open."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf

import numpy as np
from scipy.linalg import null_space

from testbed.arrays import Array, Flags, Regressor, Theta
from testbed.dynamics.inertia import PARAMETER_NAMES
from testbed.estimation.alignment_model import KINDS
from testbed.estimation.identifiability import inertia_size, named_direction, sparse_basis

KNOWN_ANYWAY = 0.1
"""Shares of the inertia, rad, or shares of a momentum. What is drawn and weighed before a flight is better than that:
a direction which a record determines no better stays open."""
NO_PART = 0.02
"""A parameter with a smaller component in an open direction has no part in it."""
_MINOR_TERM = 0.3
"""Terms of a direction that are smaller than this share of the largest are counted, not named."""
COMMON_SCALE = "a common scale of J and all rotor momenta"
CONVENTION = "the mean momentum scale is taken to be 0, so that J and each unit's scale are relative to it"


def parameter_names(units: int) -> tuple[str, ...]:
    """Return the names of the inertia's and of so many units' alignments, in order; P = 6 + 4 M of them."""
    return (*PARAMETER_NAMES, *(f"{kind} of cmg{unit}" for kind in KINDS for unit in range(1, units + 1)))


def parameter_units(units: int) -> tuple[str, ...]:
    """Return the physical unit of each of these parameters."""
    return (*["kg·m²"] * 6, *["rad"] * 3 * units, *["1"] * units)


def unit_count(parameters: int) -> int:
    """Return how many units so many parameters are of."""
    return (parameters - len(PARAMETER_NAMES)) // len(KINDS)


@dataclass(frozen=True, kw_only=True)
class OpenDirection:
    """A combination of parameters that a record does not determine.

    Attributes:
        direction: unit vector in the scaled parameters, shape (P,).
        name: in words.
        std: standard deviation along it if nothing else were unknown, in shares and rad; infinite where the record
            shows nothing of it.
    """

    direction: Array
    name: str
    std: float


@dataclass(frozen=True, kw_only=True)
class Observability:
    """Observability of the scaled parameters: θ in shares of the mean moment, angles in rad, momentum scales.

    Attributes:
        scale: of the P parameters, SI per scaled unit.
        common_scale: the one direction that no record identifies; the convention fixes it.
        others: further directions that this record does not identify; the parameters are not moved along them.
        basis: orthonormal directions in which the parameters are estimated, shape (P, r).
    """

    scale: Array
    common_scale: OpenDirection
    others: tuple[OpenDirection, ...]
    basis: Array

    @property
    def determined(self) -> Flags:
        """Which parameters the record determines, given the convention, shape (P,)."""
        parts = np.array([np.abs(each.direction) for each in self.others]).reshape(-1, len(self.scale))
        return np.asarray(parts.max(axis=0, initial=0.0) < NO_PART)


def observability(columns: Regressor, gyro_noise: float, theta: Theta, working: Flags) -> Observability:
    """Return which directions of the parameters a record determines, by the sensitivities of its rates.

    Args:
        columns: ∂ω/∂(θ, alignments), the unknown momentum's share taken out, shape (3N, P), SI.
        gyro_noise: σ, rad/s.
        theta: where they were taken, kg·m².
        working: which units' rotors carry momentum, shape (M,).
    """
    scale = np.concatenate([np.full(6, inertia_size(theta)), np.ones(len(KINDS) * len(working))])
    scaled = columns * scale
    _, strength, directions = np.linalg.svd(scaled, full_matrices=False)
    common = _common_scale(theta / scale[:6], working)
    others = _beside(directions[strength * KNOWN_ANYWAY < gyro_noise], common)

    def described(direction: Array, name: str) -> OpenDirection:
        seen = float(np.linalg.norm(scaled @ direction))
        return OpenDirection(direction=direction, name=name, std=gyro_noise / seen if seen > 0.0 else inf)

    return Observability(
        scale=scale,
        common_scale=described(common, COMMON_SCALE),
        others=tuple(described(row / np.linalg.norm(row), _named(row)) for row in sparse_basis(others)),
        basis=null_space(np.vstack([_mean_scale(working), others])),
    )


def _common_scale(theta: Theta, working: Flags) -> Array:
    """Return the direction in which θ and all rotor momenta grow alike, a common scale, as a unit vector."""
    direction = np.concatenate([theta, np.zeros((len(KINDS) - 1) * len(working)), working])
    return np.asarray(direction / np.linalg.norm(direction))


def _mean_scale(working: Flags) -> Array:
    """Return the weights of the parameters in the mean momentum scale, shape (P,)."""
    return np.concatenate([np.zeros(len(PARAMETER_NAMES) + (len(KINDS) - 1) * len(working)), working / working.sum()])


def _beside(directions: Array, common: Array) -> Array:
    """Return an orthonormal basis of what open directions span beside the common scale."""
    beside = directions - np.outer(directions @ common, common)
    _, size, basis = np.linalg.svd(beside, full_matrices=False)
    return np.asarray(basis[size > 0.5])  # where one of them was nearly the common scale itself, little is left of it


def _named(direction: Array) -> str:
    """Return a combination of parameters as text; one of many parameters by its larger terms."""
    share = np.abs(direction) / np.abs(direction).max()
    text = named_direction(np.where(share >= _MINOR_TERM, direction, 0.0), parameter_names(unit_count(len(direction))))
    minor = int(((share >= NO_PART) & (share < _MINOR_TERM)).sum())
    return f"{text}, and less of {minor} others" if minor else text
