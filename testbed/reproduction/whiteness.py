"""How white the prefiltered equation's residual is, against the prefilter's time constant γ."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from testbed.arrays import Array, Series, Vectors3
from testbed.assembly.estimation import estimation_settings, telemetry_of
from testbed.assembly.platform import nominal_platform
from testbed.campaign.flights import fly_seeds
from testbed.campaign.plan import run_seed
from testbed.estimation.estimate import EstimationSettings
from testbed.estimation.instrumental_variable import instrumental_variable
from testbed.estimation.telemetry import Telemetry
from testbed.maneuver.maneuver import Maneuver
from testbed.scenario.scenario import Scenario

TIME_CONSTANTS = (0.05, 0.1, 0.2, 0.4, 0.8, 1.6, 3.2)
"""s. The paper's is 0.8, and "with a posteriori check" the residual "becomes reasonably white" there."""
LAGS = 8
"""Samples: half a second at 16 Hz."""


@dataclass(frozen=True, kw_only=True)
class Whiteness:
    """Autocorrelation of the IV's residual, averaged over flights and axes.

    Attributes:
        time_constant: γ, shape (G,), s.
        autocorrelation: at lags 1, 2, ..., shape (G, LAGS).
        white_band: within which 95 % of one flight's values would lie if its residual were white.
        flights: how many were averaged.
    """

    time_constant: Series
    autocorrelation: Array
    white_band: float
    flights: int


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
    curves = [_autocorrelation(telemetry, _settings(scenario, maneuver, time)) for time in TIME_CONSTANTS]
    return Whiteness(
        time_constant=np.array(TIME_CONSTANTS),
        autocorrelation=np.array(curves),
        white_band=float(1.96 / np.sqrt(len(telemetry[0].gyro_time))),
        flights=len(telemetry),
    )


def autocorrelation(residual: Vectors3, lags: int) -> Array:
    """Return the autocorrelation at lags 1 ... lags, averaged over the axes, shape (lags,).

    Args:
        residual: shape (N, 3).
        lags: in samples.
    """
    centred = residual - residual.mean(axis=0)
    power = (centred**2).sum()
    return np.array([(centred[lag:] * centred[:-lag]).sum() / power for lag in range(1, lags + 1)])


def _settings(scenario: Scenario, maneuver: Maneuver, time_constant: float) -> EstimationSettings:
    section = scenario.estimation.model_copy(update={"prefilter_time_constant_s": time_constant})
    nominal = nominal_platform(scenario)
    return estimation_settings(scenario.model_copy(update={"estimation": section}), nominal, maneuver)


def _autocorrelation(telemetry: Sequence[Telemetry], settings: EstimationSettings) -> Array:
    residuals = [instrumental_variable(each, settings).residual for each in telemetry]
    return np.asarray(np.mean([autocorrelation(residual, LAGS) for residual in residuals], axis=0))
