"""testbed design: a scenario's maneuver, without flying it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from rich.box import SIMPLE_HEAD
from rich.table import Table

from testbed.cli.console import command_line, design_progress, line, print_as_json, say, show, warn
from testbed.cli.options import changed_flight
from testbed.cli.tables import design_lines
from testbed.errors import InputError
from testbed.experiment.planning import starts_of
from testbed.library.runs import design
from testbed.maneuver.design import Design
from testbed.outputs.folder import reserved_folder


def design_scenario(source: str, changes: Sequence[str], out: Path | None, seed: int | None) -> None:
    """Design the maneuver, print every start, write the maneuver for use in another scenario.

    Raises:
        InputError: the scenario has nothing to design, or its limits cannot be met.
    """
    scenario = changed_flight(source, changes)
    if not starts_of(scenario):
        kind = scenario.maneuver.kind
        raise InputError(f'{source}: maneuver.kind is "{kind}"; only "design" has something to design')
    with reserved_folder(out, f"{scenario.name}-design") as folder:
        with design_progress(starts_of(scenario)) as report:
            maneuver = design(scenario, seed=seed, progress=report)
        designed = maneuver.plan.design
        assert designed is not None
        folder.deliver(lambda place: maneuver.write(place, command_line()))
    show(_starts_table(designed))
    for text in design_lines(designed):
        line(text)
    for notice in maneuver.notices:
        warn("note", notice)
    say()
    line(f"Folder     {folder.path}: maneuver.toml can replace the scenario's [maneuver], maneuver.csv is its table")
    print_as_json(folder.path / "design.json")


def _starts_table(design: Design) -> Table:
    table = Table(
        title="Starts", title_justify="left", title_style="bold", box=SIMPLE_HEAD, show_edge=False, pad_edge=False
    )
    for column in ("start", "cost", "seconds", "status"):
        table.add_column(column, justify="left" if column == "status" else "right")
    for start in design.starts:
        mark = " <- best" if start.index == design.best else ""
        table.add_row(
            str(start.number),
            f"{start.cost:.5g}",
            f"{start.seconds:.2f}",
            start.ended + mark,
        )
    return table
