"""A small reproduction for the tests of its claims, numbers, page and recording: drawn errors, one short flight."""

from __future__ import annotations

from functools import cache

import numpy as np
import pyarrow as pa

from support.report_runs import flight
from testbed.arrays import Theta
from testbed.assembly.platform import shown_model
from testbed.campaign.columns import parameter_columns
from testbed.campaign.statistics import CampaignStatistics, errors_of, statistics_of
from testbed.dynamics.inertia import theta_of
from testbed.estimation.alignment_observability import parameter_names, parameter_units
from testbed.estimation.combine import CombinedEstimate
from testbed.maneuver.profiles import basic_profile
from testbed.reproduction.alignments import Alignments, SteeringStatistics
from testbed.reproduction.reproduction import Reproduction, full_extent
from testbed.reproduction.table1 import PAPER, Row, Table1, Way
from testbed.reproduction.table2 import MANEUVER_NAMES, PAPER_MEAN, PAPER_STD, ManeuverStatistics
from testbed.reproduction.whiteness import LAGS, TIME_CONSTANTS, Whiteness
from testbed.reproduction.zero_g import Table3
from testbed.reproduction.zero_g_coverage import coverage_of
from testbed.reproduction.zero_g_cuts import Cut, cut_score
from testbed.reproduction.zero_g_figures import Figure5, Figure6
from testbed.reproduction.zero_g_flights import CutFlight

RUNS = 1000
ESTIMATORS = ("ls", "iv", "iv_momentum", "output_error")
TRUTH = 1e-3 * np.array([22.0, 22.0, 27.0, 0.0, 0.0, 0.0])


def campaign_table(std: Theta, runs: int = RUNS, mean_error: float = 0.0, seed: int = 1) -> pa.Table:
    """Runs whose errors have exactly a mean and standard deviations; the bound is as large as these."""
    rng = np.random.default_rng(seed)
    shape = rng.standard_normal((runs, 6))
    errors = (shape - shape.mean(axis=0)) / shape.std(axis=0, ddof=1) * std + mean_error * std
    columns: dict[str, object] = {"outcome": ["completed"] * runs}
    for prefix, values in (("true", np.tile(TRUTH, (runs, 1))), ("bound_std", np.tile(std, (runs, 1)))):
        columns |= dict(zip(parameter_columns(prefix), values.T, strict=True))
    for name in ESTIMATORS:
        columns |= dict(zip(parameter_columns(name), (TRUTH + errors).T, strict=True))
        columns |= dict(zip(parameter_columns(f"{name}_std"), np.tile(std, (runs, 1)).T, strict=True))
        columns[f"{name}_failure"] = pa.nulls(runs, pa.string())
    return pa.table(columns)


def maneuver_statistics(
    name: str, std: Theta, runs: int = RUNS, mean_error: float = 0.0, predicted_bias: float = 0.0
) -> ManeuverStatistics:
    """A maneuver of Table 2 flown with given scatter and bias; the drift adds a hundredth to the scatter.

    The mean error is in standard deviations, the predicted bias in standard errors.
    """
    table = campaign_table(std, runs, mean_error)
    drift: CampaignStatistics = statistics_of(campaign_table(1.01 * std, runs))
    return ManeuverStatistics(
        name=name,
        maneuver=basic_profile(duration=5.0),
        true_theta=TRUTH,
        statistics=statistics_of(table),
        errors={each: errors_of(table, each) for each in ESTIMATORS},
        drift=drift,
        steady=statistics_of(campaign_table(std, runs)),
        predicted_iv_bias=predicted_bias * std / np.sqrt(runs),
        paper_mean=PAPER_MEAN.get(name),
        paper_std=PAPER_STD.get(name),
    )


def table1() -> Table1:
    """The paper's own numbers as if they had been found in each way."""
    ways: tuple[Way, ...] = ("paper", "hard", "gimbal")
    rows = [_row("basic", "given"), *(_row(name, way) for way in ways for name in ("A", "D", "E", "condition"))]
    basic = basic_profile(duration=5.0)
    return Table1(rows=tuple(rows), maneuvers={("given", "basic"): basic, ("paper", "D"): basic})


