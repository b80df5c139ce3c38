"""Residuals of every run without and with the effects, in time and in frequency."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from testbed.arrays import Array, Series
from testbed.diagnosis.findings import RunResiduals
from testbed.report.frame.blocks import Block, Figure, Paragraph, Section
from testbed.report.frame.chart import Level, line_chart
from testbed.report.frame.series import component_lines
from testbed.signals import AXES

_STAGES = ("nominal", "with the effects")
_MOST_FREQUENCIES = 200
MOST_RUNS = 8
"""Runs that are drawn; the recording has them all."""


def residuals_section(residuals: Sequence[RunResiduals]) -> Section:
    """Return the residuals in time, run by run, and their spectra; once, where nothing was added."""
    stages = _STAGES[: 1 + any(not np.array_equal(run.before, run.after) for run in residuals)]
    shown = [*residuals[:MOST_RUNS]]
    held_out = [run for run in residuals[MOST_RUNS:] if run.held_out]
    shown = [*shown[: MOST_RUNS - 1], held_out[0]] if held_out and not any(run.held_out for run in shown) else shown
    blocks: list[Block] = [_meaning(len(shown), len(residuals), stages), *_spectra(residuals, stages)]
    for run in shown:
        blocks += _in_time(run, stages)
    return Section(title="Residuals", blocks=tuple(blocks))


def _meaning(shown: int, runs: int, stages: Sequence[str]) -> Paragraph:
    sides = ", left of the nominal model with its inertia re-estimated, right with all effects added"
    what = sides if len(stages) > 1 else " of the nominal model with its inertia re-estimated; nothing was added"
    left_out = f" {shown} of {runs} runs are drawn; the recording has them all." if shown < runs else ""
    return Paragraph(
        text=f"(Measured - predicted) / σ on each body axis{what}. Noise alone leaves ±2 once in twenty samples, and a "
        f"flat spectrum at 1.{left_out}"
    )


def _in_time(run: RunResiduals, stages: Sequence[str]) -> Iterator[Figure]:
    reach = 1.05 * max(float(np.abs(run.before).max()), float(np.abs(run.after).max()), 2.5)
    role = "held out" if run.held_out else "fitted"
    for what, values in zip(stages, (run.before, run.after), strict=False):
        chart = line_chart(
            component_lines(AXES, run.time, values),
            y_title="residual, σ",
            levels=[Level(name="±2 σ", values=(2.0, -2.0))],
        )
        yield Figure(title=f"{run.name} ({role}): {what}", chart=chart.update_yaxes(range=[-reach, reach]))


def _spectra(residuals: Sequence[RunResiduals], stages: Sequence[str]) -> Iterator[Figure]:
    times = [run.time for run in residuals]
    frequency, before = mean_spectrum(times, [run.before for run in residuals])
    _, after = mean_spectrum(times, [run.after for run in residuals])
    highest = 1.05 * float(max(before.max(), after.max()))
    for what, power in zip(stages, (before, after), strict=False):
        chart = line_chart(
            component_lines(AXES, frequency, power),
            y_title="power, 1 for white noise",
            levels=[Level(name="noise alone", values=(1.0,))],
        )
        chart.update_xaxes(title_text="frequency, Hz").update_yaxes(range=[0.0, highest])
        yield Figure(title=f"Spectrum over all runs: {what}", chart=chart)


def mean_spectrum(times: Sequence[Series], residuals: Sequence[Array]) -> tuple[Series, Array]:
    """Return frequencies, shape (F,), Hz, and the mean power of white-noise units at each, shape (F, 3).

    Samples may be uneven: the transform is taken at their own times.

    Args:
        times: of each run's samples, shape (N,), s.
        residuals: of each run, shape (N, 3).
    """
    length = min(float(np.ptp(time)) for time in times)
    fastest = 0.5 / max(float(np.median(np.diff(time))) for time in times)
    count = int(np.clip(fastest * length, 4, _MOST_FREQUENCIES))
    frequency = fastest * np.arange(1, count + 1) / count
    powers = []
    for time, residual in zip(times, residuals, strict=True):
        turns = np.exp(-2j * np.pi * np.outer(frequency, time))
        powers.append(np.abs(turns @ residual) ** 2 / len(time))
    return frequency, np.mean(powers, axis=0)
