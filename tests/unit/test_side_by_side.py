"""Flights side by side: each as if flown alone, bit for bit; one that diverges leaves the others alone."""

from __future__ import annotations

import numpy as np
import pytest

from testbed.assembly.platform import nominal_platform, true_platform
from testbed.experiment.flying import Sortie, fly_sorties
from testbed.experiment.planning import plan_maneuver
from testbed.scenario.reader import read_scenario
from tests.unit.test_scenario_reader import SHIPPED

SCENARIO = read_scenario(SHIPPED / "basic.toml")
NOMINAL = nominal_platform(SCENARIO)
SHORT = SCENARIO.model_copy(update={"maneuver": SCENARIO.maneuver.model_copy(update={"duration_s": 1.0})})
MANEUVER = plan_maneuver(SHORT, NOMINAL).maneuver


def changed(**sections):
    """The short scenario with some keys of some sections changed."""
    update = {name: getattr(SHORT, name).model_copy(update=keys) for name, keys in sections.items()}
    return SHORT.model_copy(update=update)


HEAVY = ((0.025, 0.001, 0.0), (0.001, 0.021, 0.0), (0.0, 0.0, 0.028))
CASES = (
    (SHORT, 1),
    (changed(truth={"inertia_kg_m2": HEAVY}), 2),
    (changed(gyro={"scale_factor_error": (0.01, -0.02, 0.03), "bias_rad_s": (0.01, 0.0, 0.0)}), 3),
    (changed(initial={"body_rate_rad_s": (0.05, -0.02, 0.01), "velocity_m_s": (0.1, 0.0, 0.0)}), 4),
    (SHORT, 5),
)


def sortie(case) -> Sortie:
    scenario, seed = case
    return Sortie(scenario=scenario, truth=true_platform(scenario), seed=seed)


def alone(case):
    (flown,) = fly_sorties(SHORT, [sortie(case)], NOMINAL, MANEUVER)
    return flown


def same(one, other) -> bool:
    """Whether two flights' records and figures agree in every bit."""
    channels = one.record.channels
    assert channels.keys() == other.record.channels.keys()
    return all(np.array_equal(channels[name], other.record.channels[name], equal_nan=True) for name in channels)


@pytest.mark.parametrize("threads", [1, 2])
@pytest.mark.parametrize("cases", [CASES, CASES[3:], CASES[:1]], ids=["five", "two", "one"])
def test_each_flight_is_as_if_flown_alone(cases, threads):
    together = fly_sorties(SHORT, [sortie(case) for case in cases], NOMINAL, MANEUVER, threads)
    for case, flown in zip(cases, together, strict=True):
        assert same(flown, alone(case))


def test_the_cases_differ():
    """Else the test above would pass with all flights mixed up."""
    first, *others = [alone(case) for case in CASES]
    assert not any(same(first, other) for other in others)


def test_a_flight_that_diverges_ends_there_and_the_others_do_not_notice():
    mad = changed(initial={"body_rate_rad_s": (0.0, 2e4, 0.0)})
    whole, broken, last = fly_sorties(
        SHORT, [sortie(case) for case in (CASES[0], (mad, 2), CASES[4])], NOMINAL, MANEUVER
    )
    assert "diverged between t = 0 s" in broken.divergence
    assert len(broken.record.time) == 1
    for case, flown in ((CASES[0], whole), (CASES[4], last)):
        assert not flown.divergence
        assert same(flown, alone(case))


def test_all_flights_may_diverge():
    mad = changed(initial={"body_rate_rad_s": (0.0, 2e4, 0.0)})
    flown = fly_sorties(SHORT, [sortie((mad, 1)), sortie((mad, 2))], NOMINAL, MANEUVER)
    assert [len(run.record.time) for run in flown] == [1, 1]
