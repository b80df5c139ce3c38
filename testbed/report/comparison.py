"""The page of a comparison: estimates of several runs, or figures of several campaigns, side by side."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np

from testbed.arrays import Theta
from testbed.dynamics.inertia import PARAMETER_NAMES
from testbed.dynamics.inertia_unit import MILLI, InertiaUnit, inertia_unit
from testbed.report.frame.blocks import Cell, Column, Notice, Page, Section, Table
from testbed.report.wording import capitalized, estimator_name


@dataclass(frozen=True, kw_only=True, eq=False)
class ComparedFigures:
    """One figure of one estimator, in several results.

    Attributes:
        estimator: by its name in files.
        figure: what it is.
        rows: of each inertia parameter, shape (6,), by the result's name; kg·m² where there are `stds`.
        stds: standard deviation or scatter of each, shape (6,), kg·m²; none of a figure that is a ratio.
    """

    estimator: str
    figure: str
    rows: Mapping[str, Theta]
    stds: Mapping[str, Theta] = field(default_factory=dict)

    def cells(self, name: str) -> Iterator[str]:
        """Yield a result's values as they are shown."""
        for index, value in enumerate(self.rows[name]):
            if not np.isfinite(value):
                yield "-"
            elif name in self.stds:
                yield f"{self.inertia_unit.shown(value, 4)} ± {self.inertia_unit.shown(self.stds[name][index], 4)}"
            else:
                yield f"{value:.2f}"

    @property
    def unit(self) -> str:
        """Unit of what is shown; empty of a ratio."""
        return self.inertia_unit.text if self.stds else ""

    @property
    def inertia_unit(self) -> InertiaUnit:
        """That of the smallest: one that lost its way is larger than any body, or no number."""
        known = [theta for theta in self.rows.values() if np.isfinite(theta).all()]
        return inertia_unit(min(known, key=lambda theta: float(np.abs(theta).max()))) if known else MILLI


def comparison_page(
    kind: Literal["run", "campaign"],
    results: Mapping[str, Mapping[str, Any]],
    figures: Sequence[ComparedFigures],
) -> Page:
    """Return the page.

    Args:
        kind: of the results.
        results: what the JSON file of each holds, by name.
        figures: of each estimator.
    """
    sections = {each.estimator: capitalized(estimator_name(each.estimator)) for each in figures}
    return Page(
        title=f"{len(results)} {kind}s compared",
        subtitle=", ".join(results),
        verdict=Notice(text=_same_truth(kind, results), tone="plain"),
        notices=(),
        sections=(
            Section(title="What is compared", blocks=(_overview(kind, results),)),
            *(
                Section(title=title, blocks=tuple(_table(each) for each in figures if each.estimator == estimator))
                for estimator, title in sections.items()
            ),
        ),
    )


def _same_truth(kind: Literal["run", "campaign"], results: Mapping[str, Mapping[str, Any]]) -> str:
    scenarios = sorted({str(each.get("scenario")) for each in results.values()})
    if len(scenarios) == 1:
        return f"All {kind}s are of the scenario {scenarios[0]}."
    return f"The {kind}s are of different scenarios: {', '.join(scenarios)}."


def _overview(kind: Literal["run", "campaign"], results: Mapping[str, Mapping[str, Any]]) -> Table:
    keys = ("scenario", "seed", "outcome") if kind == "run" else ("scenario", "seed", "runs", "failed")
    rows = tuple(
        (Cell(text=name), *(Cell(text=str(each.get(key, "-"))) for key in keys)) for name, each in results.items()
    )
    columns = (Column(title=capitalized(kind)), *(Column(title=capitalized(key)) for key in keys))
    return Table(columns=columns, rows=rows, numeric=False)


def _table(figures: ComparedFigures) -> Table:
    columns = (
        Column(title=capitalized(figures.figure)),
        *(Column(title=name, unit=figures.unit) for name in PARAMETER_NAMES),
    )
    rows = tuple((Cell(text=name), *(Cell(text=text) for text in figures.cells(name))) for name in figures.rows)
    return Table(columns=columns, rows=rows)
