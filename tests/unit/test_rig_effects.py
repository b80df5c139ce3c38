"""What rigs hide, made by the concealing engine's rig, is named as what it is among what looks like it."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from concealing.rig import Rig
from support.rigs import rig_records, rig_scenario
from testbed.assembly.platform import nominal_body
from testbed.diagnosis.data import runs_of
from testbed.diagnosis.findings import _doubts, additions
from testbed.diagnosis.method import diagnosed
from testbed.diagnosis.reading import data_set_of
from testbed.diagnosis.testable import hypotheses
from testbed.dynamics.inertia import theta_of
from testbed.effects.contract import PLAUSIBLE_PER_INERTIA
from testbed.effects.registry import EFFECTS
from testbed.scenario.diagnosis import Diagnosis

INERTIA = 0.052
FRICTION = ("dry_friction", "viscous_drag", "quadratic_drag", "tether")
TIMING = ("gyro_latency", "gyro_bandwidth", "gyro_averaging", "actuator_lag", "actuator_delay", "telemetry_skew")


@cache
def diagnosis(effects, **hidden):
    """Diagnose three runs of a rig among some effects."""
    scenario = rig_scenario().model_copy(update={"diagnosis": Diagnosis(accept=("telemetry",))})
    nominal = nominal_body(scenario)
    data = data_set_of(rig_records([Rig(inertia=INERTIA, **hidden)] * 3), scenario, nominal)
    wanted = {name: EFFECTS[name] for name in effects}
    *_, last = diagnosed(data.runs, data.heldout, wanted, theta_of(nominal.inertia))
    return last


def first(state):
    added = additions(state)[0]
    return {added.effect.id, *(each.effect.id for each in added.look_alikes)}, added.quantities


def test_dry_friction_is_no_tether():
    state = diagnosis(FRICTION, dry=4e-3)
    names, (torque, *_) = first(state)
    assert names == {"dry_friction"}
    assert torque.name == "torque_z_N_m"
    assert torque.value == pytest.approx(4e-3, rel=5e-3)
    assert len(state.steps) == 1
    assert state.model.theta[2] == pytest.approx(INERTIA, rel=5e-3)


def test_viscous_friction_is_no_dry_one():
    assert first(diagnosis(FRICTION, viscous=3e-3))[0] == {"viscous_drag"}


@pytest.mark.parametrize("late", [0.031, -0.031])
def test_telemetry_that_is_late_or_early_is_telemetry_skew(late):
    state = diagnosis(TIMING, late=late)
    assert "telemetry_skew" in first(state)[0]
    skew = next(each for each in state.steps[0].screening.candidates if each.effect.id == "telemetry_skew")
    assert skew.fit.effect_values[0] == pytest.approx(late, abs=1e-3)
    assert state.gap.fit < 1.2


def test_late_telemetry_is_nothing_that_is_late_only():
    assert first(diagnosis(TIMING, late=0.031))[0] == {"telemetry_skew"}


def test_a_slow_wheel_is_an_actuator_lag_and_no_gyro_of_half_a_hertz():
    """Both explain it alike: what decides is that no gyro is as slow, so that it is none of the class either."""
    state = diagnosis(TIMING, lag=0.3)
    added = additions(state)[0]
    assert added.effect.id == "actuator_lag"
    assert not added.look_alikes
    assert added.quantities[0].value == pytest.approx(0.3, rel=0.01)
    assert not added.doubts


def test_a_gyro_of_half_a_hertz_carries_a_warning():
    (added,) = additions(diagnosis(("gyro_bandwidth",), lag=0.3))
    assert "bandwidth_hz = 0.5" in added.doubts[0]
    assert "implausible, as hardware ends at bandwidth_hz = 1.99 Hz" in added.doubts[0]


def test_a_delay_of_less_than_a_sample_is_plausible_whatever_the_rate():
    """A gyro at 2 Hz that was 0.4 s late was doubted, as hardware ends at 0.1 s."""
    state = diagnosis(("telemetry_skew",), late=0.31)
    placed = next(each for each in state.model.placed if each.effect.id == "telemetry_skew")
    (doubt,) = _doubts(state, placed)
    assert "late_s = 0.31 s is implausible, as hardware ends at late_s = 0.2 s" in doubt
    slow = [run.with_gyro_rows(slice(None, None, 10)) for run in state.runs.grid.runs]
    assert not list(_doubts(replace(state, runs=runs_of(state.runs.names, slow)), placed))


def test_a_parameter_at_its_bound_carries_a_warning():
    """A wheel that is later than any that is searched for."""
    added = additions(diagnosis(("actuator_delay",), delay=0.6))[0]
    assert added.quantities[0].value == 0.5
    assert added.doubts == ("delay_s lies at 0.5, where its search ends: the name is what came nearest",)


@pytest.mark.parametrize("effect", [pytest.param(each, id=each.id) for each in EFFECTS.values()])
def test_every_parameter_has_bounds_of_what_is_plausible(effect):
    for parameter in effect.parameters:
        assert np.isfinite(parameter.plausible).all() or parameter.unit in PLAUSIBLE_PER_INERTIA, parameter.name
        assert parameter.is_plausible(parameter.typical)
        assert parameter.is_plausible(parameter.absent)


def test_a_wheel_at_its_greatest_torque_is_named_with_it():
    state = diagnosis((*TIMING, "actuator_rate_limit"), greatest_torque=0.03)
    names, (share, torque) = first(state)
    assert names == {"actuator_rate_limit"}
    assert share.value == pytest.approx(1.0, abs=0.02)
    assert torque.value == pytest.approx(0.03, rel=0.02)


def test_a_gyro_that_averages_is_named_with_all_of_its_period():
    names, (share,) = first(diagnosis(TIMING, averaging=0.05))
    assert names == {"gyro_averaging"}
    assert share.value == pytest.approx(1.0, abs=0.02)


def test_nothing_is_named_of_a_rig_that_is_as_believed():
    assert not diagnosis(TIMING).steps


def test_lag_and_delay_of_actuators_are_tested_on_records_of_their_momentum():
    scenario = rig_scenario()
    runs = data_set_of(rig_records([Rig()] * 3), scenario, nominal_body(scenario)).runs
    testable = {each.effect.id for each in hypotheses(runs, EFFECTS)[0]}
    assert {"actuator_lag", "actuator_delay", "actuator_gain", "telemetry_skew"} <= testable
    assert np.all(runs.inertia_shown == [False, False, True, False, False, False])
