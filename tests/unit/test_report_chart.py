"""Lines, levels and shaded stretches of the charts, and how numbers are written beside them."""

import numpy as np
import pytest

from testbed.dynamics.inertia_unit import MILLI
from testbed.report.frame.chart import Level, line_chart, raised
from testbed.report.frame.series import MOST_SAMPLES, Line, component_lines, signal_lines, thinned
from testbed.report.sections.residuals import autocorrelation
from testbed.report.wording import decimals_for, figures, listed


def test_short_lines_are_kept_but_for_their_gaps():
    x, y = thinned(np.arange(5.0), np.array([1.0, np.nan, 3.0, np.nan, 5.0]))
    np.testing.assert_array_equal(x, [0.0, 2.0, 4.0])
    np.testing.assert_array_equal(y, [1.0, 3.0, 5.0])


def test_long_lines_keep_their_ends_and_every_peak():
    x = np.arange(100_000.0)
    y = np.sin(x / 300.0)
    y[[31_234, 77_777]] = 5.0, -7.0
    kept_x, kept_y = thinned(x, y)
    assert len(kept_x) <= MOST_SAMPLES + 2
    assert np.all(np.diff(kept_x) > 0.0)
    np.testing.assert_array_equal(y[kept_x.astype(int)], kept_y)
    assert {0.0, 31_234.0, 77_777.0, 99_999.0} <= set(kept_x)


def test_a_chart_holds_the_numbers_that_it_was_given():
    time = np.arange(9) / 80
    values = np.random.default_rng(2).normal(size=(9, 3))
    chart = line_chart(signal_lines("true_body_rate", time, values), y_title="body rate, rad/s")
    for axis, trace in enumerate(chart.data):
        np.testing.assert_allclose(trace.x, time, atol=1e-7)  # single precision
        np.testing.assert_allclose(trace.y, values[:, axis], rtol=1e-6)
    assert [trace.name for trace in chart.data] == ["x", "y", "z"]
    assert chart.layout.yaxis.title.text == "body rate, rad/s"


def test_times_that_single_precision_cannot_hold_keep_their_digits():
    time = 1.7e9 + np.arange(50) / 16
    chart = line_chart(component_lines(("t",), time, np.ones((50, 1))), y_title="")
    np.testing.assert_array_equal(chart.data[0].x, time)


def test_values_too_large_for_a_chart_leave_it_quietly():
    line = Line(name="a", x=np.arange(3.0), y=np.array([1.0, 1e300, -1e300]), color="ink")
    np.testing.assert_array_equal(line_chart([line], y_title="").data[0].y, [1.0, np.inf, -np.inf])


def test_levels_run_from_end_to_end_on_both_sides():
    line = Line(name="a", x=np.array([1.0, 2.0, 4.0]), y=np.zeros(3), color="ink")
    chart = line_chart([line], y_title="", levels=[Level(name="limit", values=(2.0, -2.0))])
    assert chart.data[1].x == (1.0, 4.0, None, 1.0, 4.0, None)
    assert chart.data[1].y == (2.0, 2.0, None, -2.0, -2.0, None)


def test_one_sample_makes_a_chart_without_a_range():
    line = Line(name="a", x=np.zeros(1), y=np.ones(1), color="ink")
    assert line_chart([line], y_title="").layout.xaxis.range is None


@pytest.mark.parametrize(
    ("flags", "spans"),
    [([0, 0, 0], []), ([1, 1, 1], [(0.0, 3.0)]), ([0, 1, 0], [(1.0, 2.0)]), ([1, 0, 1], [(0.0, 1.0), (2.0, 3.0)])],
)
def test_stretches_last_to_the_end_of_their_last_sample(flags, spans):
    found = raised(np.arange(3.0), np.array(flags, dtype=bool), 1.0)
    assert [(span.start, span.end) for span in found] == spans


def test_autocorrelation_of_a_known_process():
    noise = np.random.default_rng(3).normal(size=20_001)
    moving_average = noise[1:] + 0.5 * noise[:-1]
    found = autocorrelation(moving_average, 5)
    # r(1) = 0.5 / 1.25; the rest is zero. 4 standard deviations of 1/sqrt(20,000) are 0.028.
    np.testing.assert_allclose(found, [0.4, 0.0, 0.0, 0.0, 0.0], atol=0.028)


def test_autocorrelation_of_nothing_is_nothing():
    np.testing.assert_array_equal(autocorrelation(np.zeros(8), 3), np.zeros(3))


def test_standard_deviations_show_two_digits():
    assert decimals_for(np.array([4.2e-6, 1.3e-4]), MILLI) == 4  # 0.0042e-3
    assert decimals_for(np.array([0.13e-3]), MILLI) == 2
    assert decimals_for(np.array([25e-3]), MILLI) == 0
    assert decimals_for(np.array([np.nan, 0.0]), MILLI) == 3


def test_numbers_and_lists_read_well():
    assert MILLI.shown(-1e-12, 3) == "0.000"
    assert MILLI.shown(0.0212345, 4) == "21.2345"
    assert figures(3.14159e-9, 2) == "3.1e-09"
    assert [listed(items) for items in (["a"], ["a", "b"], ["a", "b", "c"])] == ["a", "a and b", "a, b and c"]
