"""The grammar of torque laws: what is read, what is refused and how, units, and the scenario's tables."""

import numpy as np
import pytest

from support.flown_effects import scenario
from testbed.errors import InputError
from testbed.experiment.conduct import conduct
from testbed.formulas.motion import Moment
from testbed.formulas.parser import parsed
from testbed.formulas.pattern import contains, pattern_of
from testbed.scenario.scenario import Scenario

AT = Moment(
    time=np.array(2.0),
    body_rate=np.array([0.3, -0.4, 1.2]),
    attitude=np.arange(9.0).reshape(3, 3),
    gimbal_angle=np.array([0.1, 0.2]),
    gimbal_rate=np.array([1.0, -3.0]),
    elapsed=np.array(8.0),
    applied_torque=np.array([0.2, -0.5, 0.0]),
)


@pytest.mark.parametrize(
    ("text", "value", "unit"),
    [
        ("1", 1.0, "N·m"),
        ("t", 2.0, "N·m/s"),
        ("w_x*w_y", -0.12, "N·m·s²/rad²"),
        ("norm(w)*w_z", 1.3 * 1.2, "N·m·s²/rad²"),
        ("|w_y|*w_y", -0.16, "N·m·s²/rad²"),
        ("w_x^3", 0.027, "N·m·s³/rad³"),
        ("R_zx", 6.0, "N·m"),
        ("sin(gimbal_2)*w_x", np.sin(0.2) * 0.3, "N·m·s/rad"),
        ("gimbal_rate_2*w_x", -0.9, "N·m·s²/rad²"),
        ("cos(2*pi*0.25*t)", -1.0, "N·m"),
        ("pulse(2, 0.1)", 1.0, "N·m"),
        ("once(7.9, 0.1)", np.exp(-0.5), "N·m"),
        ("torque_y", -0.5, "1"),
        ("|torque_y|*torque_y", -0.25, "1/N·m"),
    ],
)
def test_a_law_has_its_value_and_unit(text, value, unit):
    law = parsed(text)
    assert law.value(AT, np.zeros(0), {}) == pytest.approx(value)
    assert str(law.coefficient_unit) == unit


def test_laws_that_say_the_same_are_equal():
    assert parsed("w_y * w_x") == parsed("w_x*w_y")
    assert parsed("w_x^2*t") == parsed("w_x*t*w_x")
    assert parsed("|w|*w_x") == parsed("w_x*norm(w)")
    assert parsed("lag(w_x, 0.30)") == parsed("lag(w_x,0.3)") != parsed("lag(w_x, 0.31)")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("w_q*w_y", "character 1: 'w_q' is no quantity; did you mean w_z?"),
        ("abs(abs(w_x))", "character 5: 'abs' in a function; a function takes one quantity"),
        ("w_x * 3", "character 7: the number 3; put it into the coefficient"),
        ("gimbal_0", "character 1: 'gimbal_0' is no quantity; gimbals are counted from 1"),
        ("w_x+w_y", "character 4: '+' after the end of the formula; a sum is several tables"),
        ("lag(w_x)", "character 8: ')'; write ',' there"),
        ("w_x*w_x*w_x*w_x", "a product of 4 factors; write at most 3"),
        ("__import__('os')", "character 1: '_' stands in no formula"),
        ("lag(w_x, tau)", "character 10: 'tau' in the place of a constant"),
        ("sin(w_x)", "write sin(2*pi*0.8*t) or sin(gimbal_1)"),
        ("", "it ends where a quantity is missing"),
        ("w_x*" * 100, "a formula of 400 characters: write at most 200"),
    ],
)
def test_what_is_no_formula_is_refused_with_its_place(text, said):
    with pytest.raises(InputError) as refused:
        parsed(text)
    assert said in str(refused.value)


def test_a_lag_settles_to_its_product_and_a_delay_keeps_a_slow_one_back():
    for text, expected in (("lag(w_x, 0.1)", 0.3), ("delay(w_x, 0.1)", 0.3), ("hysteresis(w_y, 0.05)", -1.0)):
        law, state = parsed(text), np.full(2, 0.1)[: parsed(text).states]
        for _ in range(4000):
            state = state + 1e-3 * law.state_rate(AT, state, {})
        assert law.value(AT, state, {}) == pytest.approx(expected)


def test_derivatives_by_complex_steps_are_those_by_differences():
    pattern = pattern_of("lag(norm(w)*w_x, tau) in N")
    value, state = np.array([[0.3, 1.0, -2.0, 0.5]]), np.array([[0.2]])
    for index in range(4):
        step = np.eye(4)[index]
        exact = pattern.torque(value + 1e-20j * step, AT, state).imag / 1e-20
        exact_rate = pattern.state_rate(value + 1e-20j * step, AT, state).imag / 1e-20
        ahead, back = (pattern.torque(value + side * step, AT, state) for side in (1e-6, -1e-6))
        rate_ahead, rate_back = (pattern.state_rate(value + side * step, AT, state) for side in (1e-6, -1e-6))
        np.testing.assert_allclose(exact, (ahead - back) / 2e-6, atol=1e-8)
        np.testing.assert_allclose(exact_rate, (rate_ahead - rate_back) / 2e-6, rtol=1e-6, atol=1e-8)


def with_torques(*torques):
    keys = scenario().model_dump(by_alias=True, exclude_unset=True)
    return Scenario.model_validate(keys | {"truth": {"torque": list(torques)}})


def test_a_scenario_flies_its_formulas():
    keys = {"formula": "w_x*w_y", "axis": "z", "coefficient": 2e-3}
    plain, none, some = (
        conduct(each, seed=1).flown.record.channels["true_body_rate"].copy()
        for each in (scenario(), with_torques(keys | {"coefficient": 0.0}), with_torques(keys))
    )
    np.testing.assert_allclose(none, plain, atol=1e-12)  # MuJoCo's own stages are taken here one by one
    assert 1e-4 < np.abs(some - plain).max() < 1e-1


@pytest.mark.parametrize(
    ("keys", "said"),
    [
        ({"formula": "w_q", "axis": "z", "coefficient": 1.0}, "did you mean w_"),
        ({"formula": "gimbal_7", "axis": "z", "coefficient": 1.0}, "reads gimbal 7, but there are 6"),
        ({"formula": "1", "axis": [1.0, 1.0, 0.0], "coefficient": 1.0}, "length"),
        ({"formula": "1", "axis": "w", "coefficient": 1.0}, "'x', 'y' or 'z'"),
    ],
)
def test_a_scenario_refuses_what_it_cannot_fly(keys, said):
    with pytest.raises(ValueError, match=said):
        with_torques(keys)


@pytest.mark.parametrize(
    ("wider", "narrower", "expected"),
    [
        ("w_x*w_y in B", "w_x*w_y about z", True),
        ("lag(w_x, tau) in B", "w_x about z", True),
        ("delay(w_x, late) about z", "w_x about z", True),
        ("w_x*w_y about z", "w_x*w_y in B", False),
        ("w_x*w_y in N", "w_x*w_y about z", False),
        ("hysteresis(w_x, stretch) about z", "w_x about z", False),
        ("w_x about z", "w_x about z", False),
        ("w_x in B", "w_y about z", False),
    ],
)
def test_a_formula_contains_those_that_it_becomes_where_parameters_vanish(wider, narrower, expected):
    assert contains(pattern_of(wider), pattern_of(narrower)) is expected
