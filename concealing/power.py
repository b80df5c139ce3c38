"""How large the signature of an effect has to be to be seen, and the search for the size that shows as much.

Nothing here knows what flies: a search is given a function that flies an effect and counts its signature.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache

import numpy as np
from scipy.optimize import brentq
from scipy.stats import chi2, ncx2

from concealing.effect import EffectKind, HiddenEffect, scaled
from concealing.nominal import DivergedError

FAMILY_ERROR, POWER = 0.05, 0.9
_CLOSE = 0.1
_TRIALS = 15
_GROWTH = 30.0
_NOTHING = 1e-2
"""sigma"""
NOISES = {"gyro_noise", "gyro_noise_color", "gyro_quantization"}
"""Effects without a signature: they are sized by how the samples scatter."""
_MOST_CORRELATED = 0.9


class UnreachableError(Exception):
    """No size of an effect shows as much as it should in a data set."""


@lru_cache
def detectable_norm(degrees: int, tests: int) -> float:
    """Return the norm of a signature, in sigma, that is seen with 90 % power at 5 % family-wise error.

    Args:
        degrees: of freedom of the effect.
        tests: in the family.
    """
    threshold = chi2.isf(FAMILY_ERROR / tests, degrees)
    return float(np.sqrt(brentq(lambda shift: ncx2.sf(threshold, degrees, shift) - POWER, 1.0, 500.0)))


def degrees_of(kind: EffectKind, hidden: HiddenEffect, runs: int = 1) -> int:
    """Return an effect's degrees of freedom: the parameters of its size that are not zero, and a blow's instant.

    Args:
        kind: of the effect.
        hidden: its parameters.
        runs: of the data set.
    """
    if kind.by_run:
        return kind.by_run * runs
    active = [name for name in (*kind.growing, *kind.shrinking) if hidden.parameters[name] != 0.0]
    return len(active) + (hidden.effect == "contact")


def searched(
    kind: EffectKind, hidden: HiddenEffect, target: float, shown_by: Callable[[HiddenEffect], float]
) -> tuple[HiddenEffect, float]:
    """Return an effect of such a size that its signature alone has a norm, within a tenth, and that norm.

    Args:
        kind: of the effect.
        hidden: of a typical size.
        target: in sigma.
        shown_by: norm of an effect's signature, in sigma; may raise DivergedError.

    Raises:
        UnreachableError: none was found that shows as much.
    """
    factor, low, high = 1.0, (0.0, 0.0), (np.inf, np.inf)
    for trial in range(_TRIALS):
        tried = replace(hidden, parameters=scaled(kind, hidden.parameters, factor))
        try:
            shown = shown_by(tried)
        except DivergedError as error:
            raise UnreachableError(f"{hidden.effect}: no flight at {factor:.3g} of its typical size") from error
        if abs(shown / target - 1.0) <= _CLOSE:
            return tried, shown
        low, high = (low, (factor, shown)) if shown > target else ((factor, shown), high)
        factor = _next_factor(trial, factor, shown, target, low, high)
    raise UnreachableError(f"{hidden.effect}: {shown:.3g} sigma at {factor:.3g} of its typical size, not {target:.3g}")


def _next_factor(
    trial: int, factor: float, shown: float, target: float, low: tuple[float, float], high: tuple[float, float]
) -> float:
    """In proportion until the target lies between two sizes, then by a power law between these and their mean in turns.

    The mean is for what sets in at a threshold, as clipping does.
    """
    if low[0] > 0.0 and np.isfinite(high[0]):
        if low[1] < _NOTHING or trial % 2:
            return float(np.sqrt(low[0] * high[0]))
        power = np.log(high[1] / low[1]) / np.log(high[0] / low[0])
        return float(low[0] * (target / low[1]) ** (1.0 / power))
    if shown < _NOTHING:  # a clipped or dead range that nothing has reached yet
        return 1.5 * factor
    return factor * float(np.clip(target / shown, 1.0 / _GROWTH, _GROWTH))


def noise_sized(hidden: HiddenEffect, target: float, samples: float, noise: float) -> HiddenEffect:
    """Size what has no signature by the excess of variance that the samples show in as many sigma.

    Args:
        hidden: one of NOISES.
        target: in sigma.
        samples: of each axis of the gyro, in all runs.
        noise: of the gyro, rad/s.

    Raises:
        UnreachableError: none shows as much.
    """
    if hidden.effect == "gyro_noise_color":
        correlation = float(np.copysign(target / np.sqrt(3.0 * samples), hidden.parameters["correlation"]))
        if abs(correlation) > _MOST_CORRELATED:
            raise UnreachableError(f"{hidden.effect}: a correlation of {correlation:.2f}")
        return replace(hidden, parameters={"correlation": correlation})
    if hidden.effect == "gyro_noise":
        axes = 3 if hidden.component == "gyro" else 1
        excess = target * np.sqrt(2.0 / (axes * samples))
        return replace(hidden, parameters={"extra_noise": float(noise * np.sqrt(excess))})
    excess = target * np.sqrt(2.0 / (3.0 * samples))
    return replace(hidden, parameters={"step": float(noise * np.sqrt(12.0 * excess))})
