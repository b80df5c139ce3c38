"""p-values of sums of squares, and the evidence that a p-value allows."""

from __future__ import annotations

from math import exp, inf, isinf, log, log1p

from scipy.special import chdtr, chdtrc, chdtri, fdtr, fdtrc, fdtri


def log_p_value(squares: float, freedom: float, noise_freedom: float) -> float:
    """Return the logarithm of the probability of a sum of squared whitened numbers as large, if they are noise alone.

    Args:
        squares: the sum.
        freedom: its degrees of freedom.
        noise_freedom: those of the noise's variance; infinite where it is stated.
    """
    if isinf(noise_freedom):
        below, above = chdtr(freedom, squares), chdtrc(freedom, squares)
    else:
        ratio = squares / freedom
        below, above = fdtr(freedom, noise_freedom, ratio), fdtrc(freedom, noise_freedom, ratio)
    if below < above:
        return log1p(-below)
    return log(above) if above > 0.0 else -inf


def p_value(squares: float, freedom: float, noise_freedom: float) -> float:
    """Return the probability itself; arguments as in `log_p_value`."""
    return exp(log_p_value(squares, freedom, noise_freedom))


def exceeded(chance: float, freedom: float, noise_freedom: float) -> float:
    """Return the squares that noise exceeds with a chance: `p_value` the other way round."""
    if isinf(noise_freedom):
        return float(chdtri(freedom, chance))
    return float(freedom * fdtri(freedom, noise_freedom, 1.0 - chance))


def largest_log_odds(p_value: float) -> float:
    """Return twice the logarithm of the largest odds against the null hypothesis that a p-value allows.

    1 / (-e p ln p) for p < 1/e, and even odds above. Source: Sellke, Bayarri and Berger, "Calibration of p values for
    testing precise null hypotheses", The American Statistician (2001).

    Args:
        p_value: above 0.
    """
    return -2.0 * (1.0 + log(p_value) + log(-log(p_value))) if p_value < exp(-1.0) else 0.0
