"""The campaign's estimates: one per flight, and their average over the flights, eq. (33)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from testbed.assembly.estimators import estimation_settings
from testbed.assembly.platform import nominal_platform
from testbed.errors import InputError
from testbed.estimation.combine import CombinedEstimate, combined
from testbed.estimation.estimate import Estimate, EstimationSettings
from testbed.estimation.instrumental_variable import instrumental_variable
from testbed.estimation.output_error import output_error
from testbed.estimation.telemetry import Telemetry
from testbed.maneuver.maneuver import Maneuver
from testbed.reproduction.zero_g_flights import CutFlight
from testbed.reproduction.zero_g_startup import TREATMENTS, treated_estimates
from testbed.scenario.scenario import Scenario

ESTIMATORS = ("iv", "output_error", *TREATMENTS)
"""The paper's IV with its prefilter's start estimated, output error, and that IV with the start treated otherwise."""


@dataclass(frozen=True, kw_only=True)
class CampaignEstimates:
    """The estimates of one campaign.

    Attributes:
        each: of every flight, by estimator; a flight that gave none is absent.
        combined: over the flights, by estimator.
    """

    each: Mapping[str, Sequence[Estimate]]
    combined: Mapping[str, CombinedEstimate]


def estimates_of(scenario: Scenario, maneuver: Maneuver, flights: Sequence[CutFlight]) -> CampaignEstimates:
    """Estimate from every flight of a campaign, and average, eq. (33).

    Args:
        scenario: the nominal one, which the estimators know.
        maneuver: what the flights tried to fly.
        flights: of one campaign, at least one of which gives an estimate.
    """
    settings = estimation_settings(scenario, nominal_platform(scenario), maneuver)
    by_flight = [flight_estimates(flight.telemetry, settings) for flight in flights]
    each = {name: [estimates[name] for estimates in by_flight if name in estimates] for name in ESTIMATORS}
    return CampaignEstimates(each=each, combined={name: combined(estimates) for name, estimates in each.items()})


def flight_estimates(telemetry: Telemetry, settings: EstimationSettings) -> Mapping[str, Estimate]:
    """Return the estimates of one flight by name, in the order of `ESTIMATORS`; none where its motion tells nothing."""
    try:
        return {
            "iv": instrumental_variable(telemetry, settings),
            "output_error": output_error(telemetry, settings),
            **treated_estimates(telemetry, settings),
        }
    except InputError:
        return {}
