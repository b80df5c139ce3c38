"""How well a model explains runs: the misfit that is more than noise, and the likelihood of held-out runs.

A torque on the body, or an error of the gyro's readings, of any shape changes the gyro's samples by functions of time
that are slow compared with noise. Of a model's residual r, such functions S, orthonormal, take up u = Sᵀ P r, where P
takes off what the model's own parameters could still do: P = I - J M⁻¹ Jᵀ with M = Jᵀ J. If nothing is missing,
|u|² has the mean tr(Sᵀ P S) and the variance 2 tr((Sᵀ P S)²), exactly; what it has beyond the mean is the squared
length of what is missing, and its root is the misfit.

Of runs that were not fitted, the parameters are as uncertain as the fit has them (`Prior`). For the misfit, its
information stands among the rows of J and r, M = Jᵀ J + Λ, and the same holds. Of the density of the held-out samples,
given the fitted ones, with parameters θ ~ N(θ̂, P) as the fit has them, -2 log p = min over θ of
|r(θ)|² + (θ - θ̂)ᵀ P⁻¹ (θ - θ̂), + log det(P⁻¹ + Gᵀ G) - log det P⁻¹ (Laplace), with the whitened residual r and its
slopes G; initial rates are each run's own. It rewards what carries over to other flights and penalises what was fitted
to noise. The parameters stay those of the fit.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import ceil, sqrt

import numpy as np

from testbed.arrays import Array, Series
from testbed.diagnosis.data import Runs
from testbed.diagnosis.descent import damped, pushing_out
from testbed.diagnosis.fitting import fitted_initial_rates
from testbed.diagnosis.keeping import part
from testbed.diagnosis.model import Fit, evaluated, moved, orthonormal, recurring
from testbed.diagnosis.p_values import exceeded, p_value
from testbed.diagnosis.settings import SETTINGS
from testbed.errors import InputError

BANDWIDTH = 2.0
"""Hz. Functions of any shape up to here take up at least 92 % of every effect of the library that the gyro shows; twice
as many let noise make the misfit larger by a fifth, half as many lose half of a hinged part."""
_UNDETERMINED = 1e-13
"""Share of the normal matrix's largest eigenvalue, its columns scaled alike, below which a direction is not fitted:
just above rounding, as where a fit takes its steps."""


@dataclass(frozen=True, kw_only=True)
class Misfit:
    """What functions of any shape explain of a model's gyro residual.

    Attributes:
        chi_square: |u|².
        expected: its mean if nothing is missing.
        variance: its variance likewise, of a noise that is known.
        noise_freedom: degrees of freedom with which the noise is known; infinite where it is stated.
        gimbals: χ² of the gimbals' own channels, of all that they hold: nobody states their noise; 0 without them.
    """

    chi_square: float
    expected: float
    variance: float
    noise_freedom: float
    gimbals: float

    @property
    def excess(self) -> float:
        """χ² beyond what noise makes, not below zero."""
        return max(self.chi_square - self.expected, 0.0)

    @property
    def sigma(self) -> float:
        """The misfit, in standard deviations."""
        return sqrt(self.excess)

    @property
    def p_value(self) -> float:
        """Chance of as much from noise alone, by the χ² distribution of the same mean and variance (Satterthwaite)."""
        if not self.variance:
            return 1.0
        scale, freedom = self._scaled
        return p_value(self.chi_square / scale, freedom, self.noise_freedom)

    @property
    def beyond_noise(self) -> bool:
        """Whether it is more than noise makes."""
        return self.p_value < SETTINGS.misfit_p_value

    @property
    def noise_limit(self) -> float:
        """The misfit, in standard deviations, that noise exceeds with the chance `misfit_p_value`."""
        if not self.variance:
            return 0.0
        scale, freedom = self._scaled
        return sqrt(max(scale * exceeded(SETTINGS.misfit_p_value, freedom, self.noise_freedom) - self.expected, 0.0))

    @property
    def std_of_excess(self) -> float:
        """Standard deviation of the excess, as noise scatters it about what is missing."""
        return sqrt(self.variance + 4.0 * self.excess)

    @property
    def _scaled(self) -> tuple[float, float]:
        """Factor and degrees of freedom of the χ² that has this mean and variance."""
        return 0.5 * self.variance / self.expected, 2.0 * self.expected**2 / self.variance


@dataclass(frozen=True, kw_only=True)
class Explained:
    """How much of a misfit goes with what was added to the model.

    Attributes:
        share: of the excess χ², from 0 to 1.
        std: of it, from the noise of the remaining residual.
    """

    share: float
    std: float


def explained(before: Misfit | None, after: Misfit | None) -> Explained | None:
    """Return the share of a misfit that is gone; None where it was no more than noise before.

    Args:
        before: what the model left without what was added; None where there is none.
        after: its misfit with it.
    """
    if before is None or after is None or not before.beyond_noise:
        return None
    left = after.excess / before.excess
    return Explained(share=max(1.0 - left, 0.0), std=after.std_of_excess / before.excess)


def misfit_of(runs: Runs, fit: Fit) -> Misfit:
    """Return the misfit of a model to runs that it was fitted to.

    Args:
        runs: that were fitted.
        fit: of the model to them; the columns of its Jacobian are what was free.
    """
    return _misfit(runs, fit, fit.normal, fit.jacobian.T @ fit.residual)


def heldout_misfit_of(heldout: Runs, seen: Fit, prior: Prior) -> Misfit:
    """Return the misfit of a model to runs that were held out.

    Args:
        heldout: that were not fitted.
        seen: the model with the initial rates of these runs.
        prior: what the fit to the others knows of its parameters.
    """
    return _misfit(heldout, seen, prior.normal(seen), prior.slope(seen))


def _misfit(runs: Runs, fit: Fit, normal: Array, slope: Array) -> Misfit:
    shapes = _Shapes(runs=runs)
    scale = 1.0 / np.sqrt(np.maximum(np.diag(normal), np.finfo(float).tiny))
    inverse = np.linalg.pinv(normal * np.outer(scale, scale), rcond=_UNDETERMINED, hermitian=True)
    columns = shapes.taken_up(fit.jacobian * scale)
    left = shapes.taken_up(fit.residual[:, None])[:, 0] - columns @ (inverse @ (slope * scale))
    absorbed = inverse @ (columns.T @ columns)
    mean = len(left) - float(np.trace(absorbed))
    squares = len(left) - 2.0 * float(np.trace(absorbed)) + float((absorbed * absorbed.T).sum())
    inner = fit.residual[runs.samples : runs.numbers]
    return Misfit(
        chi_square=float(left @ left),
        expected=max(mean, 0.0) / (1.0 - 2.0 / runs.noise_freedom),  # the mean of F, where the noise is an estimate
        variance=2.0 * max(squares, 0.0),
        noise_freedom=runs.noise_freedom,
        gimbals=float(inner @ inner),
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class _Shapes:
    """Functions of time up to the bandwidth, of each run and axis of the gyro its own."""

    runs: Runs

    @cached_property
    def _bases(self) -> list[Array]:
        return [_slow(run.gyro_time) for run in self.runs.grid.runs]

    def taken_up(self, columns: Array) -> Array:
        """Return Sᵀ of whitened columns, shape (D, C); rows behind the gyro's are left aside.

        Args:
            columns: shape (samples, C).
        """
        parts = zip(self._bases, self.runs.by_run(columns), self.runs.live, strict=True)
        return np.concatenate(
            [np.einsum("nk,nac->kac", basis, part)[:, live].reshape(-1, part.shape[-1]) for basis, part, live in parts]
        )


def _slow(time: Series) -> Array:
    """Return an orthonormal basis of cosines up to the bandwidth at samples, shape (N, K).

    With half periods in the span, any function is resolved whose values at both ends differ.
    """
    place = (time - time[0]) / np.ptp(time)
    count = min(ceil(2.0 * BANDWIDTH * float(np.ptp(time))) + 1, len(time))
    return orthonormal(np.cos(np.pi * np.outer(place, np.arange(count))))


_UNKNOWN = 1e-9
"""Share of a parameter's own information that its prior has at least, so that its information can be inverted where the
fitted runs say nothing of it. Of 42 fits with one effect (cases 9 and 12 of 14 of seed 90817) 1e-6 changes -2 log p by
0.015 at most, 1e-12 by 1e-5."""
_OWN = 1e-12
"""Share of the largest singular value of the initial rates' normal matrix below which a direction is left out:
rounding; each run's first samples determine all three rates, so that no direction comes near it."""
_ROUNDS = 6
"""Gauss-Newton steps at most towards what suits both the held-out runs and the fit. Two steps suffice to 1e-5 in the
same fits."""
_CONVERGED = 0.05
"""Change of -2 log p after which no further step is taken; a standard error moves it by 1, and 6 are what decides.
With 0.5, -2 log p changes by 1e-5 at most in the same fits, with 1e-3 by 1e-7."""


