"""The estimates: a table of the numbers, and a chart of their bands beside the bound."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial

import numpy as np

from testbed.arrays import Theta
from testbed.dynamics.inertia import PARAMETER_NAMES
from testbed.dynamics.inertia_unit import inertia_unit
from testbed.estimation.body import is_body
from testbed.report.frame.blocks import Block, Cell, Column, Figure, Table
from testbed.report.sections.estimates_chart import estimates_chart
from testbed.report.sections.inertias import Inertias
from testbed.report.wording import BAND, capitalized, decimals_for, estimator_name

Row = tuple[Cell, ...]
Show = Callable[[float], str]


def estimates_blocks(inertias: Inertias) -> tuple[Block, ...]:
    """Return the table and the chart of the estimates."""
    return (_table(inertias), _figure(inertias))


def _table(inertias: Inertias) -> Table:
    unit = inertia_unit(inertias.nominal)
    show = partial(unit.shown, decimals=decimals_for(_all_stds(inertias), unit))
    rows = [] if inertias.truth is None else [_values("True", inertias.truth, show)]
    rows.append(_values("Nominal", inertias.nominal, show))
    for name in inertias.by_name:
        rows += _estimate_rows(inertias, name, show)
    if inertias.bound_std is not None:
        rows.append(_values("Cramér-Rao bound, std", inertias.bound_std, show))
    columns = (Column(title="Inertia"), *(Column(title=name, unit=unit.text) for name in PARAMETER_NAMES))
    return Table(columns=columns, rows=tuple(rows), note=_table_note(inertias))


def _all_stds(inertias: Inertias) -> Theta:
    bound = [] if inertias.bound_std is None else [inertias.bound_std]
    return np.concatenate([*bound, *(estimate.std for estimate in inertias.by_name.values())])


def _values(title: str, theta: Theta, show: Show) -> Row:
    return Cell(text=title), *(Cell(text=show(value)) for value in theta)


def _estimate_rows(inertias: Inertias, name: str, show: Show) -> Iterator[Row]:
    estimate, judged = inertias.by_name[name], inertias.truth is not None
    pairs = zip(estimate.theta, estimate.std, strict=True)
    values = (Cell(text=f"{show(value)} ± {show(std)}") for value, std in pairs)
    yield Cell(text=f"{capitalized(estimator_name(name))}, ± std"), *values
    if not np.array_equal(estimate.std, estimate.noise_std):
        alone = (Cell(text=f"± {show(std)}", tone="faint") for std in estimate.noise_std)
        yield Cell(text="by noise alone", tone="faint"), *alone
    if not is_body(estimate.theta):
        nearest = (Cell(text=show(value), tone="faint") for value in estimate.body_theta)
        yield Cell(text="the nearest inertia of a body", tone="faint"), *nearest
    title = "error / std" if judged else "change from nominal / std"
    yield Cell(text=title, tone="faint"), *(_ratio(ratio, judged=judged) for ratio in inertias.ratio(name))


def _ratio(ratio: float, *, judged: bool) -> Cell:
    missed = judged and abs(ratio) > BAND
    return Cell(text=f"{ratio:+.2f}", tone="warn" if missed else "faint")


def _table_note(inertias: Inertias) -> str:
    if inertias.truth is None:
        return "The true inertia is not known; the standard deviations are the estimators' own."
    return (
        f"error / std is a pure number, in bold where the 95 % band (±{BAND} std) misses the truth; one band in twenty "
        "does by chance. One flight is one draw of the noise: which estimator comes closest here does not say which is "
        "the better one."
    )


def _figure(inertias: Inertias) -> Figure:
    origin = "nominal value" if inertias.truth is None else "truth"
    around = "the truth" if inertias.truth is not None else f"what {estimator_name(inertias.most_certain)} says"
    bound = f" Grey: ±{BAND} std of the motion's Cramér-Rao bound around {around}."
    return Figure(
        title=f"Estimate minus {origin}, with 95 % bands",
        chart=estimates_chart(inertias),
        note=f"Bars: ±{BAND} std as each estimator states it.{'' if inertias.bound_std is None else bound}",
        wide=True,
    )
