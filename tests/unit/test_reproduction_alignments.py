"""The flights that alignments are estimated from: what is built, how it is steered, what is counted."""

from __future__ import annotations

import numpy as np
import pytest

from testbed.assembly.platform import nominal_platform, true_platform
from testbed.cmg.misalignment import misaligned
from testbed.estimation.alignment_observability import parameter_names
from testbed.experiment.aligning import align_flight, aligning_result, true_parameters
from testbed.experiment.flying import fly_maneuver
from testbed.maneuver.gimbal_maneuver import gimbal_maneuver
from testbed.maneuver.splines import clamped_spline
from testbed.reproduction.alignment_flights import as_built, fly_block, pseudo_inverse_scenario
from testbed.reproduction.alignments import SCENARIO
from testbed.scenario.reader import read_scenario
from testbed.scenario.shipped import shipped_scenario

SHIPPED = read_scenario(shipped_scenario(SCENARIO))


@pytest.fixture(scope="module")
def maneuver():
    """Null motion that nobody designed: 10 s of random splines, gentle enough to be flown."""
    nominal = nominal_platform(SHIPPED)
    angle = np.random.default_rng(1).uniform(-1.0, 1.0, (14, 6))
    angle[:2], angle[-1] = 0.0, angle[-2]
    spline = clamped_spline(10.0, angle)
    return gimbal_maneuver(
        "random", spline, inertia=nominal.inertia, cluster=nominal.cluster, total_momentum_B=np.zeros(3)
    )


def test_platforms_are_built_as_drawn_and_their_truth_is_reported():
    built, nominal = as_built(SHIPPED, 5), nominal_platform(SHIPPED)
    truth = true_platform(built)
    drawn = np.array(built.truth.gimbal_axis_misalignment_rad)
    np.testing.assert_allclose(truth.cluster.spin_axis_B, misaligned(nominal.cluster, drawn).spin_axis_B, atol=1e-12)
    true_values = dict(zip(parameter_names(6), true_parameters(built, nominal, truth), strict=True))
    assert true_values["axis about t of cmg4"] == drawn[3, 1]
    assert true_values["encoder zero of cmg6"] == built.encoder.zero_rad[5]
    # The servo holds what its tachometer reads, so that the rotor carries h/(1 + s) where the tachometer says h.
    carried = truth.cluster.rotor_momentum / nominal.cluster.rotor_momentum
    scales = np.array([true_values[f"momentum scale of cmg{unit}"] for unit in range(1, 7)])
    np.testing.assert_allclose(1.0 + scales, carried / carried.mean(), rtol=1e-12)
    assert as_built(SHIPPED, 5) == built
    assert as_built(SHIPPED, 6) != built


@pytest.fixture(scope="module")
def pairs(maneuver):
    return fly_block(SHIPPED, maneuver, [7, 8])


def test_both_steerings_fly_the_same_rates_and_null_motion_tells_more(pairs):
    for pair in pairs:
        for flight in pair:
            assert flight.rate_difference < 0.01  # rad/s, of 0.2
            assert np.nanmax(np.abs(flight.error / flight.std)) < 4.5  # 30 parameters: once in 5,000 flights
            assert flight.null_space[0].startswith("a common scale of J and all rotor momenta")
        null_motion, pseudo_inverse = pair
        assert np.isfinite(null_motion.std).all()
        # So gentle a motion turns the gimbals too little by itself: a direction of many parameters stays open.
        assert len(pseudo_inverse.null_space) == 2
        assert np.isfinite(pseudo_inverse.std).sum() < 10


def test_a_flight_side_by_side_comes_out_as_if_flown_alone(maneuver, pairs):
    """Tachometers of different scale beside each other: each record keeps its own."""
    built, nominal = as_built(SHIPPED, 8), nominal_platform(SHIPPED)
    truth = true_platform(built)
    record = fly_maneuver(built, nominal, truth, maneuver, 8).record
    alone = align_flight(built, nominal, truth, record)
    np.testing.assert_array_equal(alone.estimate.parameters - alone.true_parameters, pairs[1][0].error)


def test_pseudo_inverse_steering_has_no_null_motion():
    steering = pseudo_inverse_scenario(SHIPPED).controller.steering
    assert (steering.law, steering.null_motion_gain_1_s, steering.preferred_gimbal_angle_rad) == (
        "moore_penrose", 0.0, "zero",
    )  # fmt: skip


def test_a_record_that_tells_nothing_says_why(maneuver):
    nominal = nominal_platform(SHIPPED)
    record = fly_maneuver(SHIPPED, nominal, nominal, maneuver, 1).record
    dead = record.channels | {"body_rate": 0.0 * record.channels["body_rate"]}
    aligning = align_flight(SHIPPED, nominal, nominal, type(record)(**(vars(record) | {"channels": dead})))
    result = aligning_result(aligning)
    assert result["parameters"] == {}
    assert "gyro reads exactly zero" in result["message"]
