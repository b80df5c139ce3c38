"""What the recording of a diagnosis shows: each run measured, and as both models predict it, on one time line."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from testbed.arrays import Array
from testbed.diagnosis.findings import RunResiduals
from testbed.recording.diagnosis import DiagnosisContent
from testbed.recording.palette import ESTIMATOR_COLORS, LIMIT_COLOR, TRUTH_COLOR, Color
from testbed.recording.reproduction_content import ShownPanel, ShownTab
from testbed.recording.traces import Style, Trace
from testbed.signals import AXES

_MEASURED = TRUTH_COLOR
_NOMINAL, _EXTENDED = ESTIMATOR_COLORS[:2]


def diagnosis_content(residuals: Sequence[RunResiduals], provenance: Mapping[str, str]) -> DiagnosisContent:
    """Return a tab for each run: body rates of each axis on the left, residuals in sigma on the right."""
    return DiagnosisContent(
        tabs=tuple(_tab(f"run_{number}", run) for number, run in enumerate(residuals, start=1)),
        provenance="\n".join(f"- **{what}**: `{value}`" for what, value in provenance.items()),
    )


def _tab(root: str, run: RunResiduals) -> ShownTab:
    rates = tuple(_rates(f"{root}/body_rate_{name}", run, axis) for axis, name in enumerate(AXES))
    left = tuple(_left(f"{root}/residual_{name}", run, axis) for axis, name in enumerate(AXES))
    return ShownTab(name=f"{run.name}{', held out' if run.held_out else ''}", columns=(rates, left))


def _rates(origin: str, run: RunResiduals, axis: int) -> ShownPanel:
    traces = (
        _trace(f"{origin}/nominal", run, run.nominal[:, axis], _NOMINAL, "line"),
        _trace(f"{origin}/extended", run, run.extended[:, axis], _EXTENDED, "line"),
        _trace(f"{origin}/measured", run, run.measured[:, axis], _MEASURED, "points"),
    )
    return ShownPanel(origin=origin, title=f"Body rate {AXES[axis]}, B [rad/s]", traces=traces)


def _left(origin: str, run: RunResiduals, axis: int) -> ShownPanel:
    ends = run.time[[0, -1]]
    band = Trace(
        path=f"{origin}/noise",
        time=ends,
        values=np.tile([2.0, -2.0], (2, 1)),
        names=("2 sigma",) * 2,
        colors=(LIMIT_COLOR,) * 2,
        style="limit",
    )
    traces = (
        _trace(f"{origin}/nominal", run, run.before[:, axis], _NOMINAL, "line"),
        _trace(f"{origin}/extended", run, run.after[:, axis], _EXTENDED, "line"),
        band,
    )
    return ShownPanel(origin=origin, title=f"Measured - predicted, {AXES[axis]} [sigma]", traces=traces)


def _trace(path: str, run: RunResiduals, values: Array, color: Color, style: Style) -> Trace:
    name = path.rpartition("/")[2]
    return Trace(path=path, time=run.time, values=values[:, None], names=(name,), colors=(color,), style=style)
