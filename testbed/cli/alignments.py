"""What a run's alignments look like in the terminal."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import count

import numpy as np
from rich.box import SIMPLE_HEAD
from rich.table import Table
from rich.text import Text

from testbed.cli.console import say, show, warn
from testbed.dynamics.inertia import PARAMETER_NAMES
from testbed.dynamics.inertia_unit import inertia_unit
from testbed.estimation.alignment import AlignmentEstimate
from testbed.estimation.alignment_model import KINDS
from testbed.estimation.alignment_observability import unit_count
from testbed.experiment.aligning import Aligning, null_space_lines

_MILLI = 1e3


def print_alignments(aligning: Aligning) -> None:
    """Print inertia and alignments as estimated jointly, and the directions that the record does not identify."""
    estimate = aligning.estimate
    if estimate is None:
        warn("the alignments were not estimated", aligning.failure)
        return
    unit = inertia_unit(aligning.true_parameters[:6])
    inertia = _rows(aligning, estimate, "", slice(6), "{:z.4f}", unit.per_SI)
    show(_table(f"Inertia with alignments, {unit.text}", PARAMETER_NAMES, [inertia]))
    say()
    units = unit_count(len(estimate.parameters))
    kinds = [
        _rows(aligning, estimate, kind, slice(first, first + units), "{:z.1f}")
        for first, kind in zip(count(len(PARAMETER_NAMES), units), KINDS, strict=False)
    ]
    names = [f"cmg{number}" for number in range(1, units + 1)]
    show(_table("Alignments in mrad and, of momentum scales, 1e-3", names, kinds))
    say()
    for line in null_space_lines(estimate.observability):
        say(f"Open       {line}")
    say()


def _table(title: str, columns: Sequence[str], groups: Iterable[Iterator[list[str]]]) -> Table:
    table = Table(
        title=Text(title), title_justify="left", title_style="bold", box=SIMPLE_HEAD, show_edge=False, pad_edge=False
    )
    for heading in ("", "", *columns):
        table.add_column(heading, justify="right" if heading else "left", no_wrap=True)
    for rows in groups:
        for row in rows:
            table.add_row(*row)
    return table


def _rows(
    aligning: Aligning, estimate: AlignmentEstimate, label: str, part: slice, form: str, scale: float = _MILLI
) -> Iterator[list[str]]:
    """True and estimated values and their standard deviations; a parameter that the record leaves open has none."""
    yield [label, "true", *(form.format(scale * value) for value in aligning.true_parameters[part])]
    yield ["", "estimated", *(form.format(scale * value) for value in estimate.parameters[part])]
    stds = estimate.std[part]
    yield ["", "", *(f"±{form.format(scale * std)}" if np.isfinite(std) else "open" for std in stds)]
