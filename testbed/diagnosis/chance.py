"""How likely a sum of squares is by chance, where the noise is known or was itself estimated."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from math import exp, inf, isinf, log

import numpy as np
from scipy.special import logsumexp
from scipy.stats import chi2, f

NOTHING = 5.0
"""How much likelier it is beforehand that nothing is missing than that an effect of the library is."""


def log_chance(squares: float, freedom: float, noise_freedom: float) -> float:
    """Return the logarithm of the probability of a sum of squared whitened numbers as large, if they are noise alone.

    Args:
        squares: the sum.
        freedom: its degrees of freedom.
        noise_freedom: those of the noise's variance; infinite where it is stated.
    """
    if isinf(noise_freedom):
        return float(chi2.logsf(squares, freedom))
    return float(f.logsf(squares / freedom, freedom, noise_freedom))


def chance(squares: float, freedom: float, noise_freedom: float) -> float:
    """Return the probability itself; arguments as in `log_chance`."""
    return exp(log_chance(squares, freedom, noise_freedom))


def scale_evidence(square: float, freedom: int) -> float:
    """Return twice the logarithm of a likelihood ratio, of effects as large as they turn out against none.

    Of a residual whose square along the effect's d directions is S, amplitudes of the variance g noise units make
    S g/(1+g) - d log(1+g), greatest at g = S/d - 1 (a g-prior, its scale by empirical Bayes). It tends to BIC for what
    is plain, and does not exclude what is too small to be seen.

    Args:
        square: S.
        freedom: d.
    """
    return square - freedom - freedom * log(square / freedom) if square > freedom > 0 else 0.0


def mean_over_places(found: float, elsewhere: Sequence[float], places: int) -> float:
    """Return the evidence of an effect that was sought at many places, each as likely beforehand: of their mean odds.

    Args:
        found: twice the logarithm of the odds at the most telling place.
        elsewhere: at other places.
        places: number of all, those included; the rest counts as nothing.
    """
    odds = 0.5 * np.array([found, *elsewhere])
    unseen = log(places - len(odds)) if places > len(odds) else -inf
    return 2.0 * float(logsumexp([*odds, unseen]) - log(places))


def likelier_than_nothing(odds: Iterable[float]) -> bool:
    """Return whether it is likelier that one of several effects is there than that nothing is missing.

    Args:
        odds: twice the logarithm of how much likelier each makes the data, beforehand as likely as nothing.
    """
    return float(logsumexp(0.5 * np.array(list(odds)))) > log(NOTHING)
