"""testbed design: a scenario's maneuver, without flying it."""

from __future__ import annotations

from pathlib import Path

from rich.table import Table

from testbed.assembly.platform import nominal_platform
from testbed.cli.console import command_line, design_progress, say, show
from testbed.cli.failures import naming
from testbed.cli.tables import design_lines
from testbed.delivery.design_folder import write_design
from testbed.delivery.folder import reserved_folder
from testbed.delivery.provenance import provenance
from testbed.errors import InputError
from testbed.experiment.planning import design_seed, plan_maneuver, starts_of
from testbed.maneuver.design import Design
from testbed.scenario.reader import scenario_file, scenario_of


def design_scenario(path: Path, out: Path | None, seed: int | None) -> None:
    """Design the maneuver, print every start, write the maneuver for use in another scenario.

    Raises:
        InputError: the scenario has nothing to design, or its limits cannot be met.
    """
    file = scenario_file(path)
    scenario = scenario_of(file)
    if not starts_of(scenario):
        raise InputError(f'{path}: maneuver.kind is "{scenario.maneuver.kind}"; only "design" has something to design')
    origin = provenance(scenario, file, command_line(), deciding={"seed": str(design_seed(scenario, seed))})
    with reserved_folder(out, f"{scenario.name}-design") as folder:
        with naming(path), design_progress(starts_of(scenario)) as report:
            plan = plan_maneuver(scenario, nominal_platform(scenario), report, seed)
        design = plan.design
        assert design is not None
        folder.deliver(lambda place: write_design(place, file, origin, scenario, design))
    show(_starts_table(design))
    for line in design_lines(design):
        say(line)
    say()
    say(f"Folder     {folder.path}: maneuver.toml can replace the scenario's [maneuver], maneuver.csv is its table")


def _starts_table(design: Design) -> Table:
    table = Table(title="Starts", title_justify="left", title_style="bold")
    for column in ("start", "cost", "seconds", "status"):
        table.add_column(column, justify="left" if column == "status" else "right")
    for start in design.starts:
        mark = " <- best" if start.index == design.best else ""
        table.add_row(str(start.number), f"{start.cost:.5g}", f"{start.seconds:.2f}", start.status + mark)
    return table
