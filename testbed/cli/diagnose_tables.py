"""What a diagnosis looks like in the terminal."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby

import numpy as np
from rich.box import SIMPLE_HEAD
from rich.table import Table
from rich.text import Text

from testbed.diagnosis.candidates import Screening
from testbed.diagnosis.findings import Detectable, detectable_sizes, inertia_change, pairs_alike, stds_of
from testbed.diagnosis.location import ResidualSegment
from testbed.diagnosis.noise import NoiseHypothesis
from testbed.diagnosis.state import Diagnosis
from testbed.dynamics.inertia import PARAMETER_NAMES
from testbed.effects.contract import Quantity
from testbed.effects.registry import EFFECTS
from testbed.report.diagnosis.inertia import estimate_words, inertia_estimates
from testbed.report.diagnosis.ranking import RANKING, ranking_rows
from testbed.report.wording import chance_words, decimals_for, figures, milli

_ALIKE_SHOWN = 3


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
    columns = ("effect", "smallest size seen", "times typical", "hard to tell from")
    table = _table("What these data can tell", columns)
    table.columns[-1].min_width = max(len(effect) for effect in EFFECTS) + 1  # a comma behind it
    alike = _look_alikes(diagnosis)
    for effect, group in groupby(detectable_sizes(diagnosis), key=lambda size: size.placed.effect.id):
        sizes = sorted(group, key=lambda size: size.multiple)
        style = "" if sizes[-1].seen_when_typical else "yellow" if sizes[0].seen_when_typical else "dim"
        table.add_row(effect, _smallest(sizes), _times_typical(sizes), alike.get(effect, ""), style=style)
    for each in diagnosis.untestable:
        table.add_row(each.effect, f"needs {each.needs}", "untestable", "", style="dim")
    return table


def _smallest(sizes: Sequence[Detectable]) -> str:
    """Return the parameters that make the size, from the most to the least visible component; equal ones once."""
    seen = [size for size in sizes if size.smallest]
    if not seen:
        return "not by this motion"
    quantities = zip(seen[0].smallest, seen[-1].smallest, seen[0].typical, strict=True)
    spans = [_span(least, most) for least, most, typical in quantities if least.value != typical.value]
    if len(spans) > 1 and len(set(spans)) == 1:
        return f"{spans[0]} each"
    return ", ".join(spans)


def _span(least: Quantity, most: Quantity) -> str:
    values = dict.fromkeys(figures(each.value) for each in (least, most))
    return f"{' to '.join(values)} {least.unit}".removesuffix(" 1")


def _times_typical(sizes: Sequence[Detectable]) -> str:
    if not sizes[0].smallest:
        return "-"
    return " to ".join(dict.fromkeys(figures(size.multiple, 2) for size in (sizes[0], sizes[-1])))


def _look_alikes(diagnosis: Diagnosis) -> dict[str, str]:
    """Return the ids of the effects that each one is hard to tell from, by its own id."""
    alike: dict[str, dict[str, None]] = {}
    for one, other, _ in pairs_alike(diagnosis):
        for this, that in ((one, other), (other, one)):
            name = "its other components" if this.effect.id == that.effect.id else that.effect.id
            alike.setdefault(this.effect.id, {})[name] = None
    return {effect: ", ".join(list(others)[:_ALIKE_SHOWN]) for effect, others in alike.items()}


def candidates_table(screening: Screening, noise: Sequence[NoiseHypothesis] = ()) -> Table:
    """Return the effects that were refitted, and those on the noise, the most probable first."""
    table = _table("Effects, ranked", ("effect", *RANKING))
    for row in ranking_rows(screening, noise):
        table.add_row(*row)
    return table


def inertia_table(diagnosis: Diagnosis) -> Table:
    """Return the inertia: nominal, re-estimated without the effects, and with them where there are any."""
    differs = inertia_change(diagnosis)
    said = "differs from nominal" if differs.significant else "agrees with nominal"
    table = _table(f"Inertia in 1e-3 kg m², ± one standard deviation; {said}, {chance_words(differs.p_value)}", ("",))
    fits = inertia_estimates(diagnosis)
    decimals = decimals_for(np.concatenate([stds_of(fit)[:6] for _, fit in fits]))
    for title in ("nominal", *(label for label, _ in fits)):
        table.add_column(title, justify="right", no_wrap=True)
    estimated = [estimate_words(fit, decimals) for _, fit in fits]
    for name, nominal, *cells in zip(PARAMETER_NAMES, diagnosis.nominal_theta, *estimated, strict=True):
        table.add_row(name, milli(nominal, decimals), *cells)
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
