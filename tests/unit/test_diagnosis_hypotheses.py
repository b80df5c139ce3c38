"""What is left to test beside what is in the model."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from support.diagnosed_records import nominal, records
from support.wheel_telemetry import commanded_wheels
from testbed.diagnosis.data import runs_of
from testbed.diagnosis.detectable import confounded
from testbed.diagnosis.method import diagnosed
from testbed.diagnosis.model import Hypothesis
from testbed.diagnosis.reading import data_set_of
from testbed.diagnosis.result import unconfounded_needs
from testbed.diagnosis.testable import hypotheses, without
from testbed.dynamics.inertia import theta_of
from testbed.effects.contract import CLUSTER, components_in
from testbed.effects.registry import EFFECTS


def placed(effect: str, component: str) -> Hypothesis:
    return Hypothesis(effect=EFFECTS[effect], component=component)


def left_beside(*chosen: Hypothesis) -> set[str]:
    every = [Hypothesis(effect=each, component=at) for each in EFFECTS.values() for at in components_in(each, 6)]
    return {each.key for each in every} - {each.key for each in without(every, chosen)}


def test_what_is_in_the_model_is_not_tested_again():
    assert left_beside(placed("viscous_drag", "platform")) == {"viscous_drag:platform"}


@pytest.mark.parametrize(
    ("effect", "confounded"),
    [
        ("gimbal_backlash", {"gimbal_lag", "gimbal_viscous_friction", "gimbal_coulomb_friction"}),
        ("gimbal_coulomb_friction", {"gimbal_lag"}),
    ],
)
def test_what_a_unit_cannot_show_beside_an_effect_is_not_tested_there(effect, confounded):
    taken = left_beside(placed(effect, "cmg4"))
    expected = {f"{each}:{place}" for each in confounded for place in ("cmg4", CLUSTER)}
    known = {f"{each}:{place}" for each in confounded for place in components_in(EFFECTS[each], 6)}
    assert taken == (expected & known) | {f"{effect}:cmg4"}
    assert "gimbal_lag:cluster" in taken


def test_what_was_not_asked_of_beside_an_effect_is_said_with_what_it_would_take():
    scenario, platform = nominal()
    data = data_set_of(records(3), scenario, platform)
    stages = list(
        diagnosed(data.runs, data.heldout, {"viscous_drag": EFFECTS["viscous_drag"]}, theta_of(platform.inertia))
    )
    rough, lag = placed("gimbal_coulomb_friction", "cmg4"), placed("gimbal_lag", "cluster")
    asked = replace(stages[-1].remaining, signatures=(replace(stages[-1].remaining.signatures[0], placed=lag),))
    sticking = replace(stages[-1], remaining=asked, model=replace(stages[-1].model, placed=(rough,)))
    assert confounded(stages[-1]) == ()
    assert confounded(sticking) == ((lag, rough),)
    assert unconfounded_needs(rough).startswith("cmg4 without gimbal_coulomb_friction")


def in_doubt(runs) -> set[str]:
    """Return the effects that are not tested for, but may be there."""
    return {each.effect for each in hypotheses(runs, EFFECTS)[1] if each.keeps_share}


def test_what_a_platform_has_no_units_for_takes_no_share_from_what_looks_like_it():
    wheels = runs_of(["run"], [commanded_wheels(0.0, seed=1)])
    scenario, platform = nominal()
    gyros = data_set_of(records(3), scenario, platform).runs
    assert {"gimbal_misalignment", "actuator_gain", "wheel_torque_scale"}.isdisjoint(in_doubt(wheels))
    assert {"wheel_misalignment", "wheel_inertia", "actuator_gain"}.isdisjoint(in_doubt(gyros))
    of_itself = [
        replace(run, gimbals=None, cluster_momentum=np.zeros((len(run.actuator_time), 3))) for run in gyros.grid.runs
    ]
    assert {"gimbal_misalignment", "wheel_misalignment"} <= in_doubt(
        runs_of([str(each) for each in range(len(of_itself))], of_itself)
    )


def test_a_torque_on_a_body_without_momentum_leaves_no_unit_in_doubt():
    """A gyro turned by 5 degrees had a third of the probability, and gimbals and wheels that nobody has the others."""
    scenario, platform = nominal()
    runs = data_set_of(records(3), scenario, platform).runs.grid.runs
    pushed = [replace(run, gimbals=None, applied_torque=np.ones((len(run.actuator_time), 3))) for run in runs]
    doubted = in_doubt(runs_of([str(each) for each in range(len(pushed))], pushed))
    assert {"gimbal_misalignment", "wheel_misalignment", "rotor_speed"}.isdisjoint(doubted)
    assert "actuator_weak" in doubted
