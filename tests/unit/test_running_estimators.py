"""What counts as an answer: finite, with a covariance, and the inertia of a body."""

from dataclasses import replace

import numpy as np
import pytest

from support.synthetic_telemetry import NOMINAL_THETA, TRUE_THETA, exact_telemetry, nominal_flight, sample_times
from testbed.estimation.estimate import EstimationSettings
from testbed.estimation.output_error import output_error
from testbed.experiment.running_estimators import doubt_of

TIMES = sample_times(16.0)
ANSWER = output_error(
    exact_telemetry(nominal_flight(), TIMES, TIMES, 0.001658), EstimationSettings(nominal_theta=NOMINAL_THETA)
)
INDEFINITE = np.eye(6) * 1e-10
INDEFINITE[0, 1] = INDEFINITE[1, 0] = 2e-10


def test_an_answer_is_not_doubted():
    assert not doubt_of(ANSWER)


@pytest.mark.parametrize(
    "change",
    [
        {"theta": TRUE_THETA * [np.nan, 1, 1, 1, 1, 1]},
        {"covariance": np.full((6, 6), np.inf)},
        {"covariance": np.diag([1.0, 1.0, -1.0, 1.0, 1.0, 1.0]) * 1e-10},
        {"covariance": INDEFINITE},
    ],
)
def test_numbers_that_are_no_estimate_are_no_answer(change):
    """Averaged or written, they would make NaN of the others."""
    assert "no finite inertia" in doubt_of(replace(ANSWER, **change))


def test_a_negative_inertia_is_no_answer():
    assert "check the signs" in doubt_of(replace(ANSWER, theta=-TRUE_THETA))
