"""An inertia is shown in a unit that suits the platform."""

from __future__ import annotations

import numpy as np
import pytest

from testbed.dynamics.inertia_unit import inertia_unit, inertia_words
from testbed.report.comparison import ComparedFigures
from testbed.report.wording import decimals_for


@pytest.mark.parametrize(
    ("largest", "text"),
    [(1.9e-5, "1e-6 kg·m²"), (0.027, "1e-3 kg·m²"), (0.927, "1e-3 kg·m²"), (1.2, "kg·m²"), (78.0, "kg·m²")],
)
def test_the_unit_goes_with_the_largest_parameter(largest, text):
    theta = largest * np.array([0.6, 0.8, 1.0, 0.01, -0.02, 0.03])
    assert inertia_unit(theta).text == text
    assert inertia_words(theta, 0.01 * theta).endswith(f" in {text}")


def test_decimals_show_two_digits_of_the_smallest_deviation_in_the_unit():
    large = inertia_unit([40.0, 60.0, 78.0, 1.0, 2.0, 3.0])
    assert decimals_for(np.array([0.034, 0.5]), large) == 3
    assert large.shown(40.01234, 3) == "40.012"
    assert large.shown(-1e-9, 2) == "0.00"


def test_compared_estimates_share_the_unit_of_one_that_is_a_number():
    theta = np.array([41.0, 62.0, 78.0, 1.2, -2.1, 0.4])
    rows = {"lost": np.full(6, np.nan), "far": 1e6 * theta, "found": theta}
    figures = ComparedFigures(estimator="iv", figure="estimate", rows=rows, stds=dict.fromkeys(rows, 0.1 * theta))
    assert figures.unit == "kg·m²"
    assert next(figures.cells("found")) == "41.0000 ± 4.1000"
    assert list(figures.cells("lost")) == ["-"] * 6
