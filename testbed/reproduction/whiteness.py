"""How white the prefiltered equation's residual is, against the prefilter's time constant γ, and why it is not.

The prefilter makes gyro noise e into M e: white noise less its low frequencies, as s F(s) has it. The fit takes out
more of them, those of the motion. So no γ leaves a white residual; a long one leaves the equation's error nearly white.
The residual is tested against white noise, against the residual of a fit to a white error, and against what prefilter
and fit make of a white gyro. Autocorrelations are quadratic forms of Gaussian noise; their covariances are exact.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy

from testbed.arrays import Array, Series, Vectors3
from testbed.assembly.estimators import estimation_settings
from testbed.assembly.platform import nominal_platform
from testbed.assembly.telemetry import telemetry_of
from testbed.campaign.flights import fly_seeds
from testbed.campaign.plan import run_seed
from testbed.estimation.estimate import EstimationSettings
from testbed.estimation.instrumental_variable import instrumental_variable
from testbed.estimation.noise_response import residual_colour, residual_maker
from testbed.estimation.telemetry import Telemetry
from testbed.maneuver.maneuver import Maneuver
from testbed.reproduction.noise_free import NoiseFreeFlight
from testbed.scenario.scenario import Scenario

TIME_CONSTANTS = (0.05, 0.1, 0.2, 0.4, 0.8, 1.6, 3.2)
"""s. The paper's is 0.8, and "with a posteriori check" the residual "becomes reasonably white" there."""
PAPER_TIME_CONSTANT = 0.8
"""s. Source: paper eq. (32)."""
LAGS = 8
"""Samples: half a second at 16 Hz."""
CHANCE = 1e-3
"""Of a chi-square beyond `largest_chi_square` where the residual is as supposed."""


@dataclass(frozen=True, kw_only=True)
class Whiteness:
    """Autocorrelation of the IV's residual over flights and axes, at lags 1, 2, ..., for every γ.

    Attributes:
        time_constant: γ, shape (G,), s.
        autocorrelation: measured, shape (G, LAGS).
        predicted: what the prefilter and the fit make of white gyro noise, shape (G, LAGS).
        white_band: within which 95 % of these means would lie if the residual were white.
        white_chi_square: of the measured against a white residual, LAGS degrees of freedom, shape (G,).
        fit_chi_square: against the residual of a fit to a white error, likewise.
        predicted_chi_square: against the predicted, likewise.
        flights: how many.
    """

    time_constant: Series
    autocorrelation: Array
    predicted: Array
    white_band: float
    white_chi_square: Series
    fit_chi_square: Series
    predicted_chi_square: Series
    flights: int

    @property
    def paper_row(self) -> int:
        """Index of the paper's γ."""
        return int(np.argmin(np.abs(self.time_constant - PAPER_TIME_CONSTANT)))

    @property
    def largest_chi_square(self) -> float:
        """What a chi-square keeps below, but once in a thousand times, where the residual is as supposed."""
        return float(scipy.stats.chi2.isf(CHANCE, self.autocorrelation.shape[1]))


@dataclass(frozen=True, kw_only=True)
class _Curve:
    """The rows of one γ."""

    autocorrelation: Array
    predicted: Array
    white_chi_square: float
    fit_chi_square: float
    predicted_chi_square: float


def whiteness(scenario: Scenario, maneuver: Maneuver, flights: int, seed: int) -> Whiteness:
    """Fly a maneuver and correlate the IV's residuals for every γ.

    Args:
        scenario: what is flown.
        maneuver: its reference.
        flights: to average over.
        seed: of the flights.
    """
    nominal = nominal_platform(scenario)
    flown = fly_seeds(scenario, maneuver, [run_seed(seed, run) for run in range(flights)])
    telemetry = [telemetry_of(each.flown.record, scenario, nominal) for each in flown if each.flown is not None]
    noise_free = NoiseFreeFlight(scenario, maneuver)
    curves = [_curve(telemetry, _settings(scenario, maneuver, time), noise_free) for time in TIME_CONSTANTS]
    samples = telemetry[0].body_rate.size * len(telemetry)
    return Whiteness(
        time_constant=np.array(TIME_CONSTANTS),
        autocorrelation=np.array([curve.autocorrelation for curve in curves]),
        predicted=np.array([curve.predicted for curve in curves]),
        white_band=float(1.96 / np.sqrt(samples)),
        white_chi_square=np.array([curve.white_chi_square for curve in curves]),
        fit_chi_square=np.array([curve.fit_chi_square for curve in curves]),
        predicted_chi_square=np.array([curve.predicted_chi_square for curve in curves]),
        flights=len(telemetry),
    )