def log_evidence(heldout: Runs | None, fit: Fit) -> float:
    """Return twice the logarithm of the density of held-out runs, up to what all models share; 0 without such runs.

    Args:
        heldout: runs that were not fitted.
        fit: to other runs.
    """
    if heldout is None:
        return 0.0
    return part(
        "evidence",
        (heldout, [each.key for each in fit.placed], fit.values, fit.normal, fit.residual),
        work=lambda: _log_evidence(heldout, fit),
        to_content=lambda evidence: {"evidence": evidence},
        from_content=lambda content: float(content["evidence"]),
    )


def _log_evidence(heldout: Runs, fit: Fit) -> float:
    prior = Prior.of(fit)
    seen = fitted_initial_rates(heldout, fit)
    best = prior.misfit(seen)
    for _ in range(_ROUNDS):
        trial = _nearer(heldout, seen, prior)
        if trial is None or (misfit := prior.misfit(trial)) >= best:
            break
        gained, seen, best = best - misfit, trial, misfit
        if gained < _CONVERGED:
            break
    return -best - prior.narrowed(seen) - seen.noise_deviance


@dataclass(frozen=True, kw_only=True, eq=False)
class Prior:
    """Distribution of (θ, effects) given a fit: a Gaussian, truncated at the effects' bounds.

    It is the prior of held-out runs. The mean of a parameter that is estimated at its bound lies beyond the bound.
    Were the parameter fixed at its bound instead, the held-out runs would reject a drag that acts on all axes and
    shows on two of them in the fitted runs.

    Attributes:
        mean: shape (C,).
        information: shape (C, C), initial rates marginalised, floored where nothing is known.
        scale: of each, so that its information is 1, shape (C,).
        least: misfit at the estimate itself; above 0 only where that is at a bound.
    """

    mean: Array
    information: Array
    scale: Array
    least: float

    @staticmethod
    def of(fit: Fit) -> Prior:
        """Return the distribution of a fit's parameters, without the effects that act in single runs."""
        fit = recurring(fit)
        common = 6 + len(fit.effect_values)
        normal = fit.normal
        scale = 1.0 / np.sqrt(np.maximum(np.diag(normal)[:common], np.finfo(float).tiny))
        floor = np.where(fit.shown, _UNKNOWN / scale**2, 0.0)
        # What the initial rates take up of columns and slope.
        taken = np.linalg.lstsq(normal[common:, common:], normal[common:, :common], rcond=_OWN)[0]
        information = normal[:common, :common] - normal[:common, common:] @ taken + np.diag(floor)
        beyond = np.zeros(common)
        if fit.at_bound.any():
            slope = fit.jacobian.T @ fit.residual
            beyond = damped(information, slope[:common] - taken.T @ slope[common:])
        least = float(beyond @ information @ beyond)
        return Prior(mean=_common(fit) + beyond, information=information, scale=scale, least=least)

    def misfit(self, seen: Fit) -> float:
        """Return |r|² plus the squared Mahalanobis distance of the parameters from the prior."""
        away = _common(seen) - self.mean
        return seen.chi_square + float(away @ self.information @ away) - self.least

    def normal(self, seen: Fit) -> Array:
        """Return the normal matrix of held-out runs and prior, of all parameters and initial rates."""
        normal = seen.normal.copy()
        common = len(self.mean)
        normal[:common, :common] += self.information
        return normal

    def slope(self, seen: Fit) -> Array:
        """Return the slope along which all parameters fit held-out runs and prior better, shape (C + 3 R,)."""
        slope = seen.jacobian.T @ seen.residual
        slope[: len(self.mean)] += self.information @ (self.mean - _common(seen))
        return np.asarray(slope)

    def narrowed(self, seen: Fit) -> float:
        """Return log det(P⁻¹ + Gᵀ G) - log det P⁻¹, initial rates marginalised."""
        common, normal = len(self.mean), self.normal(seen)
        shown = np.diag(normal) > 0.0  # not the initial rates about axes that a bearing holds
        normal, own = normal[np.ix_(shown, shown)], normal[common:, common:].diagonal()
        scale = np.concatenate([self.scale[shown[:common]], 1.0 / np.sqrt(own[shown[common:]])])
        scaled = normal * np.outer(scale, scale)
        before = (self.information * np.outer(self.scale, self.scale))[np.ix_(shown[:common], shown[:common])]
        common = int(shown[:common].sum())
        return _log_determinant(scaled) - _log_determinant(scaled[common:, common:]) - _log_determinant(before)


def _nearer(heldout: Runs, seen: Fit, prior: Prior) -> Fit | None:
    """Return the fit after one Gauss-Newton step; None where the motion runs away."""
    normal, slope = prior.normal(seen), prior.slope(seen)
    step = damped(normal, slope)
    moving = ~pushing_out(seen, step)
    if not moving.all():
        step[~moving] = 0.0
        step[moving] = damped(normal[np.ix_(moving, moving)], slope[moving])
    try:
        return evaluated(heldout, seen.placed, moved(seen, step), as_trial=True)
    except InputError:
        return None


def _common(fit: Fit) -> Array:
    return np.concatenate([fit.theta, fit.effect_values])


def _log_determinant(matrix: Array) -> float:
    return float(np.linalg.slogdet(matrix)[1])
