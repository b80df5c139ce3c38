"""Estimates from records with gaps: in a gap the platform turns by what nobody knows."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from testbed.assembly.platform import nominal_platform, true_platform
from testbed.dynamics.inertia import theta_of
from testbed.experiment.flying import fly_maneuver
from testbed.experiment.planning import plan_maneuver
from testbed.identification.identify import Identification, identify
from testbed.records.record import Record
from testbed.scenario.reader import read_scenario
from testbed.scenario.scenario import Scenario
from testbed.scenario.shipped import shipped_scenario

LOST_S = 1.5
ERROR = 4.5
"""Standard deviations: the largest of 24 is beyond them once in six thousand sets."""


def scenario(name: str) -> Scenario:
    """Return a shipped scenario in which what flies is exactly as believed, but for its inertia."""
    shipped = read_scenario(shipped_scenario(name))
    exact = dict.fromkeys(type(shipped.estimation.uncertainty).model_fields, 0.0)
    uncertainty = shipped.estimation.uncertainty.model_copy(update=exact)
    estimators = ("ls", "iv", "iv_momentum", "output_error")
    estimation = shipped.estimation.model_copy(update={"uncertainty": uncertainty, "estimators": estimators})
    return shipped.model_copy(update={"estimation": estimation})


@cache
def flown(name: str) -> Record:
    """Fly it once."""
    believed = scenario(name)
    nominal = nominal_platform(believed)
    maneuver = plan_maneuver(believed, nominal).maneuver
    return fly_maneuver(believed, nominal, true_platform(believed), maneuver, 31).record


def without(record: Record, channels: set[str]) -> Record:
    """Return a record without some channels' samples in a gap in its middle."""
    middle = float(np.mean(record.time[[0, -1]]))
    gone = np.abs(record.time - middle) < 0.5 * LOST_S
    lost = {
        name: np.where(gone[:, None], np.nan, values) if name in channels else values
        for name, values in record.channels.items()
    }
    return replace(record, channels=lost)


def identified(name: str, channels: set[str]) -> Identification:
    believed = scenario(name)
    return identify(believed, nominal_platform(believed), [without(flown(name), channels)])


@pytest.mark.parametrize("lost", ["gyro", "wheels", "both"])
def test_the_parts_beside_a_gap_have_momenta_of_their_own(lost):
    """A second without the gyro put the momentum form off by seven of its standard deviations, and it was good."""
    of_wheels = {name for name in flown("cubesat_wheels").channels if name.startswith("wheel_")}
    channels = {"gyro": {"body_rate"}, "wheels": of_wheels, "both": {"body_rate", *of_wheels}}[lost]
    found = identified("cubesat_wheels", channels)
    truth = theta_of(true_platform(scenario("cubesat_wheels")).inertia)
    for name, estimate in found.combined.by_name.items():
        assert np.abs((estimate.theta - truth) / estimate.std).max() < ERROR, name
    assert [each.details.name.split()[-2:] for each in found.records] == [["part", "1"], ["part", "2"]]
    assert any("parts between them are estimated by themselves" in each for each in found.notices)


def test_where_the_record_refuses_a_momentum_of_zero_its_parts_are_estimated():
    """The last part is too short to be used, and does not bring the whole record back."""
    record, believed = flown("cubesat_wheels"), scenario("cubesat_wheels")
    doubted = believed.model_copy(
        update={"estimation": believed.estimation.model_copy(update={"initial_momentum": "zero"})}
    )
    pushed = {**record.channels, "wheel_speed": record.channels["wheel_speed"] + [60.0, -20.0, 30.0, 0.0]}
    end = record.time[-1]
    gone = (record.time > end - 2.0) & (record.time < end - 0.3)
    pushed["body_rate"] = np.where(gone[:, None], np.nan, pushed["body_rate"])
    found = identify(doubted, nominal_platform(doubted), [replace(record, channels=pushed)])
    (part,) = found.records
    assert part.details.usable_to <= end - 2.0 + 1e-9
    assert found.estimations[part.details.name].initial_momentum == "estimated"


def test_on_a_bearing_what_follows_a_gap_is_left_out():
    """Gravity acts by an attitude that nobody knows behind it."""
    record = flown("air_bearing")
    known = {name: values for name, values in record.channels.items() if name != "attitude"}
    believed = scenario("air_bearing")
    cut = without(replace(record, channels=known), {"body_rate"})
    found = identify(believed, nominal_platform(believed), [cut])
    (part,) = found.records
    assert part.details.usable_to < float(np.mean(record.time[[0, -1]]))
    assert any("nothing says how it stood behind a gap" in each for each in found.notices)
