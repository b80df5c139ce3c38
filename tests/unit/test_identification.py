"""From measured records to the inertia: what is assumed is tested, what does not agree is not combined in green."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from support.diagnosed_records import nominal, records
from testbed.dynamics.inertia import theta_of
from testbed.errors import InputError
from testbed.identification.identify import LONGEST_GATED, _looked_at, identify
from testbed.report.measured import identification_doubts, identification_verdict
from testbed.scenario.diagnosis import Diagnosis


@pytest.fixture(scope="module")
def sound():
    """Three runs of the nominal platform, released with a rate."""
    return records(3, seed=11)


def identified(used, **estimation):
    scenario, platform = nominal()
    changed = scenario.estimation.model_copy(update=estimation)
    return identify(scenario.model_copy(update={"estimation": changed}), platform, used)


def doubts(identification):
    return list(identification_doubts(identification))


def scaled(record, factor):
    """The record of a platform whose inertia is larger by a factor: it turns less by as much, from rest."""
    return replace(record, channels=record.channels | {"body_rate": record.channels["body_rate"] / factor})


def verdict(identification):
    return identification_verdict(identification, theta_of(nominal()[1].inertia))


def test_sound_records_are_combined_in_green(sound):
    found = identified(sound)
    assert doubts(found) == []
    assert verdict(found).tone == "good"
    error = np.abs(found.combined.by_name["output_error"].theta - theta_of(nominal()[1].inertia))
    assert np.all(error < 4.0 * found.combined.by_name["output_error"].std)


def test_a_zero_momentum_that_is_none_is_refused_and_estimated(sound):
    found = identified(sound, initial_momentum="zero")
    released = [name for name, each in found.estimations.items() if each.initial_momentum == "estimated"]
    assert released
    assert any("which this record refuses" in notice for notice in found.notices)
    error = np.abs(found.combined.by_name["output_error"].theta - theta_of(nominal()[1].inertia))
    assert np.all(error < 4.0 * found.combined.by_name["output_error"].std)


@pytest.mark.parametrize(
    ("factor", "says"),
    [
        (30.0, "The inertia that output error estimates is 30 times smaller than the nominal one about every axis"),
        (1.0 / 30.0, "estimates is 30 times larger than the nominal one about every axis: probably another body"),
        (1.9, None),
    ],
)
def test_an_inertia_far_from_the_nominal_one_is_in_doubt_by_name(sound, factor, says):
    found = identified(sound)
    other = replace(found, nominal_theta=factor * found.combined.by_name["output_error"].theta)
    said = doubts(other)
    if says is None:
        assert said == []
    else:
        assert len(said) == 1
        assert says in said[0]
        assert verdict(other).tone == "warn"
    assert doubts(replace(other, nominal_theta=None)) == []


def test_a_scenario_that_accepts_another_inertia_is_not_doubted(sound):
    scenario, platform = nominal()
    accepting = scenario.model_copy(update={"diagnosis": Diagnosis(accept=("inertia",))})
    assert identify(accepting, platform, sound[:1]).nominal_theta is None
    assert identified(sound[:1]).nominal_theta is not None


def test_runs_that_differ_are_not_green_and_their_spread_is_in_the_band(sound):
    found = identified([*sound[:2], scaled(sound[2], 1.05)])
    assert verdict(found).tone == "warn"
    assert any("The records differ" in doubt and "testbed diagnose" in doubt for doubt in doubts(found))
    average = found.combined.by_name["output_error"]
    assert np.all(average.std > 1.5 * np.sqrt(np.diag(average.covariance + average.considered @ average.considered.T)))


def test_records_of_no_platform_like_this_give_no_number(sound):
    with pytest.raises(InputError, match="times the scenario's inertia"):
        identified([scaled(record, 3.0) for record in sound])


def test_the_gate_looks_at_the_liveliest_part_of_a_long_record(sound):
    time = np.arange(0.0, 1000.0, 0.1)
    rate = np.zeros((len(time), 3))
    rate[(time > 500.0) & (time < 520.0)] = np.sin(time[(time > 500.0) & (time < 520.0)])[:, None]
    long = replace(sound[0], time=time, channels={"body_rate": rate, "gimbal_angle": np.zeros((len(time), 6))})
    details = _looked_at(long).details
    assert details.usable_to - details.usable_from == LONGEST_GATED
    assert details.usable_from < 500.0 < details.usable_to
    assert _looked_at(sound[0]) is sound[0]
