"""E-values of effects in linear Gaussian records, at which one may look after every flight.

Of n flights the whitened samples are y = X β + Z φ + σ ε: X has the derivatives by J and by every flight's own initial
rate, Z those by an effect's parameters, ε is white and standard normal, and σ is 1 where the noise is as stated. The
null is composite: φ = 0 with any β and any level σ. The e-value is the likelihood ratio of what neither β nor σ changes
(the maximal invariant: the direction of the residual that X cannot explain), φ having a prior. Its distribution under
the null is one and the same for every β and σ, so that its mean is 1 under all of them, and the values of 1, 2, 3, ...
flights are a nonnegative martingale: each is the one before times the predictive density of the new flight by the past
flights with the effect, over that without it. Whichever rule stops the campaign, P(it ever exceeds 1/α) ≤ α (Ville's
inequality).

Universal inference, with β at its maximum in the denominator, holds for any model, and pays for the three initial rates
that each flight brings along; here they cost nothing.

Source: Ramdas, Grünwald, Vovk, Shafer, "Game-theoretic statistics and safe anytime-valid inference", Statistical
Science (2023); Pérez-Ortiz, Lardy, de Heide, Grünwald, "E-statistics, group invariance and anytime-valid testing",
Annals of Statistics (2024); Lindon, Ham, Tingley, Bojinov, "Anytime-valid linear models and regression adjusted causal
inference in randomized experiments" (2022); Wasserman, Ramdas, Balakrishnan, "Universal inference", PNAS (2020).
"""

from __future__ import annotations

import numpy as np
from scipy.special import logsumexp

from testbed.arrays import Array
from testbed.diagnosis.size_prior import SIZE_FACTORS, SIZE_WEIGHTS

_MOST = 1.0 - 1e-12
"""Share of the residual's square that an effect may explain: below one by rounding, where it explains all of it."""


def log_e_value(information: Array, slope: Array, square: Array | float, freedom: int, typical: Array) -> Array:
    """Return the natural logarithm of the e-value of an effect against none, shape (...).

    With r the residual that X cannot explain, N = ZᵀPZ, b = ZᵀPr and φ ~ N(0, σ² c² T), T = diag(typical²):

        E = mean over c of |I + c² N T|^(-1/2) (1 - bᵀ(N + T⁻¹/c²)⁻¹ b / |r|²)^(-m/2).

    Args:
        information: N of the effect's parameters, shape (K, K).
        slope: b, shape (..., K).
        square: |r|², shape (...).
        freedom: m, samples less the rank of X.
        typical: standard deviations of the parameters' prior at c = 1, shape (K,); the weights of c are those of a
            diagnosis (`SizePrior`). Any prior gives an e-value; this one makes it the diagnosis's own Bayes factor.
    """
    strength, axes = np.linalg.eigh(information * np.outer(typical, typical))
    strength = np.maximum(strength, 0.0)
    along, factors = (typical * slope) @ axes, SIZE_FACTORS[:, None] ** 2
    spread = factors / (1.0 + factors * strength)
    explained = along**2 @ spread.T / np.asarray(square)[..., None]
    penalty = np.log1p(factors * strength).sum(axis=1)
    ratio = -0.5 * penalty - 0.5 * freedom * np.log1p(-np.minimum(explained, _MOST))
    return np.asarray(logsumexp(ratio, axis=-1, b=SIZE_WEIGHTS))
