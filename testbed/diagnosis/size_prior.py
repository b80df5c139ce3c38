"""Prior of an effect's size, and the evidence of a likelihood under it."""

from __future__ import annotations

from dataclasses import dataclass
from math import log

import numpy as np
from scipy.special import log_ndtr

from testbed.arrays import Array, Flags
from testbed.diagnosis.settings import SETTINGS
from testbed.effects.contract import Effect

_NODES = np.linspace(-4.0, 4.0, 129)
"""Standard deviations of the logarithm of the size at which the integrals over it are taken, evenly: 3e-5 of a normal
prior lie beyond, and with half as many nodes the evidence of 71 sets changes by less than 0.01."""
SIZE_WEIGHTS = np.exp(-0.5 * _NODES**2) / np.exp(-0.5 * _NODES**2).sum()
"""Of the nodes in a mean over the normal distribution."""
SIZE_FACTORS = np.exp(log(10.0) * SETTINGS.size_decades * _NODES)
"""Common factor of all parameters' sizes at the nodes, its median 1."""


@dataclass(frozen=True, kw_only=True, eq=False)
class SizePrior:
    """Prior of an effect's parameters: normal about its absence, with a common factor of all of them log-normal.

    The factor has the median 1 and the standard deviation `size_decades`; the parameters' standard deviations are their
    typical sizes times the factor. Those that cannot be negative have half of the normal distribution.

    Attributes:
        typical: shape (K,).
        positive: which cannot be negative, shape (K,).
        searched: which are fixed by the start of a scan, shape (K,).
    """

    typical: Array
    positive: Flags
    searched: Flags

    @staticmethod
    def of(effect: Effect, start: Array, moment: float) -> SizePrior:
        """Return the prior of an effect.

        Args:
            effect: which.
            start: of the search, shape (K,); a mode's direction does not turn round against it.
            moment: mean moment of inertia of the platform, kg·m².
        """
        absent = np.array([each.absent for each in effect.parameters])
        return SizePrior(
            typical=np.array([each.typical_on(moment) for each in effect.parameters]),
            positive=np.asarray(effect.reach(start)[0] >= absent),
            searched=np.array([each.scanned for each in effect.parameters]),
        )

    def evidence(self, information: Array, slope: Array) -> float:
        """Return twice the logarithm of the likelihood ratio, effects of this prior's sizes against none.

        Of a log-likelihood b·θ - θ·N θ / 2 the Gaussian integral over θ is exact, and so is that over half of it for
        one parameter; of several that cannot be negative each is taken by itself. That over the factor is a sum.

        Args:
            information: N, shape (K, K).
            slope: b, shape (K,).
        """
        free = ~self.searched
        scale, positive = self.typical[free], self.positive[free]
        within, own = information[np.ix_(free, free)], slope[free]
        if not positive.any():
            return float(evidences(scale, within, own))
        strength, axes, along = _along_axes(scale, within, own)
        square = SIZE_FACTORS[:, None] ** 2
        spread = square / (1.0 + square * np.maximum(strength, 0.0))
        mean, variance = (spread * along) @ axes.T, spread @ (axes.T**2)
        halves = log_ndtr(mean[:, positive] / np.sqrt(variance[:, positive])) + log(2.0)
        return float(_averaged(_log_ratios(along, strength) + halves.sum(axis=1)))

    def evidence_of_fit(self, gain: float, values: Array, information: Array, slope: Array) -> float:
        """Return the same of an effect that was fitted: Laplace's method about the fitted size.

        Args:
            gain: reduction of χ² by the fit.
            values: fitted, from where the effect is absent, shape (K,).
            information: there, shape (K, K).
            slope: of the log-likelihood there, shape (K,); it counts where the effect is absent because no value below
                is possible.
        """
        part = np.where(self.searched, 0.0, values)
        below = np.where(self.positive & (part <= 0.0), np.minimum(slope, 0.0), 0.0)
        at_absence = gain - float(part @ information @ part)
        return at_absence + self.evidence(information, below + information @ part)


def evidences(typical: Array, information: Array, slope: Array) -> Array:
    """Return `SizePrior.evidence` of effects whose parameters may have either sign, many at once, shape (...).

    Args:
        typical: sizes of their parameters, shape (..., K).
        information: N, shape (..., K, K).
        slope: b, shape (..., K).
    """
    strength, _, along = _along_axes(typical, information, slope)
    return _averaged(_log_ratios(along, strength))


def _along_axes(typical: Array, information: Array, slope: Array) -> tuple[Array, Array, Array]:
    """Return eigenvalues and axes of an information in typical sizes, and the slope along them; as `evidences`."""
    strength, axes = np.linalg.eigh(information * typical[..., :, None] * typical[..., None, :])
    return strength, axes, (np.swapaxes(axes, -1, -2) @ (typical * slope)[..., None])[..., 0]


def _log_ratios(along: Array, strength: Array) -> Array:
    """Return the logarithm of the likelihood ratio at each common factor of the sizes, shape (..., factors).

    Args:
        along: slope by parameters in typical sizes, along the axes of the information, shape (..., K).
        strength: of the information along them, shape (..., K).
    """
    square = SIZE_FACTORS[:, None] ** 2
    grown = square * np.maximum(strength, 0.0)[..., None, :]
    return np.asarray(0.5 * ((along**2)[..., None, :] * square / (1.0 + grown) - np.log1p(grown)).sum(axis=-1))


def evidence_of_power(square: float, freedom: int, typical_square: float) -> float:
    """Return the evidence of d numbers of one size, from what they explain: `SizePrior`, all directions alike.

    Args:
        square: χ² that they explain.
        freedom: d.
        typical_square: χ² that they would explain at their typical size.
    """
    if freedom == 0:
        return 0.0
    power = SIZE_FACTORS**2 * typical_square / freedom
    return float(_averaged(0.5 * square * power / (1.0 + power) - 0.5 * freedom * np.log1p(power)))


def _averaged(log_ratios: Array) -> Array:
    """Return twice the logarithm of the mean of likelihood ratios over the prior of the common factor, shape (...)."""
    most = log_ratios.max(axis=-1)
    return np.asarray(2.0 * (most + np.log(np.exp(log_ratios - most[..., None]) @ SIZE_WEIGHTS)))
