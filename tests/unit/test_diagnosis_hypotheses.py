"""What is left to test beside what is in the model."""

from __future__ import annotations

import pytest

from testbed.diagnosis.hypotheses import without
from testbed.diagnosis.model import Placed
from testbed.effects.contract import CLUSTER
from testbed.effects.registry import EFFECTS


def placed(effect: str, component: str) -> Placed:
    return Placed(effect=EFFECTS[effect], component=component)


def left_beside(*chosen: Placed) -> set[str]:
    every = [Placed(effect=effect, component=each) for effect in EFFECTS.values() for each in effect.components]
    return {each.key for each in every} - {each.key for each in without(every, chosen)}


def test_what_is_in_the_model_is_not_tested_again():
    assert left_beside(placed("viscous_drag", "platform")) == {"viscous_drag:platform"}


@pytest.mark.parametrize(
    ("effect", "masked"),
    [
        ("gimbal_backlash", {"gimbal_lag", "gimbal_viscous_friction", "gimbal_coulomb_friction"}),
        ("gimbal_coulomb_friction", {"gimbal_lag"}),
    ],
)
def test_what_a_unit_cannot_show_beside_an_effect_is_not_tested_there(effect, masked):
    taken = left_beside(placed(effect, "cmg4"))
    expected = {f"{each}:{place}" for each in masked for place in ("cmg4", CLUSTER)}
    known = {f"{each}:{place}" for each in masked for place in EFFECTS[each].components}
    assert taken == (expected & known) | {f"{effect}:cmg4"}
    assert "gimbal_lag:cluster" in taken
