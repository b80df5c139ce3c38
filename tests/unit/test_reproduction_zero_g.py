"""The zero-g campaign's parts: flights cut by their own records, the prefilter's start, coverage, figure 6."""

import numpy as np
import pytest

from support.synthetic_telemetry import NOMINAL_THETA, TRUE_THETA, exact_telemetry, nominal_flight, sample_times
from testbed.assembly.platform import true_platform
from testbed.dynamics.inertia import theta_of
from testbed.estimation.combine import CombinedEstimate
from testbed.estimation.contact import Contact
from testbed.estimation.estimate import EstimationSettings
from testbed.estimation.instrumental_variable import instrumental_variable
from testbed.maneuver.profiles import basic_profile
from testbed.reproduction.zero_g import PAPER_CAD_THETA, PAPER_THETA, SCENARIO, fly_block
from testbed.reproduction.zero_g_coverage import coverage_of
from testbed.reproduction.zero_g_cuts import SHORTEST, Cut, cut_of, cut_score
from testbed.reproduction.zero_g_figures import figure5, figure6
from testbed.reproduction.zero_g_flights import fly_campaigns
from testbed.reproduction.zero_g_startup import treated_estimates
from testbed.scenario.reader import read_scenario
from testbed.scenario.shipped import shipped_scenario
from testbed.signals import SIGNALS

TIMES = sample_times(16.0, 0.0, 3.0)
MOMENTUM_B = np.array([4e-4, -5e-4, 6e-4])
RELEASED = exact_telemetry(nominal_flight(MOMENTUM_B), TIMES, TIMES, gyro_noise=0.001658)
SETTINGS = EstimationSettings(nominal_theta=NOMINAL_THETA, instrument="nominal")
PERIOD = 1.0 / 16.0


def campaign_scenario():
    """The shipped one, but for a maneuver that needs no design and leaves the gimbals open."""
    scenario = read_scenario(shipped_scenario(SCENARIO))
    steering = scenario.controller.steering.model_copy(update={"preferred_gimbal_angle_rad": "zero"})
    controller = scenario.controller.model_copy(update={"steering": steering})
    return scenario.model_copy(update={"controller": controller})


SCENARIO_FLOWN = campaign_scenario()
MANEUVER = basic_profile(duration=5.0, scale=1.5)


@pytest.fixture(scope="module")
def flights():
    """Two campaigns of three flights."""
    return [campaign.flights for campaign in fly_campaigns(SCENARIO_FLOWN, MANEUVER, [1, 2], 3)]


def test_the_scenario_is_table_3():
    scenario = read_scenario(shipped_scenario(SCENARIO))
    np.testing.assert_allclose(theta_of(true_platform(scenario).inertia), PAPER_THETA, atol=1e-12)
    np.testing.assert_allclose(theta_of(np.array(scenario.platform.inertia_kg_m2)), PAPER_CAD_THETA)
    assert scenario.gyro.sample_rate_hz == 16.0
    assert scenario.gyro.noise_rad_s == pytest.approx(np.deg2rad(0.095), rel=1e-3)


def test_flights_are_cut_before_their_contact_by_their_own_records(flights):
    for flight in (flight for campaign in flights for flight in campaign):
        assert flight.contact is not None
        assert flight.onset is not None
        assert flight.record.details.usable_to == flight.contact.last_free
        # Not a sample later than the contact, and at most one given away besides the one that is cut in two.
        assert flight.onset - 2 * PERIOD - 1e-9 <= flight.telemetry.gyro_time[-1] < flight.onset
        assert flight.usable >= SHORTEST
        assert all(SIGNALS[name].telemetry for name in flight.record.channels)


def test_a_campaign_does_not_depend_on_its_neighbours(flights):
    (alone,) = fly_campaigns(SCENARIO_FLOWN, MANEUVER, [2], 3)
    for mine, other in zip(alone.flights, flights[1], strict=True):
        assert mine.seed == other.seed
        np.testing.assert_array_equal(mine.telemetry.body_rate, other.telemetry.body_rate)
    assert {flight.seed for flight in flights[0]}.isdisjoint(flight.seed for flight in flights[1])


def test_flights_too_short_are_flown_again_and_their_cuts_are_judged_too(flights, monkeypatch):
    shortest = min(flight.usable for flight in flights[0][:2])
    monkeypatch.setattr("testbed.reproduction.zero_g_flights.SHORTEST", shortest + 0.01)
    (campaign,) = fly_campaigns(SCENARIO_FLOWN, MANEUVER, [1], 2)
    assert len(campaign.flights) == 2
    assert min(flight.usable for flight in campaign.flights) > shortest
    assert len(campaign.cuts) >= 3
    assert shortest in [cut.usable for cut in campaign.cuts]


