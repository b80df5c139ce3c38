"""Table 3, figures 5 and 6: the zero-g campaign, flown once as the paper did and then over and over.

Five flights, each released with a spin and a drift, each cut where its own record shows the first contact with the
cabin; one estimate per flight, averaged by eq. (33). Source: paper section 5.2.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import chain

import numpy as np

from testbed.arrays import Theta
from testbed.assembly.platform import nominal_platform, true_platform
from testbed.campaign.plan import run_seed
from testbed.dynamics.inertia import theta_of
from testbed.estimation.combine import CombinedEstimate
from testbed.estimation.estimate import Estimate
from testbed.maneuver.maneuver import Maneuver
from testbed.reproduction.parts import NOWHERE, Parts, kept_maneuver
from testbed.reproduction.progress import Progress, silent
from testbed.reproduction.scenarios import paper_scenario
from testbed.reproduction.workers import Job, done_by_workers
from testbed.reproduction.zero_g_coverage import Coverage, coverage_by_name
from testbed.reproduction.zero_g_cuts import CutScore, cut_score
from testbed.reproduction.zero_g_estimates import estimates_of
from testbed.reproduction.zero_g_figures import Figure5, Figure6, figure5, figure6
from testbed.reproduction.zero_g_flights import CutFlight, fly_campaigns
from testbed.reproduction.zero_g_outcome import CampaignOutcome
from testbed.scenario.scenario import Scenario

SCENARIO = "zero_g_campaign"
PAPER_THETA: Theta = 1e-3 * np.array([20.04, 21.26, 25.75, 0.09, 0.04, 1.08])
"""kg·m². Source: paper Table 3, estimate; the truth of this campaign."""
PAPER_CAD_THETA: Theta = 1e-3 * np.array([20.80, 20.80, 26.00, 0.0, 0.0, 0.0])
"""kg·m². Source: paper Table 3, CAD model; what this campaign believes."""
FLIGHTS = 5
"""That an estimate is made of. Source: paper section 5.2."""
BLOCK_CAMPAIGNS = 5
"""Campaigns that a worker flies side by side."""


@dataclass(frozen=True, kw_only=True)
class Table3:
    """The zero-g campaign.

    Attributes:
        maneuver: what every flight tried to fly, designed for the CAD model.
        true_theta: kg·m².
        cad_theta: what controller, design and instrument believed, kg·m².
        flights: the five of the campaign shown.
        estimates: by estimator ("iv", "output_error", "iv_from_zero", "iv_from_first_sample"), one per flight.
        combined: their averages, eq. (33).
        heldout: a sixth flight.
        coverage: of each estimator's average over the repetitions.
        cuts: of all flights of the repetitions, those too short to be used as well.
        usable: times of the flights used in the repetitions, s.
        figure5: of the longest of the five.
        figure6: of the flight held out, with the IV's average.
    """

    maneuver: Maneuver
    true_theta: Theta
    cad_theta: Theta
    flights: tuple[CutFlight, ...]
    estimates: Mapping[str, Sequence[Estimate]]
    combined: Mapping[str, CombinedEstimate]
    heldout: CutFlight
    coverage: Mapping[str, Coverage]
    cuts: CutScore
    usable: tuple[float, ...]
    figure5: Figure5
    figure6: Figure6


def table3(
    campaigns: int, seed: int, progress: Progress = silent, processes: int = 1, parts: Parts = NOWHERE
) -> Table3:
    """Fly the campaign, show it, and repeat it.

    Args:
        campaigns: repetitions, two or more; the first is the one shown.
        seed: everything follows from it, bit for bit, however many processes.
        progress: of the campaigns.
        processes: that fly them.
        parts: that are finished.

    Raises:
        InputError: a process died.
    """
    scenario = paper_scenario(SCENARIO)
    nominal, true_theta = nominal_platform(scenario), theta_of(true_platform(scenario).inertia)
    maneuver = kept_maneuver(scenario, parts)
    seeds = [run_seed(seed, campaign) for campaign in range(campaigns)]
    blocks = [seeds[first : first + BLOCK_CAMPAIGNS] for first in range(0, campaigns, BLOCK_CAMPAIGNS)]
    jobs = [
        Job(
            name=f"table3-seed{seed}-{index:05d}",
            part="Table 3",
            items=len(block),
            call=fly_block,
            arguments=(scenario, maneuver, block),
        )
        for index, block in enumerate(blocks)
    ]
    outcomes: list[CampaignOutcome] = list(chain.from_iterable(done_by_workers(jobs, processes, progress, parts)))
    *flights, heldout = fly_campaigns(scenario, maneuver, seeds[:1], FLIGHTS + 1)[0].flights
    shown = estimates_of(scenario, maneuver, flights)
    theta, filter_time = shown.combined["iv"].theta, scenario.estimation.prefilter_time_constant_s
    return Table3(
        maneuver=maneuver,
        true_theta=true_theta,
        cad_theta=theta_of(nominal.inertia),
        flights=tuple(flights),
        estimates=shown.each,
        combined=shown.combined,
        heldout=heldout,
        coverage=coverage_by_name([outcome.combined for outcome in outcomes], true_theta),
        cuts=cut_score([cut for outcome in outcomes for cut in outcome.cuts]),
        usable=tuple(usable for outcome in outcomes for usable in outcome.usable),
        figure5=figure5(max(flights, key=lambda flight: flight.usable).telemetry),
        figure6=figure6(heldout.telemetry, theta, theta_of(nominal.inertia), filter_time),
    )


def fly_block(scenario: Scenario, maneuver: Maneuver, seeds: Sequence[int]) -> list[CampaignOutcome]:
    """Fly whole campaigns side by side; what a seed gives depends on it alone.

    Args:
        scenario: of the campaign.
        maneuver: of all flights.
        seeds: one per campaign.
    """
    return [
        CampaignOutcome(
            combined=estimates_of(scenario, maneuver, campaign.flights).combined,
            cuts=tuple(campaign.cuts),
            usable=tuple(flight.usable for flight in campaign.flights),
        )
        for campaign in fly_campaigns(scenario, maneuver, seeds, FLIGHTS)
    ]
