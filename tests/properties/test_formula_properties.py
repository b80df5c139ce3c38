"""The simulation and the prediction evaluate one expression: random formulas turn a body alike in both."""

import numpy as np
import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from support.formulas import STEP, in_mujoco, laws, patterns, predicted_rates
from testbed.formulas.parser import parsed
from testbed.formulas.pattern import pattern_of

ALIKE = 1e-8
"""rad/s, of changes of up to 1 rad/s; most are alike to 1e-14, those that read the attitude to 2e-9."""
LONG_STEPS = 1e-7
"""rad/s, as without formulas (`testbed.prediction.grid.LONGEST_STEP`)."""
GENERATE = (Phase.explicit, Phase.generate)
"""Examples take a second; to make a failing one smaller would take minutes."""
RATES = st.tuples(*[st.floats(-1.0, 1.0)] * 3).map(np.array)


def assert_alike(pattern, rate, size):
    sizes = size * np.array([1.0, -0.7, 0.4])[: len(pattern.axes)]
    flown, predicted = in_mujoco(pattern, sizes, rate), predicted_rates(pattern, sizes, rate)
    np.testing.assert_allclose(predicted, flown, atol=ALIKE)


@given(pattern=patterns(), rate=RATES, size=st.floats(-2e-2, 2e-2))
@settings(max_examples=20, deadline=None, phases=GENERATE)
def test_mujoco_and_the_prediction_turn_a_body_alike(pattern, rate, size):
    assert_alike(pattern, rate, size)


@given(pattern=patterns(smooth=False), rate=RATES, size=st.floats(-2e-3, 2e-3))
@settings(max_examples=10, deadline=None, phases=GENERATE)
def test_corners_cost_little(pattern, rate, size):
    assert_alike(pattern, rate, size)


@given(law=laws(smooth=False))
def test_the_text_of_a_law_is_read_as_that_law(law):
    assert parsed(str(law)) == law


@given(pattern=patterns(smooth=False))
def test_the_text_of_a_pattern_is_read_as_that_pattern(pattern):
    assert pattern_of(str(pattern)) == pattern


@pytest.mark.parametrize("text", ["w_x*w_y about z", "lag(w_x*R_zx, 0.2) in N", "delay(t, 0.1) about x"])
def test_the_longest_steps_of_predictions_are_short_enough(text):
    """A body at 1 rad/s: the grid of a diagnosis has steps of 1/64 s."""
    pattern, rate = pattern_of(text), np.array([0.6, -0.8, 0.5])
    sizes = 1e-3 * np.array([1.0, -0.7, 0.4])[: len(pattern.axes)]
    fine, coarse = (predicted_rates(pattern, sizes, rate, step)[-1] for step in (STEP, 1.0 / 64.0))
    np.testing.assert_allclose(coarse, fine, atol=LONG_STEPS)
