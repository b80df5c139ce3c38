"""The searches side by side against MINPACK's, one by one."""

import numpy as np
import pytest
import scipy

from testbed.estimation.levenberg_marquardt import minima

TIME = np.linspace(0.0, 3.0, 40)
MEASURED = 3.0 * np.exp(-1.3 * TIME) * np.cos(5.0 * TIME + 0.4) + 0.05 * np.random.default_rng(0).standard_normal(40)
VALLEY = [[-1.2, 1.0], [5.0, -3.0], [100.0, 100.0]]
DECAY = [[1.0, 1.0, 4.5, 0.0], [2.0, 0.1, 5.5, 1.0], [1.0, 3.0, 6.0, 0.0]]


def valley(x):
    return np.array([10.0 * (x[1] - x[0] ** 2), 1.0 - x[0]])


def valley_columns(x):
    return np.array([[-20.0 * x[0], 10.0], [-1.0, 0.0]])


def decay(x):
    return x[0] * np.exp(-x[1] * TIME) * np.cos(x[2] * TIME + x[3]) - MEASURED


def decay_columns(x):
    size, phase = np.exp(-x[1] * TIME), x[2] * TIME + x[3]
    swing, across = size * np.cos(phase), x[0] * size * np.sin(phase)
    return np.stack([swing, -TIME * x[0] * swing, -TIME * across, -across], axis=1)


@pytest.mark.parametrize(
    ("residual", "columns", "starts"),
    [(valley, valley_columns, VALLEY), (decay, decay_columns, DECAY)],
    ids=["valley", "decay"],
)
def test_each_search_goes_the_way_of_minpack(residual, columns, starts):
    """Damped and undamped steps, trials that are not taken, searches of different lengths."""
    found = minima(
        np.array(starts),
        lambda at, _: np.array([residual(x) for x in at]),
        lambda at, _: np.array([columns(x) for x in at]),
    )
    assert found.found.all()
    for index, start in enumerate(starts):
        theirs = scipy.optimize.least_squares(residual, start, columns, method="lm", x_scale="jac")
        np.testing.assert_allclose(found.unknowns[index], theirs.x, rtol=1e-12)
        assert (found.trials[index], found.rounds[index]) == (theirs.nfev, theirs.njev)
        np.testing.assert_array_equal(found.columns[index], columns(found.unknowns[index]))
