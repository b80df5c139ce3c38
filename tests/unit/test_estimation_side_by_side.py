"""Flights side by side: each answers as if it were alone, to the last bit, whoever is beside it."""

from dataclasses import replace

import numpy as np
import pytest

from support.synthetic_telemetry import DURATION, NOMINAL_THETA, exact_telemetry, nominal_flight, sample_times
from testbed.errors import InputError
from testbed.estimation import side_by_side as side_by_side_room
from testbed.estimation.actuation import actuation
from testbed.estimation.estimate import EstimationSettings
from testbed.estimation.motion import LONGEST_STEP
from testbed.estimation.registry import ESTIMATORS, SIDE_BY_SIDE
from testbed.estimation.side_by_side import answers_side_by_side, side_by_side
from testbed.estimation.slow_bias import SlowBias

TIMES = sample_times(16.0)
EXACT = exact_telemetry(nominal_flight(), TIMES, TIMES, 0.025)
RNG = np.random.default_rng(20)
FLIGHTS = [replace(EXACT, body_rate=EXACT.body_rate + 0.025 * RNG.standard_normal((len(TIMES), 3))) for _ in range(5)]
SETTINGS = EstimationSettings(nominal_theta=NOMINAL_THETA)


def likewise(**changes):
    return [replace(flight, **changes) for flight in FLIGHTS]


def numbers(estimate):
    names = ("theta", "covariance", "initial_momentum_B", "constant_torque", "residual", "influence", "iterations")
    return {name: getattr(estimate, name) for name in names}


def answers(name, flights, settings=SETTINGS):
    def alone(index):
        try:
            return ESTIMATORS[name](flights[index], settings)
        except InputError as error:
            return str(error)

    return answers_side_by_side(flights, lambda each, _: SIDE_BY_SIDE[name](each, settings), alone)


@pytest.mark.parametrize("name", SIDE_BY_SIDE)
@pytest.mark.parametrize(
    "flights",
    [
        likewise(initial_momentum="zero"),
        likewise(),
        likewise(constant_torque="both", applied_torque=np.full((len(TIMES), 3), 1e-5)),
        likewise(gimbals=None, cluster_momentum=actuation(EXACT, TIMES).cluster_momentum_B),
        likewise(slow_bias=SlowBias(instability=0.01, correlation_time=2.0, random_walk=0.02)),
    ],
    ids=["zero momentum", "momentum", "torques", "actuators that leave the inertia alone", "a bias that wanders"],
)
def test_a_flight_answers_as_if_alone(name, flights):
    together = SIDE_BY_SIDE[name](side_by_side(tuple(flights)), SETTINGS)
    some = SIDE_BY_SIDE[name](side_by_side((flights[3], flights[1])), SETTINGS)
    for estimate, same in zip([*together, *some], [*flights, flights[3], flights[1]], strict=True):
        for key, value in numbers(ESTIMATORS[name](replace(same), SETTINGS)).items():
            np.testing.assert_array_equal(getattr(estimate, key), value, err_msg=key)


def test_a_flight_without_an_answer_says_why_and_leaves_the_others_theirs():
    still = np.zeros_like(EXACT.body_rate)
    mixed = [FLIGHTS[0], replace(FLIGHTS[1], body_rate=still), *FLIGHTS[2:]]
    found = answers("output_error", mixed)
    assert "the gyro reads exactly zero throughout" in found[1]
    usual = answers("output_error", FLIGHTS)
    for index in (0, 2, 3, 4):
        np.testing.assert_array_equal(found[index].theta, usual[index].theta)


def test_no_more_than_fit_into_the_memory_stand_side_by_side(monkeypatch):
    usual = answers("iv_momentum", FLIGHTS)
    sizes = []

    def together(flights, which):
        sizes.append(len(which))
        return SIDE_BY_SIDE["iv_momentum"](flights, SETTINGS)

    monkeypatch.setattr(side_by_side_room, "MOST_INSTANTS", int(2.5 * DURATION / LONGEST_STEP))
    few = answers_side_by_side(FLIGHTS, together, lambda index: ESTIMATORS["iv_momentum"](FLIGHTS[index], SETTINGS))
    assert sizes == [2, 2]
    for estimate, same in zip(few, usual, strict=True):
        np.testing.assert_array_equal(estimate.theta, same.theta)


def test_flights_that_are_not_alike_are_not_put_side_by_side():
    other = sample_times(16.0, 1.0, 4.5)
    unlike = [
        FLIGHTS[0],
        exact_telemetry(nominal_flight(), other, TIMES, 0.025),
        replace(FLIGHTS[1], gyro_noise=0.02),
        FLIGHTS[2],
    ]
    found = answers("iv_momentum", unlike)
    for estimate, flight in zip(found, unlike, strict=True):
        np.testing.assert_array_equal(estimate.theta, ESTIMATORS["iv_momentum"](flight, SETTINGS).theta)
