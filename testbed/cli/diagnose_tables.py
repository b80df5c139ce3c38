"""What a diagnosis looks like in the terminal."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import isfinite
from types import MappingProxyType

import numpy as np
from rich.box import SIMPLE_HEAD
from rich.table import Table
from rich.text import Text

from testbed.diagnosis.candidates import Screening
from testbed.diagnosis.findings import changed_inertia, inertia_change, stds_of
from testbed.diagnosis.location import ResidualSegment
from testbed.diagnosis.noise import NoiseHypothesis
from testbed.diagnosis.run_agreement import Agreement
from testbed.diagnosis.state import Diagnosis
from testbed.dynamics.inertia import PARAMETER_NAMES
from testbed.dynamics.inertia_unit import inertia_unit
from testbed.effects.contract import Quantity
from testbed.report.diagnosis.inertia import estimate_words, inertia_estimates
from testbed.report.diagnosis.ranking import RANKING, ranking_rows
from testbed.report.diagnosis.sizes import size_lines
from testbed.report.wording import chance_words, decimals_for, figures_to


def places_table(places: Sequence[ResidualSegment]) -> Table:
    """Return where the gap is."""
    table = _table("Where the gap is", ("signal", "run", "from", "to", "share", "goes along with", "as"))
    for place in places:
        table.add_row(
            place.signal,
            Text(place.run),
            f"{place.from_s:.2f} s",
            f"{place.to_s:.2f} s",
            f"{place.share:.1%}",
            place.depends_on or "nothing",
            place.enters_as or "",
        )
    return table


def detectable_table(diagnosis: Diagnosis) -> Table:
    """Return what these data can show: a row for each effect, from its most to its least visible component."""
    table = _table("What these data can show", ("effect", "smallest size seen", "times typical"))
    for line in size_lines(diagnosis):
        style = "" if line.seen == line.components else "yellow" if line.seen else "dim"
        table.add_row(line.effect, line.smallest, line.multiple, style=style)
    return table


def candidates_table(
    screening: Screening,
    noise: Sequence[NoiseHypothesis] = (),
    untested: Mapping[str, float] = MappingProxyType({}),
) -> Table:
    """Return the effects that were refitted, and those on the noise, the most probable first."""
    table = _table("Effects, ranked", ("effect", *RANKING))
    for row in ranking_rows(screening, noise, untested):
        table.add_row(*row)
    return table


def sizes_table(agreement: Agreement) -> Table:
    """Return the size of an effect in every run by itself."""
    sizes = [agreement.quantities(run) for run in range(len(agreement.runs))]
    units = [f"{each.name}, {each.unit}".removesuffix(", 1") for each in sizes[0]]
    table = _table("Its size in every run by itself, ± one standard deviation", ("run", *units))
    for name, held_out, own in zip(agreement.runs, agreement.heldout, sizes, strict=True):
        table.add_row(Text(f"{name}, held out" if held_out else name), *map(_with_std, own))
    return table


def _with_std(quantity: Quantity) -> str:
    if not isfinite(quantity.std):
        return "not shown"
    return f"{figures_to(quantity.value, quantity.std)} ± {figures_to(quantity.std, quantity.std)}"


def inertia_table(diagnosis: Diagnosis) -> Table:
    """Return the inertia: nominal, re-estimated without the effects, and with them where there are any."""
    differs = inertia_change(diagnosis)
    said = "differs from nominal" if differs.significant else "agrees with nominal"
    healthy = changed_inertia(diagnosis)
    unit = inertia_unit(diagnosis.nominal_theta)
    table = _table(f"Inertia in {unit.text}, ± one standard deviation,\n{said}, {chance_words(differs.p_value)}", ("",))
    known = {"nominal": diagnosis.nominal_theta}
    if healthy is not None:
        known["healthy"] = healthy.theta
    fits = inertia_estimates(diagnosis)
    decimals = decimals_for(np.concatenate([stds_of(fit)[:6] for _, fit in fits]), unit)
    for title in (*known, *(label for label, _ in fits)):
        table.add_column(title, justify="right", no_wrap=True)
    estimated = [estimate_words(fit, decimals, unit) for _, fit in fits]
    for name, *others in zip(PARAMETER_NAMES, *known.values(), *estimated, strict=True):
        values, cells = others[: len(known)], others[len(known) :]
        table.add_row(name, *(unit.shown(value, decimals) for value in values), *cells)
    return table


def _table(title: str, columns: Sequence[str]) -> Table:
    table = Table(
        title=Text(title),
        title_justify="left",
        title_style="bold",
        box=SIMPLE_HEAD,
        show_edge=False,
        pad_edge=False,
        padding=(0, 1, 0, 0),
    )
    for number, column in enumerate(columns):
        table.add_column(column, no_wrap=number == 0, overflow="fold")
    return table
