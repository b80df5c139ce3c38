"""The numbers of a reproduction in the form of reproduce.json."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from testbed.arrays import Array
from testbed.campaign.statistics import CampaignStatistics
from testbed.experiment.result import result_of as run_result_of
from testbed.reproduction.alignments import Alignments, SteeringStatistics
from testbed.reproduction.claims import Claim
from testbed.reproduction.gains import gains_of
from testbed.reproduction.reproduction import Reproduction
from testbed.reproduction.seeds import ClaimOverSeeds
from testbed.reproduction.table2 import LIKE_FOR_LIKE, OWN, ManeuverStatistics
from testbed.reproduction.whiteness import Whiteness
from testbed.reproduction.zero_g import PAPER_CAD_THETA, PAPER_THETA, Table3

SCHEMA = 1


def result_of(
    reproduction: Reproduction, claims: Sequence[Claim], over_seeds: Sequence[ClaimOverSeeds] = ()
) -> dict[str, Any]:
    """Return what reproduce.json holds.

    Args:
        reproduction: what was made.
        claims: what it is held to.
        over_seeds: the claims over several seeds, where that was asked for.
    """
    return {
        "schema": SCHEMA,
        "extent": asdict(reproduction.extent),
        "seconds": reproduction.seconds,
        "claims": [_claim(claim) for claim in claims],
        "seeds": [_over_seeds(each) for each in over_seeds],
        "table1": [asdict(row) for row in reproduction.table1.rows],
        "table2": {maneuver.name: _maneuver(maneuver) for maneuver in reproduction.table2},
        "gains": _gains(reproduction.table2),
        "whiteness": _whiteness(reproduction.whiteness),
        "table3": _table3(reproduction.table3),
        "alignments": _alignments(reproduction.alignments),
        "orbit": run_result_of(reproduction.orbit),
    }


def _claim(claim: Claim) -> dict[str, Any]:
    return {**asdict(claim), "verdict": claim.verdict}


def _over_seeds(each: ClaimOverSeeds) -> dict[str, Any]:
    counts = {verdict: each.counts[verdict] for verdict in ("met", "missed", "undecided")}
    by_seed = {str(seed): _claim(claim) for seed, claim in each.by_seed.items()}
    return {"subject": each.claim.subject, **counts, "by_seed": by_seed}


def _maneuver(maneuver: ManeuverStatistics) -> dict[str, Any]:
    return {
        "paper_mean_kg_m2": numbers(maneuver.paper_mean),
        "paper_std_kg_m2": numbers(maneuver.paper_std),
        "predicted_iv_bias_kg_m2": numbers(maneuver.predicted_iv_bias),
        "peak_rate_rad_s": maneuver.peak_rate,
        "steady_gyro": _campaign(maneuver.statistics),
        "drifting_gyro": _campaign(maneuver.drift),
        "same_seeds_without_drift": _campaign(maneuver.steady),
    }


def _campaign(campaign: CampaignStatistics) -> dict[str, Any]:
    return {
        "runs": campaign.runs,
        "failed": campaign.failed,
        "true_theta_kg_m2": numbers(campaign.true_theta),
        "bound_std_kg_m2": numbers(campaign.bound_std),
        "estimates": {
            name: {
                "runs": one.runs,
                "mean_kg_m2": numbers(one.mean),
                "std_kg_m2": numbers(one.std),
                "bias_in_standard_errors": numbers(one.bias_in_standard_errors),
                "coverage_95": numbers(one.coverage),
                "scatter_over_bound": numbers(one.scatter_over_bound),
            }
            for name, one in campaign.estimators.items()
        },
    }


def _gains(maneuvers: Sequence[ManeuverStatistics]) -> dict[str, Any]:
    by_name = {maneuver.name: maneuver for maneuver in maneuvers}
    gains = gains_of(by_name["paper_d_optimal"], by_name[LIKE_FOR_LIKE], by_name[OWN])
    return {name: numbers(ratios) for name, ratios in vars(gains).items()} | {"total": numbers(gains.total)}


def _whiteness(whiteness: Whiteness) -> dict[str, Any]:
    return {
        "time_constant_s": numbers(whiteness.time_constant),
        "autocorrelation": [numbers(row) for row in whiteness.autocorrelation],
        "predicted_autocorrelation": [numbers(row) for row in whiteness.predicted],
        "white_band": whiteness.white_band,
        "white_chi_square": numbers(whiteness.white_chi_square),
        "fit_chi_square": numbers(whiteness.fit_chi_square),
        "predicted_chi_square": numbers(whiteness.predicted_chi_square),
        "largest_chi_square": whiteness.largest_chi_square,
        "flights": whiteness.flights,
    }


def _table3(campaign: Table3) -> dict[str, Any]:
    return {
        "paper_theta_kg_m2": numbers(PAPER_THETA),
        "paper_cad_theta_kg_m2": numbers(PAPER_CAD_THETA),
        "true_theta_kg_m2": numbers(campaign.true_theta),
        "usable_s": [flight.usable for flight in campaign.flights],
        "combined": {
            name: {"theta_kg_m2": numbers(one.theta), "std_kg_m2": numbers(one.std)}
            for name, one in campaign.combined.items()
        },
        "coverage": {
            name: {
                "campaigns": one.campaigns,
                "share": numbers(one.share),
                "overall_share": one.overall_share,
                "mean_error_kg_m2": numbers(one.mean_error),
                "std_kg_m2": numbers(one.std),
                "claimed_std_kg_m2": numbers(one.claimed_std),
            }
            for name, one in campaign.coverage.items()
        },
        "cuts": asdict(campaign.cuts),
        "figure6_misfit": {
            "estimated": campaign.figure6.estimated_misfit,
            "nominal": campaign.figure6.nominal_misfit,
        },
    }


def _alignments(found: Alignments) -> dict[str, Any]:
    return {
        "names": list(found.names),
        "units": list(found.units),
        "platforms": found.runs,
        "median_ratio": found.median_ratio,
        "null_motion": _steering(found.null_motion),
        "pseudo_inverse": _steering(found.pseudo_inverse),
    }


def _steering(statistics: SteeringStatistics) -> dict[str, Any]:
    return {
        "failed": statistics.failed,
        "scatter": numbers(statistics.scatter),
        "claimed_std": numbers(statistics.claimed),
        "mean_error": numbers(statistics.mean_error),
        "coverage_95": numbers(statistics.coverage),
        "saturated_s": statistics.saturated,
        "null_space": list(statistics.null_space),
    }


def numbers(values: Array | None) -> list[float | None] | None:
    """Return numbers as JSON has them; null for one that is not finite, and for an array that is not there."""
    if values is None:
        return None
    return [float(value) if np.isfinite(value) else None for value in np.asarray(values)]
