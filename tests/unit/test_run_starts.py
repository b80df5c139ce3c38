"""Logs of applied torques that were switched on in the middle of a motion: what acted before still shows."""

from __future__ import annotations

import numpy as np
import pytest

from support.vectors import cross
from testbed.assembly.platform import nominal_body
from testbed.diagnosis.findings import additions
from testbed.diagnosis.method import diagnosed
from testbed.diagnosis.reading import data_set_of
from testbed.dynamics.inertia import theta_of
from testbed.effects.registry import EFFECTS
from testbed.records.record import Record, RunDetails
from testbed.scenario.reader import read_body_scenario
from testbed.scenario.shipped import shipped_scenario

SHIPPED = read_body_scenario(shipped_scenario("crazypad"))
SCENARIO = SHIPPED.model_copy(update={"diagnosis": type(SHIPPED.diagnosis)(applied_torque="held")})
NOMINAL = nominal_body(SCENARIO)
INVERSE = np.linalg.inv(NOMINAL.inertia)
STEP, READ, EVERY = 1e-3, 10, 200
"""s of the integration, and of such steps from one gyro sample, and from one torque, to the next."""
SIGMA = 0.005
LAG = 0.03
LATE = ("actuator_lag", "gyro_bandwidth", "gyro_latency", "contact")


def flight(seed: int, *, slow: str, begin: float, length: float = 8.0) -> Record:
    """Return a record of jets that switch five times a second, with a lag in them or a low-pass in the gyro.

    Its logger is switched on so many seconds after the release.
    """
    rng, count = np.random.default_rng(seed), int((begin + length) / STEP)
    asked = np.repeat(1e-5 * rng.choice([-1.0, 0.0, 1.0], (count // EVERY + 1, 3)), EVERY, axis=0)[:count]
    kept = np.exp(-STEP / LAG)
    torque, rate, shown, rates = np.zeros(3), np.zeros(3), np.zeros(3), np.empty((count, 3))
    for index in range(count):
        rates[index] = shown if slow == "gyro" else rate
        torque = kept * torque + (1.0 - kept) * asked[index] if slow == "actuators" else asked[index]
        rate = rate + STEP * INVERSE @ (torque - cross(rate, NOMINAL.inertia @ rate))
        shown = kept * shown + (1.0 - kept) * rate
    rows = np.arange(int(begin / STEP), count, READ)
    sent = np.where((rows % EVERY == 0)[:, None], asked[rows], np.nan)
    return Record(
        time=rows * STEP - begin,
        channels={"body_rate": rates[rows] + SIGMA * rng.standard_normal((len(rows), 3)), "applied_torque": sent},
        details=RunDetails(name=f"flight_{seed}", gyro_noise=SIGMA),
    )


@pytest.mark.parametrize("begin", [0.0, 1.0])
@pytest.mark.parametrize(("slow", "name"), [("actuators", "actuator_lag"), ("gyro", "gyro_bandwidth")])
def test_what_acted_before_the_log_has_no_name(slow, name, begin):
    """A lag was a low-pass of the gyro with P = 1.000, beside a touch before the record and three kinds of noise."""
    data = data_set_of([flight(seed, slow=slow, begin=begin) for seed in range(60, 64)], SCENARIO, NOMINAL)
    effects = {each: EFFECTS[each] for each in LATE}
    *_, state = diagnosed(data.runs, data.heldout, effects, theta_of(NOMINAL.inertia))
    (added,) = additions(state)
    assert name in {added.effect.id, *(each.effect.id for each in added.look_alikes)}
    (constant,) = state.model.effect_values
    assert constant == pytest.approx(LAG, abs=1e-3)


def test_runs_from_rest_are_compared_from_their_first_sample():
    runs = data_set_of([flight(seed, slow="", begin=0.0) for seed in range(3)], SCENARIO, NOMINAL).runs
    assert all(run.gyro_time[0] == run.begin == 0.0 for run in runs.grid.runs)


def test_of_runs_that_begin_moving_the_first_quarter_of_a_second_is_followed_and_not_compared():
    flights = [flight(seed, slow="", begin=begin) for seed, begin in ((0, 0.0), (1, 1.0), (2, 2.0))]
    runs = data_set_of(flights, SCENARIO, NOMINAL).runs
    assert all(run.begin == 0.0 for run in runs.grid.runs)
    assert [run.gyro_time[0] for run in runs.grid.runs] == pytest.approx(len(runs.names) * [0.25], abs=1e-9)
    np.testing.assert_allclose(runs.grid.node_time[:, 0], 0.0, atol=1e-12)
