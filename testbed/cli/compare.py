"""testbed compare: runs, or campaigns, side by side."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from itertools import groupby
from pathlib import Path

from rich.table import Table

from testbed.cli.console import command_line, print_as_json, say, show
from testbed.cli.options import print_folder
from testbed.cli.tables import parameter_table
from testbed.library.comparisons import compare
from testbed.outputs.folder import reserved_folder
from testbed.report.comparison import ComparedFigures
from testbed.report.wording import capitalized, estimator_name


def compare_results(folders: Sequence[Path], out: Path | None) -> None:
    """Print the figures of several runs or campaigns beside each other, and write them as a page.

    Raises:
        InputError: a folder holds no result, or runs are mixed with campaigns.
    """
    comparison = compare(folders)
    with reserved_folder(out, "comparison") as folder:
        folder.deliver(lambda place: comparison.write(place, command_line()))
    for estimator, figures in groupby(comparison.figures, key=lambda each: each.estimator):
        say(capitalized(estimator_name(estimator)))
        for each in figures:
            show(_table(each))
            say()
    print_folder(folder.path)
    print_as_json(folder.path / "comparison.json")


def _table(figures: ComparedFigures) -> Table:
    table = parameter_table(f"  {figures.figure}" + (f", {figures.unit}" if figures.unit else ""))
    for name, values in figures.rows.items():
        if name in figures.stds:
            shown = partial(figures.inertia_unit.shown, decimals=4)
            table.add_row(name, *map(shown, values))
            table.add_row("", *(f"±{shown(std)}" for std in figures.stds[name]), style="dim")
        else:
            table.add_row(name, *figures.cells(name))
    return table
