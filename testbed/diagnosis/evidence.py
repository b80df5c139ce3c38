"""How well a fitted model predicts held-out runs, its parameters as uncertain as the fit has them.

Of the density of the held-out samples, given the fitted ones, with parameters θ ~ N(θ̂, P) as the fit has them,
-2 log p = min over θ of |r(θ)|² + (θ - θ̂)ᵀ P⁻¹ (θ - θ̂), + log det(P⁻¹ + Gᵀ G) - log det P⁻¹ (Laplace), with the
whitened residual r and its slopes G; initial rates are each run's own. It rewards what carries over to other flights
and penalises what was fitted to noise. The parameters stay those of the fit.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from testbed.arrays import Array
from testbed.diagnosis.candidates import p_value
from testbed.diagnosis.data import Runs, chosen, joined
from testbed.diagnosis.keeping import part
from testbed.diagnosis.model import (
    Fit,
    damped,
    evaluated,
    fitted_initial_rates,
    moved,
    orthonormal,
    projected_out,
    pushing_out,
    recurring,
)
from testbed.errors import InputError

_UNKNOWN = 1e-9
"""Share of a parameter's own information below which the fit does not know it."""
_ROUNDS = 6
_CONVERGED = 0.05
"""Change of -2 log p; a standard error moves it by 1."""
_ENOUGH_RUNS = 24
"""Runs that are tested for an unmodelled torque: its unknowns grow with the runs, the cost with their cube."""


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
    return -best - prior.narrowed(seen)


def goodness(fit: Fit, noise_freedom: float) -> float:
    """Return the p-value of the residual's χ², with all directions of the parameters projected out.

    Args:
        fit: evaluated on all runs.
        noise_freedom: degrees of freedom with which the noise is known.
    """
    basis = orthonormal(fit.jacobian)
    left = projected_out(fit.residual, basis)
    return p_value(float(left @ left), len(left) - basis.shape[1], noise_freedom)


def on_all_runs(runs: Runs, heldout: Runs | None, fit: Fit) -> tuple[Runs, Fit]:
    """Return all runs together, gyro only, and a fit evaluated on them: unmodelled torques are tested in all runs.

    Args:
        runs: that were fitted.
        heldout: that were not: of them, initial rates are fitted; None where there are none.
        fit: to the former.
    """
    rates = fit.values.initial_rate
    if heldout is not None:
        rates = np.concatenate([rates, fitted_initial_rates(heldout, fit).values.initial_rate])
    everything = joined(runs, heldout)
    return everything, evaluated(everything, fit.placed, replace(fit.values, initial_rate=rates))


def on_enough_runs(runs: Runs, fit: Fit) -> tuple[Runs, Fit]:
    """Return an even choice of runs where there are very many, gyro only, and the fit evaluated on them.

    Args:
        runs: of one data set, as many as there are.
        fit: of them.
    """
    if len(runs.names) <= _ENOUGH_RUNS:
        return runs, fit
    which = np.linspace(0, len(runs.names) - 1, _ENOUGH_RUNS).round().astype(int).tolist()
    some = chosen(runs, which)
    return some, evaluated(some, fit.placed, replace(fit.values, initial_rate=fit.values.initial_rate[which]))


@dataclass(frozen=True, kw_only=True, eq=False)
class Prior:
    """What a fit knows of (θ, effects): a Gaussian, cut off where effects have their bounds.

    An estimate at its bound lies beside the Gaussian's mean: how far tells how surely it belongs there. Taken for known
    it made a drag that acts on all axes, and shows on two of them where it was fitted, unlikely elsewhere.

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
        """Return what a fit knows of its parameters, without effects that do not recur."""
        fit = recurring(fit)
        common = 6 + len(fit.effect_values)
        normal = fit.normal
        scale = 1.0 / np.sqrt(np.maximum(np.diag(normal)[:common], np.finfo(float).tiny))
        # What the initial rates take up of columns and slope.
        taken = np.linalg.lstsq(normal[common:, common:], normal[common:, :common], rcond=1e-12)[0]
        information = normal[:common, :common] - normal[:common, common:] @ taken + np.diag(_UNKNOWN / scale**2)
        beyond = np.zeros(common)
        if fit.at_bound.any():
            slope = fit.jacobian.T @ fit.residual
            beyond = damped(information, slope[:common] - taken.T @ slope[common:])
        least = float(beyond @ information @ beyond)
        return Prior(mean=_common(fit) + beyond, information=information, scale=scale, least=least)

    def misfit(self, seen: Fit) -> float:
        """Return |r|² and what the parameters lie away from what the fit knows, in its standard deviations, squared."""
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
        scale = np.concatenate([self.scale, 1.0 / np.sqrt(np.diag(normal)[common:])])
        scaled = normal * np.outer(scale, scale)
        before = self.information * np.outer(self.scale, self.scale)
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
        return evaluated(heldout, seen.placed, moved(seen, step))
    except InputError:
        return None


def _common(fit: Fit) -> Array:
    return np.concatenate([fit.theta, fit.effect_values])


def _log_determinant(matrix: Array) -> float:
    return float(np.linalg.slogdet(matrix)[1])
