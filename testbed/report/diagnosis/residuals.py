"""The residual of all runs in frequency, without and with the effects."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from testbed.arrays import Array, Series
from testbed.diagnosis.run_residuals import RunResiduals
from testbed.report.diagnosis.prediction import was_extended
from testbed.report.frame.blocks import Figure, Paragraph, Section
from testbed.report.frame.chart import Level, line_chart
from testbed.report.frame.series import component_lines
from testbed.signals import AXES

_STAGES = ("nominal", "with the effects")
_MOST_FREQUENCIES = 200


def residuals_section(residuals: Sequence[RunResiduals]) -> Section:
    """Return the spectra; once, where nothing was added."""
    stages = _STAGES[: 1 + any(map(was_extended, residuals))]
    return Section(title="Spectrum of the residual", blocks=(_meaning(stages), *_spectra(residuals, stages)))


def _meaning(stages: Sequence[str]) -> Paragraph:
    sides = ", left of the nominal model with its inertia re-estimated, right with all effects added"
    what = sides if len(stages) > 1 else " of the nominal model with its inertia re-estimated; nothing was added"
    return Paragraph(text=f"(Measured - predicted) / σ on each body axis{what}. Noise alone is flat at 1.")


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
