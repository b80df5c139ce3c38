"""The page of flights until a verdict is sure: what is known after each, and what to fly next."""

from __future__ import annotations

from collections.abc import Mapping
from math import exp, log
from pathlib import Path

import numpy as np
import plotly.graph_objects as go

from testbed.dynamics.inertia import PARAMETER_NAMES
from testbed.dynamics.inertia_unit import InertiaUnit, inertia_unit
from testbed.formats.plan import PlanFlight, PlanResult
from testbed.report.frame.blocks import Cell, Column, Figure, Notice, Page, Paragraph, Section, Table, Tone
from testbed.report.frame.page import write_page
from testbed.report.frame.style import color, layout
from testbed.report.sections.provenance import provenance_section
from testbed.report.wording import figures, listed

_LARGEST_WRITTEN = 1e6
"""E-values beyond which a power of ten says as much."""


def plan_verdict(state: PlanResult) -> Notice:
    """Return what the campaign ends with, in a sentence."""
    flown = f"{len(state.flights)} flight{'s' * (len(state.flights) != 1)}"
    chance = (
        f"by chance such a campaign ever gives a name in at most {100 * state.alpha:g} % of cases without an effect"
    )
    if state.outcome == "named":
        return Notice(tone="good", text=f"After {flown}: {state.names[0]}; {chance}.")
    if state.outcome == "class":
        names = " or ".join(state.names)
        return Notice(
            tone="good", text=f"After {flown}: {names}, which no flight of this platform distinguishes; {chance}."
        )
    if state.outcome == "inertia":
        text = f"After {flown} the inertia is known as well as wanted."
        return Notice(tone="warn" if _something_missing(state) else "good", text=text)
    if state.outcome == "used_up":
        return Notice(tone="warn", text=f"{flown}, all that are allowed, were not enough for {wish_words(state)}.")
    if state.next is None:
        return Notice(tone="plain", text=f"{flown} so far; interrupted before the next one was chosen.")
    return Notice(
        tone="plain", text=f"{flown} so far; flight {state.next.number} is to be flown: {state.next.release}."
    )


def wish_words(state: PlanResult) -> str:
    """Return what is wanted, in words."""
    std = state.wanted.inertia_std_kg_m2
    if std is not None:
        if len(std) == len(PARAMETER_NAMES) and len(set(std.values())) == 1:
            return f"the inertia, all parameters to {std[PARAMETER_NAMES[0]]:g} kg·m²"
        return f"the inertia, {listed(f'{name} to {value:g} kg·m²' for name, value in std.items())}"
    return "the name of any effect" if state.wanted.effect == "any" else f"the name {state.wanted.effect}"


def factor_words(log_value: float) -> str:
    """Return an e-value, or a growth of odds, as a number, or as a power of ten where it is large."""
    return figures(exp(log_value)) if log_value < log(_LARGEST_WRITTEN) else f"1e{log_value / log(10.0):.0f}"


def leading_words(flight: PlanFlight) -> str:
    """Return the effect that explains the most; none does where even that one is no more probable than no effect."""
    return flight.leading if flight.leading_log_e_value > 0.0 else "none"


def verdict_words(flight: PlanFlight) -> str:
    """Return what the diagnosis after a flight says; a dash where there was none."""
    if flight.verdict is None:
        return "-"
    return (
        f"{flight.verdict}: {listed(each.replace('|', ' or ') for each in flight.named)}"
        if flight.named
        else flight.verdict
    )


def std_words(flight: PlanFlight, state: PlanResult) -> str:
    """Return the largest ratio of a stated standard deviation to the wanted one."""
    wanted = state.wanted.inertia_std_kg_m2
    if wanted is None or flight.std_kg_m2 is None:
        return "-"
    by_name = dict(zip(PARAMETER_NAMES, flight.std_kg_m2, strict=True))
    return figures(max(by_name[name] / limit for name, limit in wanted.items()))


def _something_missing(state: PlanResult) -> bool:
    return any(flight.log_e_value >= -log(state.alpha) for flight in state.flights)