def test_a_block_gives_estimates_near_the_truth():
    (outcome,) = fly_block(SCENARIO_FLOWN, MANEUVER, [1])
    for name in ("iv", "output_error"):
        combined = outcome.combined[name]
        assert np.abs((combined.theta - PAPER_THETA) / combined.std).max() < 4.0  # one seed, fixed
    assert len(outcome.cuts) == len(outcome.usable) == 5


def test_cuts_are_judged_by_the_samples_on_either_side_of_the_contact():
    def late(last_free, onset):
        contact = None if last_free is None else Contact(last_free=last_free, first_seen=9.0, rate_jump_B=np.zeros(3))
        return cut_of(TIMES, contact, onset).late

    onset = TIMES[20] - 0.01
    assert [late(TIMES[index], onset) for index in (18, 19, 20, 24)] == [-1, 0, 1, 5]
    assert late(None, onset) == len(TIMES) - 20
    assert late(None, None) == 0
    assert late(TIMES[-4], None) == -3


def test_cuts_are_counted_by_what_is_wrong_with_them():
    cuts = [Cut(usable=3.0, late=late, touched=True) for late in (0, -1, 1, 2, 9, -5)]
    score = cut_score([*cuts, Cut(usable=1.9, late=0, touched=False)])
    assert (score.flights, score.touched, score.too_short) == (7, 6, 1)
    assert (score.missed, score.one_late, score.one_early, score.false_alarms) == (2, 1, 1, 1)


def test_the_start_taken_from_an_exact_first_sample_is_exact_and_taken_for_zero_is_not():
    exact = instrumental_variable(RELEASED, SETTINGS)
    treated = treated_estimates(RELEASED, SETTINGS)
    # 16 Hz interpolation, as for the estimator itself.
    np.testing.assert_allclose(treated["iv_from_first_sample"].theta, TRUE_THETA, atol=5e-7)
    np.testing.assert_allclose(exact.theta, TRUE_THETA, atol=5e-7)
    assert np.abs(treated["iv_from_zero"].theta - TRUE_THETA).max() > 1e-4


def test_at_rest_all_treatments_agree():
    at_rest = exact_telemetry(nominal_flight(), TIMES, TIMES, gyro_noise=0.001658)
    for estimate in treated_estimates(at_rest, SETTINGS).values():
        np.testing.assert_allclose(estimate.theta, TRUE_THETA, atol=5e-7)


def test_coverage_of_honest_and_of_boastful_estimates():
    rng = np.random.default_rng(5)
    std = 1e-5 * np.arange(1.0, 7.0)
    thetas = TRUE_THETA + std * rng.standard_normal((400, 6))
    honest = coverage_of([CombinedEstimate(theta=theta, covariance=np.diag(std**2)) for theta in thetas], TRUE_THETA)
    assert honest.overall_share == pytest.approx(0.95, abs=4 * np.sqrt(0.95 * 0.05 / 2400))
    assert np.all((honest.share_band[:, 0] < honest.share) & (honest.share < honest.share_band[:, 1]))
    np.testing.assert_allclose(honest.std, std, rtol=4 / np.sqrt(800))  # a standard deviation of 400: 1/sqrt(2 n)
    boastful = coverage_of(
        [CombinedEstimate(theta=theta, covariance=np.diag(std**2) / 4) for theta in thetas], TRUE_THETA
    )
    assert boastful.overall_share == pytest.approx(0.673, abs=0.04)  # P(|z| < 0.98)


def test_figure_6_closes_with_the_truth_and_not_with_another_inertia():
    figure = figure6(RELEASED, TRUE_THETA, NOMINAL_THETA, 0.8)
    assert figure.measured_B.shape == figure.estimated_B.shape == (len(TIMES), 3)
    np.testing.assert_allclose(figure.measured_B[0], 0.0, atol=1e-12)  # the filter starts from zero on both sides
    assert figure.estimated_misfit < 1e-4
    assert figure.nominal_misfit > 0.01


def test_figure_5_is_what_was_sent():
    figure = figure5(RELEASED)
    np.testing.assert_array_equal(figure.body_rate, RELEASED.body_rate)
    # Six rotors cannot hold more.
    assert np.linalg.norm(figure.cluster_momentum_B, axis=1).max() < 6 * 0.0052
