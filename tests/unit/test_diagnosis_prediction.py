"""Measured against predicted, on the page of a diagnosis."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from support.diagnosed_records import nominal, records
from testbed.diagnosis.channels import ChannelNoise
from testbed.diagnosis.reading import data_set_of
from testbed.diagnosis.run_residuals import GimbalResiduals, RunResiduals, UnitResiduals
from testbed.report.diagnosis.prediction import (
    MEAN_OVER,
    prediction_section,
    running_mean,
    shown_runs,
    turned_apart,
)
from testbed.report.frame.blocks import Figure

TIME = np.arange(0.0, 2.0, 0.01)


def run(name="run", *, held_out=False, extended=True) -> RunResiduals:
    rng = np.random.default_rng(5)
    measured = np.column_stack([np.sin(TIME), np.cos(TIME), TIME])
    noise = rng.normal(size=measured.shape)
    torque = np.sin(TIME)
    return RunResiduals(
        name=name,
        held_out=held_out,
        time=TIME,
        measured=measured,
        nominal=measured + 0.01,
        extended=measured if extended else measured + 0.01,
        before=noise + 1.0,
        after=noise if extended else noise + 1.0,
        gimbals=(
            GimbalResiduals(
                name="motor torques",
                unit="N·m",
                actuators=tuple(
                    UnitResiduals(name=f"CMG {unit}", time=TIME, measured=torque, nominal=torque, extended=torque)
                    for unit in range(1, 7)
                ),
            ),
        ),
    )


def figures(*runs: RunResiduals) -> dict[str, Figure]:
    return {block.title: block for block in prediction_section(runs).blocks if isinstance(block, Figure)}


def test_one_fitted_and_one_held_out_run_are_drawn():
    several = [run("a"), run("b"), run("c", held_out=True), run("d", held_out=True)]
    assert [each.name for each in shown_runs(several)] == ["a", "c"]
    assert "2 of 4 runs are drawn" in prediction_section(several).blocks[0].text
    assert [each.name for each in shown_runs(several[:2])] == ["a"]


def test_each_axis_shows_measured_and_both_predictions_over_the_residual():
    chart = figures(run())["run (fitted): about x"].chart
    rate, residual = ([trace for trace in chart.data if trace.yaxis == axis] for axis in ("y", "y2"))
    assert [trace.name for trace in rate] == ["measured", "nominal", "extended"]
    assert [trace.mode for trace in rate] == ["markers", "lines", "lines"]
    assert {trace.name for trace in residual} == {"nominal", "extended", "±2 σ"}
    np.testing.assert_allclose(rate[0].y, run().measured[:, 0], atol=1e-7)
    listed = [trace.name for trace in chart.data if trace.showlegend]
    assert sorted(listed) == ["extended", "measured", "nominal", "±2 σ"]


def test_both_panels_share_their_time_and_have_units():
    chart = figures(run())["run (fitted): about z"].chart
    axes = [chart.layout.xaxis, chart.layout.xaxis2]
    assert len({axis.matches or "x" for axis in axes}) == 1 or axes[0].matches == "x2"
    assert chart.layout.yaxis.title.text == "body rate, rad/s"
    assert chart.layout.yaxis2.title.text == "residual, σ"
    assert chart.layout.xaxis2.title.text == "time, s"


def test_gimbals_are_drawn_where_they_are_in_the_residual():
    drawn = figures(run("a"), run("b", held_out=True))
    chart = drawn["b (held out): motor torques"].chart
    assert len(chart.data) == 18
    assert "a (fitted): motor torques" not in drawn
    assert not any("torques" in title for title in figures(replace(run(), gimbals=())))


def test_where_nothing_was_added_there_is_one_prediction():
    chart = figures(run(extended=False))["run (fitted): about y"].chart
    assert "extended" not in {trace.name for trace in chart.data}


def test_the_mean_is_over_a_quarter_of_a_second_and_shrinks_at_the_ends():
    assert MEAN_OVER == 0.25  # half a period of the 2 Hz that the misfit counts
    values = np.column_stack([TIME, np.ones_like(TIME), np.zeros_like(TIME)])
    mean = running_mean(TIME, values)
    np.testing.assert_allclose(mean[20:-20, 0], TIME[20:-20], atol=1e-9)
    np.testing.assert_allclose(mean[:, 1], 1.0)
    assert mean[0, 0] == pytest.approx(TIME[:13].mean())


def test_attitudes_are_apart_by_the_integral_of_the_rates_difference():
    rates = np.zeros((len(TIME), 3))
    other = rates + np.array([0.0, 0.02, 0.0])
    np.testing.assert_allclose(turned_apart(TIME, rates, other), 0.02 * TIME, atol=1e-9)


def test_what_is_the_gimbals_of_a_residual_is_taken_apart_by_runs():
    scenario, platform = nominal()
    runs = data_set_of(records(3), scenario, platform).runs
    assert runs.gimbals_by_run(np.zeros(runs.samples)) == [()] * len(runs.names)
    count = len(runs.names)
    torques = [np.full((4, 6), float(number)) for number in range(count)]
    blocks = [*torques, *(np.full((5, 3), -float(number)) for number in range(count))]
    noise = [ChannelNoise(sigma=np.ones(width)) for width in (6, 3) for _ in range(count)]
    more = replace(runs, inner=tuple(blocks), inner_noise=tuple(noise))
    residual = np.concatenate([np.zeros(runs.samples), *(block.ravel() for block in blocks)])
    for number, (first, second) in enumerate(more.gimbals_by_run(residual)):
        np.testing.assert_array_equal(first, blocks[number])
        np.testing.assert_array_equal(second, blocks[count + number])