def _row(name: str, way: Way) -> Row:
    figures = vars(PAPER[name])
    extra = {"peak_rate": 0.3, "control_points": 9, "starts": 1, "seconds": 0.1, "paper": PAPER[name]}
    return Row(name=name, way=way, condition_number=figures["regressor_condition_number"] ** 2, **figures, **extra)


def table3() -> Table3:
    """One short flight five times over; campaigns whose errors are drawn as they claim."""
    experiment = flight()
    truth, record = theta_of(experiment.truth.inertia), experiment.flown.record
    rng, std = np.random.default_rng(3), 1e-5 * np.ones(6)
    many = [
        CombinedEstimate(theta=truth + std * rng.standard_normal(6), covariance=np.diag(std**2)) for _ in range(200)
    ]
    names = ("iv", "output_error", "iv_from_zero", "iv_from_first_sample")
    time, wave = np.arange(40) / 16.0, np.sin(np.arange(120).reshape(40, 3) / 20.0)
    assert experiment.estimation is not None
    one = experiment.estimation.by_name["iv"]
    flights = tuple(
        CutFlight(seed=4, record=record, telemetry=_Times(time), contact=None, onset=None) for _ in range(5)
    )
    return Table3(
        maneuver=experiment.plan.maneuver,
        true_theta=truth,
        cad_theta=theta_of(experiment.nominal.inertia),
        flights=flights,
        estimates={name: [one] * 5 for name in names},
        combined=dict.fromkeys(names, many[0]),
        heldout=flights[0],
        coverage=dict.fromkeys(names, coverage_of(many, truth)),
        cuts=cut_score([Cut(usable=2.4, late=0, touched=True)] * 10),
        usable=(2.4,) * 10,
        figure5=Figure5(time=time, body_rate=wave, cluster_momentum_B=wave / 50),
        figure6=Figure6(
            time=time,
            measured_B=wave / 100,
            estimated_B=wave / 101,
            nominal_B=wave / 90,
            estimated_misfit=0.01,
            nominal_misfit=0.1,
        ),
    )


class _Times:
    """Telemetry of which the page wants the times only."""

    def __init__(self, gyro_time: np.ndarray) -> None:
        self.gyro_time = gyro_time


def alignments(gain: float = 3.0) -> Alignments:
    """Alignments whose scatter null motion makes smaller by a factor."""

    def steering(name: str, scatter: float) -> SteeringStatistics:
        values = np.full(len(parameter_names(6)), scatter)
        return SteeringStatistics(
            steering=name,
            failed=0,
            scatter=values,
            claimed=values,
            mean_error=np.zeros(len(parameter_names(6))),
            coverage=np.full(len(parameter_names(6)), 0.95),
            saturated=0.0,
            gimbal_rate=0.9,
            rate_difference=1e-3,
            null_space=("all scales and the inertia together",),
        )

    return Alignments(
        names=parameter_names(6),
        units=parameter_units(6),
        runs=100,
        null_motion=steering("null motion", 1e-3),
        pseudo_inverse=steering("pseudo-inverse", gain * 1e-3),
    )


@cache
def reproduction() -> Reproduction:
    """All parts, as good as they have to be."""
    experiment = flight()
    own = {"gimbal_slow": 0.8, "gimbal_weighted": 0.4}
    stds = dict(PAPER_STD) | {name: share * PAPER_STD["paper_d_optimal"] for name, share in own.items()}
    return Reproduction(
        extent=full_extent(seed=1, workers=2),
        table1=table1(),
        table2=tuple(maneuver_statistics(name, stds[name]) for name in MANEUVER_NAMES),
        whiteness=Whiteness(
            time_constant=np.array(TIME_CONSTANTS),
            autocorrelation=np.full((len(TIME_CONSTANTS), LAGS), -0.05),
            predicted=np.full((len(TIME_CONSTANTS), LAGS), -0.04),
            white_band=0.06,
            white_chi_square=np.full(len(TIME_CONSTANTS), 60.0),
            fit_chi_square=np.full(len(TIME_CONSTANTS), 30.0),
            predicted_chi_square=np.full(len(TIME_CONSTANTS), 8.0),
            flights=4,
        ),
        table3=table3(),
        longest_flight=experiment.flown.record,
        zero_g_model=shown_model(experiment.scenario),
        alignments=alignments(),
        orbit=experiment,
        acceleration_limit=np.array([1.8, 1.8, 1.7]),
        seconds=100.0,
    )
