"""The next flight: distances against plain least squares, limits, forecasts, and the scenario that is written."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from support.diagnosed_records import NOISE, nominal, records
from support.synthetic_telemetry import with_gimbals
from testbed.assembly.platform import true_platform
from testbed.cmg.cluster import platform_momentum
from testbed.diagnosis.data import runs_of
from testbed.diagnosis.fitting import corrected, fitted
from testbed.diagnosis.model import Hypothesis, evaluated
from testbed.dynamics.inertia import theta_of
from testbed.effects.contact import Contact
from testbed.effects.gyro_scale import GyroScale
from testbed.effects.registry import EFFECTS
from testbed.estimation.telemetry import GimbalTelemetry, Telemetry
from testbed.experiment.flying import fly_maneuver
from testbed.experiment.planning import plan_maneuver
from testbed.maneuver.gimbal_maneuver import body_rate_of
from testbed.next_experiment.actuator_space import actuator_space
from testbed.next_experiment.competing_hypotheses import CompetingHypothesis, HypothesisPairs, Pair
from testbed.next_experiment.criterion import criterion_of
from testbed.next_experiment.distance import contrast
from testbed.next_experiment.forecast import blank_runs, forecast, forecast_columns
from testbed.next_experiment.proposal import Proposal, Separation
from testbed.next_experiment.result import next_of
from testbed.next_experiment.sampling import sampled_flights
from testbed.next_experiment.scenario import write_next
from testbed.next_experiment.search import chosen_flight
from testbed.next_experiment.space import BIAS, RELEASE_SPIN, SPHERE, release_spin
from testbed.prediction.integration import Values
from testbed.report.diagnosis.next import distance_words, flight_words, next_section, pair_words
from testbed.scenario.reader import read_scenario


@pytest.fixture(scope="module")
def space():
    return actuator_space(*nominal())


@pytest.fixture(scope="module")
def flights(space):
    return sampled_flights(space)


@pytest.fixture(scope="module")
def runs():
    """Two runs of a platform at rest but for a little spin, as telemetry has them."""
    _, platform = nominal()
    taken = records(2, seconds=3.0)
    return runs_of(
        [record.details.name for record in taken],
        [
            Telemetry(
                gyro_time=record.time,
                body_rate=record.channels["body_rate"],
                gyro_noise=NOISE,
                actuator_time=record.time,
                gimbals=GimbalTelemetry(cluster=platform.cluster, angle=record.channels["gimbal_angle"]),
            )
            for record in taken
        ],
    )


@pytest.fixture(scope="module")
def baseline(runs):
    return fitted(runs, [], theta_of(nominal()[1].inertia), [])


@pytest.fixture(scope="module")
def scale_judge(runs, space, flights):
    """Two flights from rest, of a gyro whose x axis reads 2 % too much, and the model that takes it for inertia."""
    rest = blank_runs(flights[:2], runs, space.platform)
    scale, theta = Hypothesis(effect=GyroScale(), component="x"), theta_of(space.platform.inertia)[None]
    without = Values(theta=theta, initial_rate=np.zeros((2, 1, 3)), effects=())
    scaled = replace(without, effects=(np.array([[0.02]]),))
    models = (
        CompetingHypothesis(key="inertia", fits=(evaluated(rest, (), without),)),
        CompetingHypothesis(key="gyro_scale:x", fits=(evaluated(rest, (scale,), scaled),)),
    )
    hypotheses = HypothesisPairs(models=models, pairs=(Pair(truth=1, imitator=0, wanted=30.0),))
    return criterion_of(hypotheses, rest, space)


def shares_of(space, flight):
    """Return the shares of all limits that a flight takes, shape (L,)."""
    return space.shares(flight.release, flight.control_points[None])[0]


def test_the_distance_is_what_least_squares_leaves_of_all_flights_together():
    rng = np.random.default_rng(1)
    columns, differences = rng.normal(size=(2, 1, 30, 7)), rng.normal(size=(2, 1, 30))
    parts = [contrast(difference, column, 4) for difference, column in zip(differences, columns, strict=True)]
    whole = np.zeros((60, 4 + 3 + 3))
    whole[:30, :7] = columns[0, 0]
    whole[30:, :4], whole[30:, 7:] = columns[1, 0, :, :4], columns[1, 0, :, 4:]
    left = np.linalg.lstsq(whole, differences.ravel())[1]
    assert parts[0].with_(parts[1]).distance == pytest.approx(np.sqrt(left), rel=1e-9)
    assert parts[0].with_(parts[1], 3).distance > parts[0].with_(parts[1]).distance


def test_a_parameter_that_no_flight_shows_does_not_matter():
    rng = np.random.default_rng(2)
    columns, difference = rng.normal(size=(1, 20, 5)), rng.normal(size=(1, 20))
    blind = np.insert(columns, 1, 0.0, axis=2)
    assert contrast(difference, blind, 3).distance == pytest.approx(contrast(difference, columns, 2).distance)


def test_drawn_flights_keep_the_limits_and_begin_with_spins_and_momentum(space, flights):
    shares = np.stack([shares_of(space, each) for each in flights])
    assert shares.max() <= 1.0
    assert shares.max() > 0.8  # as large as they may be
    spins = {tuple(each.body_rate) for each in flights}
    assert {(RELEASE_SPIN, 0.0, 0.0), (0.0, RELEASE_SPIN, 0.0), (0.0, 0.0, 0.0)} <= spins
    held = [
        platform_momentum(
            space.platform.cluster, space.platform.inertia, each.body_rate, each.initial_gimbal_angle, np.zeros(6)
        )
        for each in flights
    ]
    assert max(np.abs(each.initial_gimbal_angle).max() for each in flights) == pytest.approx(BIAS)
    assert np.linalg.norm(held, axis=1).max() > 0.005  # N·m·s


def test_a_path_that_is_too_fast_breaks_a_limit(space, flights):
    flight = flights[0]
    assert space.shares(flight.release, 3.0 * flight.control_points[None]).max() > 1.0


def test_a_failed_unit_does_not_move(space):
    momentum = space.platform.cluster.rotor_momentum * (np.arange(6) != 2)
    cluster = replace(space.platform.cluster, rotor_momentum=momentum)
    weaker = replace(space, platform=replace(space.platform, cluster=cluster))
    assert all(not each.control_points[:, 2].any() for each in sampled_flights(weaker))


def test_a_forecast_is_the_motion_that_conserves_momentum(space, runs, baseline, flights):
    chosen = [flights[0], flights[20], flights[-1]]
    nominal_fit = replace(baseline, values=replace(baseline.values, theta=theta_of(space.platform.inertia)[None]))
    blank = blank_runs(chosen, runs, space.platform)
    forecasts = forecast(nominal_fit, chosen, blank).reshape(3, -1, 3)
    time = blank.grid.runs[0].gyro_time
    for flight, reading in zip(chosen, forecasts, strict=True):
        total = platform_momentum(
            space.platform.cluster, space.platform.inertia, flight.body_rate, flight.initial_gimbal_angle, np.zeros(6)
        )
        exact = body_rate_of(
            flight.motion,
            time,
            inertia=space.platform.inertia,
            cluster=space.platform.cluster,
            total_momentum_B=total,
        )
        # Angles are splined through 16 Hz samples, as a diagnosis has them: 2e-3 rad/s of 0.5 where they accelerate.
        assert np.abs(NOISE * reading - exact).max() < 2e-3


def test_what_the_gyro_got_wrong_so_far_is_no_part_of_a_flight_to_come(runs, baseline, flights, space):
    late = Hypothesis(effect=EFFECTS["gyro_latency"], component="gyro")
    rng = np.random.default_rng(1)
    torques = [with_gimbals(run, torque=rng.normal(0.0, 1e-3, run.gimbals.angle.shape)) for run in runs.grid.runs]
    with_torques = runs_of(runs.names, torques)
    corrected_runs = corrected(with_torques, fitted(with_torques, [late], baseline.theta, [np.array([0.01])]))
    assert corrected_runs.grid.runs[0].gyro_error is not None
    blank = blank_runs(flights[:2], corrected_runs, space.platform)
    usual = blank_runs(flights[:2], with_torques, space.platform)
    np.testing.assert_array_equal(forecast(baseline, flights[:2], blank), forecast(baseline, flights[:2], usual))


def test_what_happened_once_does_not_come_again(runs, baseline, flights, space):
    values = np.array([[1.0, 1e-3, 1e-3, 1e-3]])
    touched = replace(
        baseline,
        placed=(Hypothesis(effect=Contact(), component="platform"),),
        values=replace(baseline.values, effects=(values,)),
    )
    blank = blank_runs(flights[:2], runs, space.platform)
    assert np.array_equal(forecast(touched, flights[:2], blank), forecast(baseline, flights[:2], blank))
    assert not forecast_columns(touched, flights[:2], blank)[:, :, 6:10].any()


def test_a_release_spin_tells_a_gyros_scale_from_inertia(scale_judge, flights):
    distances = scale_judge.distances(flights)[:, 0]
    still = [index for index, each in enumerate(flights) if each.released_as == "at rest"]
    turning = [index for index, each in enumerate(flights) if each.body_rate.any()]
    assert scale_judge.now[0] < 0.05  # sigma; the gimbals' share of the inertia keeps it from being zero
    assert distances[still].max() < 0.1
    assert distances[turning].max() > 2.0


def test_flights_of_six_gyros_are_those_that_were_proposed_before_there_were_any_of_wheels(scale_judge, flights):
    """Frozen when paths were of gimbals alone: then equal bit for bit, here to what other machines round."""
    assert len(flights) == 88
    assert scale_judge.distances(flights).sum() == pytest.approx(217.1845605115487, rel=1e-9)
    assert chosen_flight(scale_judge).distances[0] == pytest.approx(12.546060451051574, rel=1e-6)


def test_a_satellite_that_its_actuators_turn_slowly_is_released_with_a_slow_spin(space):
    heavy = replace(space.platform, inertia=1000.0 * space.platform.inertia)
    spins = np.linalg.norm([each.body_rate for each in replace(space, platform=heavy).releases()], axis=1)
    slow = release_spin(heavy)
    assert spins[spins > 0.0] == pytest.approx(slow)
    shares = heavy.envelope_share(slow * heavy.inertia, SPHERE)
    assert shares.min() == pytest.approx(2.0 / 3.0)
    assert release_spin(space.platform) == RELEASE_SPIN  # of the nominal platform it is as fast as is useful


def test_refining_raises_the_smallest_margin_within_the_limits(scale_judge, flights):
    choice = chosen_flight(scale_judge)
    assert choice.separable.all()
    assert choice.distances[0] > 1.05 * scale_judge.distances(flights).max()
    assert shares_of(scale_judge.space, choice.flight).max() <= 1.0


def test_the_scenario_flies_as_it_stands(flights, tmp_path):
    scenario, platform = nominal()
    flight = next(each for each in flights if each.body_rate[2] == RELEASE_SPIN)
    written = read_scenario(write_next(scenario, flight, "Tells one from the other.", tmp_path / "next"))
    maneuver = plan_maneuver(written, platform).maneuver
    assert maneuver.gimbal_angle(2.0) == pytest.approx(flight.gimbal_angle(2.0), abs=1e-8)
    flown = fly_maneuver(written, platform, true_platform(written), maneuver, seed=1)
    assert flown.divergence == ""
    assert flown.record.channels["body_rate"][0] == pytest.approx(flight.body_rate, abs=5.0 * NOISE)
    angles = flown.record.channels["gimbal_angle"]
    planned = flight.gimbal_angle(flown.record.time)
    assert np.nanmax(np.abs(angles - planned)) < 0.05  # rad; the tracker corrects the motion, null motion the path
    assert max(flown.summary.limit_use.values()) < 1.0


def test_words_and_result_say_what_is_distinguished_and_what_is_not(flights):
    apart = Separation(
        keys=("viscous_drag:platform", "quadratic_drag:platform"), now=2.1, after=5.0, wanted=4.6, separable=True
    )
    alias = Separation(keys=("gyro_scale:x", "inertia"), now=0.1, after=0.2, wanted=4.6, separable=False)
    proposal = Proposal(flight=flights[-1], times=2, enough=False, separations=(alias, apart))
    assert pair_words(alias) == "gyro_scale (x) of its typical size and a different inertia"
    assert "one class" in distance_words(alias)
    assert "5 after one flight" in distance_words(apart)
    assert "twice" in flight_words(proposal)
    assert "No flight" in flight_words(replace(proposal, flight=None))
    assert [section.title for section in next_section(proposal)] == ["What to fly next"]
    assert list(next_section(None)) == []
    answer = next_of(proposal, "next/scenario.toml")["next"]
    assert json.loads(json.dumps(answer))["pairs"][1]["sigma_after"] == 5.0
    assert next_of(None, None) == {}
