"""The `testbed` command and its subcommands."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

from testbed.cli.failures import exit_code_of

ScenarioPath = Annotated[Path, typer.Argument(metavar="SCENARIO", help="A scenario file (TOML).", show_default=False)]
Out = Annotated[
    Path | None,
    typer.Option(metavar="DIR", help="New or empty folder for the results; by default a fresh one under runs/."),
]
Seed = Annotated[int | None, typer.Option(min=0, max=2**63 - 1, help="Seed of all noise; by default the scenario's.")]

app = typer.Typer(
    name="testbed",
    help="Identify a spacecraft's inertia with control moment gyros, simulator in the loop.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)


def main() -> None:
    """Run the command; errors in the input end it with a message and exit code 2."""
    sys.exit(exit_code_of(app))


@app.command()
def run(
    scenario: ScenarioPath,
    out: Out = None,
    seed: Seed = None,
    view: Annotated[bool, typer.Option("--view", help="Open the recording when the run is done.")] = False,
) -> None:
    """Design, fly, estimate and record a scenario."""
    from testbed.cli.run import run_scenario  # noqa: PLC0415 - engines load only when a command needs them

    raise typer.Exit(run_scenario(scenario, out, seed, view=view))


@app.command()
def design(scenario: ScenarioPath, out: Out = None, seed: Seed = None) -> None:
    """Design a scenario's maneuver, without flying it."""
    from testbed.cli.design import design_scenario  # noqa: PLC0415

    design_scenario(scenario, out, seed)


@app.command()
def estimate(
    scenario: ScenarioPath,
    data: Annotated[Path, typer.Option(metavar="FOLDER", help="Folder of records: NAME.csv or NAME.parquet.")],
    out: Out = None,
) -> None:
    """Estimate the inertia from records measured elsewhere; the scenario is the nominal model."""
    from testbed.cli.estimate import estimate_records  # noqa: PLC0415

    estimate_records(scenario, data, out)


@app.command()
def check(scenario: ScenarioPath) -> None:
    """Check a scenario: everything that is wrong with it at once."""
    from testbed.cli.check import check_scenario  # noqa: PLC0415

    check_scenario(scenario)


@app.command()
def view(
    run: Annotated[
        Path, typer.Argument(metavar="RUN", help="A run folder, or a recording (.rrd).", show_default=False)
    ],
    web: Annotated[bool, typer.Option("--web", help="In the browser, served on loopback only.")] = False,
) -> None:
    """Open a run's recording in the rerun viewer."""
    from testbed.cli.view import view_run  # noqa: PLC0415

    view_run(run, web=web)