def autocorrelation(residuals: Sequence[Vectors3], lags: int) -> Array:
    """Return the autocorrelation at lags 1 ... lags over all residuals and axes, shape (lags,).

    Args:
        residuals: each of shape (N, 3).
        lags: in samples.
    """
    forms = _forms(len(residuals[0]), lags)
    moments = np.mean([_moments(residual, forms) for residual in residuals], axis=0)
    return np.asarray(moments[1:] / moments[0])


def chi_square(residuals: Sequence[Vectors3], covariance: Array, lags: int) -> float:
    """Return by how much autocorrelations are not those of a covariance; chi-square of `lags` degrees of freedom.

    With ρ the autocorrelations that the covariance S has, qₖ = r'(Aₖ - ρₖ A₀) r of a Gaussian residual r has no mean,
    and the covariance 2 tr(Bⱼ S Bₖ S) exactly, B = A - ρ A₀; over many flights it is normal.

    Args:
        residuals: each of shape (N, 3).
        covariance: S of each, up to a factor, shape (3N, 3N).
        lags: in samples.
    """
    forms = _forms(len(residuals[0]), lags)
    expected = expected_autocorrelation(covariance, lags)
    moments = np.mean([_moments(residual, forms) for residual in residuals], axis=0)
    scale = moments[0] / _trace(forms[0], covariance)
    centred = [(form - rho * forms[0]) @ (scale * covariance) for form, rho in zip(forms[1:], expected, strict=True)]
    spread = 2.0 / len(residuals) * np.array([[np.sum(one * other.T) for other in centred] for one in centred])
    off = moments[1:] - expected * moments[0]
    return float(off @ np.linalg.solve(spread, off))


def expected_autocorrelation(covariance: Array, lags: int) -> Array:
    """Return what `autocorrelation` tends to over many residuals of a covariance, shape (lags,).

    Args:
        covariance: shape (3N, 3N).
        lags: in samples.
    """
    powers = [_trace(form, covariance) for form in _forms(len(covariance) // 3, lags)]
    return np.array(powers[1:]) / powers[0]


def _forms(samples: int, lags: int) -> list[Array]:
    """Return the symmetric A₀, A₁, ... of r'Aₖ r = Σ c(t) c(t + k), c the residual less its mean about each axis."""
    centring = np.eye(samples) - 1.0 / samples
    shifts = [(np.eye(samples, k=lag) + np.eye(samples, k=-lag)) / 2.0 for lag in range(lags + 1)]
    return [np.asarray(np.kron(centring @ shift @ centring, np.eye(3)), dtype=np.float64) for shift in shifts]


def _moments(residual: Vectors3, forms: Sequence[Array]) -> Array:
    flat = residual.ravel()
    return np.array([flat @ form @ flat for form in forms])


def _trace(form: Array, covariance: Array) -> float:
    return float(np.sum(form * covariance))


def _settings(scenario: Scenario, maneuver: Maneuver, time_constant: float) -> EstimationSettings:
    section = scenario.estimation.model_copy(update={"prefilter_time_constant_s": time_constant})
    nominal = nominal_platform(scenario)
    return estimation_settings(scenario.model_copy(update={"estimation": section}), nominal, maneuver)


def _curve(telemetry: Sequence[Telemetry], settings: EstimationSettings, noise_free: NoiseFreeFlight) -> _Curve:
    residuals = [instrumental_variable(each, settings).residual for each in telemetry]
    response = noise_free.response(settings.prefilter_time)
    instrument = noise_free.instrument(settings.prefilter_time)
    colour, fit = residual_colour(response, instrument), residual_maker(response, instrument)
    return _Curve(
        autocorrelation=autocorrelation(residuals, LAGS),
        predicted=expected_autocorrelation(colour @ colour.T, LAGS),
        white_chi_square=chi_square(residuals, np.eye(len(fit)), LAGS),
        fit_chi_square=chi_square(residuals, fit @ fit.T, LAGS),
        predicted_chi_square=chi_square(residuals, colour @ colour.T, LAGS),
    )