def plan_page(state: PlanResult, provenance: Mapping[str, str]) -> Page:
    """Return the page.

    Args:
        state: the campaign.
        provenance: what to its value.
    """
    blocks = (flights_table(state), _growth(state)) if len(state.flights) > 1 else (flights_table(state),)
    sections = [Section(title="Flights", blocks=blocks)]
    if state.flights and (theta := state.flights[-1].theta_kg_m2) is not None:
        sections.append(Section(title="Inertia", blocks=(_inertia_table(state, inertia_unit(theta)),)))
    if state.next is not None:
        sections.append(Section(title="Next flight", blocks=(Paragraph(text=next_words(state)),)))
    return Page(
        title=f"Flights until sure: {state.scenario}",
        subtitle=f"Wanted: {wish_words(state)}.",
        verdict=plan_verdict(state),
        notices=tuple(Notice(tone="warn", text=text) for text in state.notices),
        sections=(*sections, provenance_section(provenance, "plan.json", state.model_dump(mode="json", by_alias=True))),
    )


def next_words(state: PlanResult) -> str:
    """Return what to fly next and what is expected of it."""
    planned = state.next
    if planned is None:
        return ""
    text = f"Flight {planned.number}, {planned.scenario}: {planned.release}."
    if planned.gain is None or planned.worst_gain is None:
        return text
    what = "the odds grow" if state.wanted.effect is not None else "the worst standard deviation falls"
    return (
        f"{text} Expected: {what} by a factor of {factor_words(planned.gain)}, and of "
        f"{factor_words(planned.worst_gain)} in the worst case ({planned.worst_case})."
    )


def flights_table(state: PlanResult) -> Table:
    """Return the table of all flights."""
    rows = []
    for flight in state.flights:
        passed: Tone = "good" if flight.log_e_value >= -log(state.alpha) else "plain"
        rows.append(
            (
                Cell(text=str(flight.number)),
                Cell(text=flight.record),
                Cell(text=factor_words(flight.log_e_value), tone=passed),
                Cell(text=leading_words(flight)),
                Cell(text=factor_words(flight.leading_log_e_value)),
                Cell(text=verdict_words(flight)),
                Cell(text=std_words(flight, state)),
            )
        )
    titles = ("Flight", "record", "e-value", "leading effect", "its e-value", "diagnosis", "worst std over wanted")
    note = (
        f"An e-value of {figures(1.0 / state.alpha)} or more is met in at most {100 * state.alpha:g} % of campaigns "
        "without an effect, at whatever flight they stop. That of what is wanted is the mean over all hypotheses that "
        "share the prior. A diagnosis is made once it is as large."
    )
    shown = len(titles) - (state.wanted.inertia_std_kg_m2 is None)  # the last column is of a wanted inertia alone
    columns = tuple(Column(title=title) for title in titles[:shown])
    return Table(columns=columns, rows=tuple(row[:shown] for row in rows), note=note, numeric=False)


def _growth(state: PlanResult) -> Figure:
    """Return the e-values after every flight against the one at which a name may be given."""
    numbers = [flight.number for flight in state.flights]
    lines = {
        "what is wanted": [flight.log_e_value for flight in state.flights],
        "leading effect": [flight.leading_log_e_value for flight in state.flights],
    }
    traces = [
        go.Scatter(
            x=numbers,
            y=np.array(values) / log(10.0),
            name=name,
            mode="lines+markers",
            line={"color": color(own)},
            customdata=[factor_words(value) for value in values],
            hovertemplate="flight %{x}: %{customdata}<extra></extra>",
        )
        for (name, values), own in zip(lines.items(), ("fitted", "faint"), strict=True)
    ]
    chart = go.Figure(traces, layout=layout("flight", "log10 of the e-value"))
    chart.add_hline(y=-log(state.alpha) / log(10.0), line={"color": color("limit"), "dash": "dash"})
    chart.update_xaxes(dtick=1)
    return Figure(
        title="How sure it is after every flight",
        chart=chart,
        note=f"Dashed: {figures(1.0 / state.alpha)}, from which on a diagnosis is asked for the name.",
    )


def _inertia_table(state: PlanResult, unit: InertiaUnit) -> Table:
    rows = []
    for flight in state.flights:
        theta, std = np.array(flight.theta_kg_m2), np.array(flight.std_kg_m2)
        cells = (
            Cell(text=f"{unit.shown(value, 4)} ± {unit.shown(error, 4)}")
            for value, error in zip(theta, std, strict=True)
        )
        rows.append((Cell(text=str(flight.number)), *cells))
    columns = (Column(title="After flight"), *(Column(title=name, unit=unit.text) for name in PARAMETER_NAMES))
    return Table(columns=columns, rows=tuple(rows))


def write_plan_page(path: Path, state: PlanResult, provenance: Mapping[str, str]) -> None:
    """Write the page, whole or not at all.

    Raises:
        OutputError: the file cannot be written.
    """
    write_page(path, plan_page(state, provenance))
