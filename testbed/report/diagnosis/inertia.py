"""The inertia with and without the effects, and the unmodelled torque."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import plotly.graph_objects as go

from testbed.arrays import Theta
from testbed.diagnosis.findings import changed_inertia, inertia_change, stds_of
from testbed.diagnosis.latent import LatentTorque
from testbed.diagnosis.model import Fit
from testbed.diagnosis.settings import SETTINGS
from testbed.diagnosis.state import Diagnosis
from testbed.dynamics.inertia import PARAMETER_NAMES
from testbed.dynamics.inertia_unit import InertiaUnit, inertia_unit
from testbed.report.diagnosis.verdict import shape_words, share_words
from testbed.report.frame.blocks import Cell, Column, Figure, Paragraph, Section, Table
from testbed.report.frame.chart import line_chart
from testbed.report.frame.series import component_lines
from testbed.report.frame.style import color, layout
from testbed.report.wording import BAND, chance_words, decimals_for, figures
from testbed.signals import AXES

_PLACES = np.arange(len(PARAMETER_NAMES))
_MOST_RUNS = 8
"""Runs whose unmodelled torque is drawn."""


def inertia_section(diagnosis: Diagnosis) -> Section:
    """Return the inertia as nominal, as estimated without effects, and with them where there are any."""
    change = inertia_change(diagnosis)
    said = "differs from" if change.significant else "agrees with"
    model = "With all effects in the model" if diagnosis.steps else "Without any effect in the model"
    text = (
        f"{model}, the inertia {said} the nominal one: a difference as large comes by chance with "
        f"{chance_words(change.p_value)} (Wald test of {_tested_words(diagnosis)}). It is re-estimated at every step."
    )
    fits = inertia_estimates(diagnosis)
    unit = inertia_unit(diagnosis.nominal_theta)
    chart = go.Figure(layout=layout("", f"estimate - nominal, {unit.text}"))
    for index, ((name, fit), stroke) in enumerate(zip(fits, ("nominal", "extended"), strict=False)):
        difference = np.where(fit.shown[:6], unit.per_SI * (fit.theta - diagnosis.nominal_theta), np.nan)
        shift = 0.12 * (2 * index + 1 - len(fits))
        _add(chart, name, difference, unit.per_SI * stds_of(fit)[:6], stroke, shift)
    chart.update_xaxes(tickvals=_PLACES, ticktext=PARAMETER_NAMES, showgrid=False, zeroline=False)
    chart.update_layout(hovermode="closest")
    figure = Figure(title="Inertia against nominal, 95 % intervals", chart=chart, wide=True)
    return Section(title="Inertia", blocks=(Paragraph(text=text), figure, _table(diagnosis)))


def _tested_words(diagnosis: Diagnosis) -> str:
    shown = diagnosis.model.shown[:6]
    if shown.all():
        return "all six parameters"
    names = ", ".join(name for name, yes in zip(PARAMETER_NAMES, shown, strict=True) if yes)
    return f"{names}, as the axes of the runs show no more"


def inertia_estimates(diagnosis: Diagnosis) -> tuple[tuple[str, Fit], ...]:
    """Return the fits in which the inertia was estimated: without effects, and with them where there are any.

    Effects on the gyro's noise are among them: in coloured noise the inertia is known less well.
    """
    fits = (("re-estimated", diagnosis.baseline), ("with the effects", diagnosis.model))
    return fits[: 1 + bool(diagnosis.steps or diagnosis.scatter)]


def estimate_words(fit: Fit, decimals: int, unit: InertiaUnit) -> Iterator[str]:
    """Yield the six inertia parameters of a fit with their standard deviations."""
    for value, std, shown in zip(fit.theta, stds_of(fit)[:6], fit.shown[:6], strict=True):
        known = f"{unit.shown(value, decimals)} ± {unit.shown(std, decimals) if np.isfinite(std) else '?'}"
        yield known if shown else "not determined"


def _add(chart: go.Figure, name: str, difference: Theta, std: Theta, stroke: str, shift: float) -> None:
    reach = BAND * std
    chart.add_scatter(
        x=_PLACES + shift,
        y=difference,
        error_y={"array": np.where(np.isfinite(reach), reach, 0.0), "color": color(stroke), "thickness": 1.5},
        mode="markers",
        marker={"color": color(stroke), "size": 7},
        name=name,
        hovertemplate="%{y:+.4~f} ± %{error_y.array:.4~f}",
    )


def _table(diagnosis: Diagnosis) -> Table:
    fits = inertia_estimates(diagnosis)
    unit = inertia_unit(diagnosis.nominal_theta)
    decimals = decimals_for(np.concatenate([stds_of(fit)[:6] for _, fit in fits]), unit)
    rows = [("Nominal", *(unit.shown(value, decimals) for value in diagnosis.nominal_theta))]
    healthy = changed_inertia(diagnosis)
    if healthy is not None:
        rows.append(("Of the healthy records", *(unit.shown(value, decimals) for value in healthy.theta)))
    rows += [(name.capitalize(), *estimate_words(fit, decimals, unit)) for name, fit in fits]
    return Table(
        columns=(Column(title="Inertia"), *(Column(title=name, unit=unit.text) for name in PARAMETER_NAMES)),
        rows=tuple(tuple(Cell(text=text) for text in row) for row in rows),
        note="± is one standard deviation.",
    )


def left_section(diagnosis: Diagnosis) -> Iterator[Section]:
    """Yield the residual of the model with all effects, once it was tested."""
    latent = diagnosis.latent
    if latent is None:
        return
    shape, share = shape_words(diagnosis).strip(), share_words(diagnosis)
    if latent.p_value >= SETTINGS.unexplained_p_value:
        nothing = f"No unmodelled torque stands out of the noise: p = {figures(latent.p_value, 2)}."
        yield Section(title="Unmodelled torque", blocks=(Paragraph(text=f"{shape or nothing} {share}".strip()),))
        return
    text = (
        "An unmodelled torque stands out of the noise: a likelihood ratio of "
        f"{figures(latent.likelihood_ratio)}, by chance with {chance_words(latent.p_value)}. {shape} {share} Below, "
        "its maximum a posteriori estimate."
    )
    shown = latent.runs[:_MOST_RUNS]
    figures_of = tuple(_latent_figure(latent, index, name) for index, name in enumerate(shown))
    yield Section(title="Unmodelled torque", blocks=(Paragraph(text=text), *figures_of))


def _latent_figure(latent: LatentTorque, run: int, name: str) -> Figure:
    lines = component_lines(AXES, latent.knot_time[run], latent.torque_B[run])
    return Figure(title=f"{name}: unmodelled torque, body axes", chart=line_chart(lines, y_title="torque, N·m"))
