"""What was measured beside what the model without and with the effects predicts, and the residuals below."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
import plotly.graph_objects as go

from testbed.arrays import Array, Series
from testbed.diagnosis.misfit import BANDWIDTH
from testbed.diagnosis.run_residuals import GimbalResiduals, RunResiduals
from testbed.report.frame.blocks import Block, Figure, Paragraph, Section
from testbed.report.frame.chart import Level, line_chart
from testbed.report.frame.panels import Panel, panel_chart
from testbed.report.frame.series import Line
from testbed.rotation.kinematics import integrate_attitude
from testbed.rotation.quaternion import quaternion_inverse, quaternion_product
from testbed.signals import AXES

MEAN_OVER = 0.5 / BANDWIDTH
"""s. Residuals are shown as they are, and averaged over half a period of the fastest shape that the misfit counts."""
NOISE_REACH = 2.0
"""σ, which noise alone leaves once in twenty samples."""
_UNIT_COLUMNS = 3


def prediction_section(residuals: Sequence[RunResiduals]) -> Section:
    """Return measured and predicted rates of a run that was fitted and of one that was held out."""
    shown = shown_runs(residuals)
    blocks: list[Block] = [_meaning(shown, residuals)]
    for run in shown:
        blocks += _figures(run)
    blocks += _gimbals_figures(shown[-1])
    return Section(title="Measured against predicted", blocks=tuple(blocks))


def shown_runs(residuals: Sequence[RunResiduals]) -> tuple[RunResiduals, ...]:
    """Return the first run that was fitted and the first that was held out, where there is one."""
    by_role = {run.held_out: run for run in reversed(residuals)}
    return tuple(by_role[role] for role in sorted(by_role))


def was_extended(run: RunResiduals) -> bool:
    """Return whether effects changed the prediction of a run or its noise."""
    return not (np.array_equal(run.nominal, run.extended) and np.array_equal(run.before, run.after))


def running_mean(time: Series, values: Array) -> Array:
    """Return the mean of the samples within `MEAN_OVER` around each, shape (N, 3), in their unit.

    Args:
        time: increasing, shape (N,), s; samples may be uneven.
        values: shape (N, 3).
    """
    first = np.searchsorted(time, time - 0.5 * MEAN_OVER, side="left")
    last = np.searchsorted(time, time + 0.5 * MEAN_OVER, side="right")
    total = np.concatenate([np.zeros((1, values.shape[1])), np.cumsum(values, axis=0)])
    return np.asarray((total[last] - total[first]) / (last - first)[:, None])


def turned_apart(time: Series, rates: Array, others: Array) -> Series:
    """Return the angle between the attitudes that two body rates lead to from the same start, shape (N,), rad.

    Args:
        time: shape (N,), s.
        rates: one of them, shape (N, 3), rad/s.
        others: the other, likewise.
    """
    between = quaternion_product(quaternion_inverse(integrate_attitude(time, rates)), integrate_attitude(time, others))
    return np.asarray(2.0 * np.arctan2(np.linalg.norm(between[:, 1:], axis=1), np.abs(between[:, 0])))


def _meaning(shown: Sequence[RunResiduals], residuals: Sequence[RunResiduals]) -> Paragraph:
    models = "the nominal model, its inertia and initial rates re-estimated"
    if any(map(was_extended, residuals)):
        models += ", and as the model with all effects added"
    left_out = f" {len(shown)} of {len(residuals)} runs are drawn; the recording has them all."
    return Paragraph(
        text=f"Body rates as measured, and as predicted by {models}. Below, (measured - predicted) / σ: samples as "
        f"points, and their mean over {MEAN_OVER:g} s as a line. Noise alone leaves ±{NOISE_REACH:g} σ once in twenty "
        f"samples.{left_out if len(shown) < len(residuals) else ''}"
    )


def _figures(run: RunResiduals) -> Iterator[Figure]:
    title = _title(run)
    for axis, name in enumerate(AXES):
        chart = panel_chart([[_rate(run, axis)], [_residual(run, axis)]], row_heights=(3, 2))
        yield Figure(title=f"{title}: about {name}", chart=chart, tall=True)
    yield Figure(title=f"{title}: attitude", chart=_attitude(run), tall=True)


def _gimbals_figures(run: RunResiduals) -> Iterator[Figure]:
    for channel in run.gimbals:
        yield Figure(title=f"{_title(run)}: {channel.name}", chart=_gimbals(run, channel), wide=True, tall=True)


def _title(run: RunResiduals) -> str:
    return f"{run.name} ({'held out' if run.held_out else 'fitted'})"


def _rate(run: RunResiduals, axis: int) -> Panel:
    lines = [
        Line(name="measured", x=run.time, y=run.measured[:, axis], color="measured", style="points"),
        *_predicted(run, run.time, run.nominal[:, axis], run.extended[:, axis], agreeing=True),
    ]
    return Panel(y_title="body rate, rad/s", lines=tuple(lines))


def _residual(run: RunResiduals, axis: int) -> Panel:
    before, after = (values[:, axis : axis + 1] for values in (run.before, run.after))
    samples = [
        Line(name=name, x=run.time, y=values[:, 0], color=name, style="points", pale=True, listed=False)
        for name, values in _stages(run, before, after)
    ]
    means = _predicted(run, run.time, running_mean(run.time, before)[:, 0], running_mean(run.time, after)[:, 0])
    reach = Level(name=f"±{NOISE_REACH:g} σ", values=(NOISE_REACH, -NOISE_REACH))
    return Panel(y_title="residual, σ", lines=(*samples, *means), levels=(reach,))


def _attitude(run: RunResiduals) -> go.Figure:
    apart = [turned_apart(run.time, run.measured, rates) for rates in (run.nominal, run.extended)]
    lines = tuple(_predicted(run, run.time, *apart))
    return line_chart(lines, y_title="angle from the measured attitude, rad").update_layout(showlegend=True)


def _gimbals(run: RunResiduals, channel: GimbalResiduals) -> go.Figure:
    panels = [
        Panel(
            y_title=channel.unit if place % _UNIT_COLUMNS == 0 else "",
            title=each.name,
            lines=(
                Line(name="measured", x=each.time, y=each.measured, color="measured", style="points"),
                *_predicted(run, each.time, each.nominal, each.extended, agreeing=True),
            ),
        )
        for place, each in enumerate(channel.actuators)
    ]
    return panel_chart([panels[first : first + _UNIT_COLUMNS] for first in range(0, len(panels), _UNIT_COLUMNS)])


def _predicted(
    run: RunResiduals, time: Series, nominal: Series, extended: Series, *, agreeing: bool = False
) -> Iterator[Line]:
    """Yield both models' lines; where they agree but for a line's width, the first wide and pale below the second."""
    for name, values in _stages(run, nominal, extended):
        below = name == "nominal" and agreeing
        yield Line(name=name, x=time, y=values, color=name, style="wide" if below else "line", pale=below)


def _stages(run: RunResiduals, nominal: Array, extended: Array) -> tuple[tuple[str, Array], ...]:
    """Return what belongs to each model by its name; to the nominal one alone where nothing was added."""
    return (("nominal", nominal), ("extended", extended))[: 1 + was_extended(run)]
