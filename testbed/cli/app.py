"""The `testbed` command and its subcommands."""

from __future__ import annotations

from importlib.metadata import version
from pathlib import Path
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from testbed.interrupts import Interrupted
from testbed.limits import LARGEST_SEED, MOST_RUNS, MOST_WORKERS


def _completed(start: str) -> list[str]:
    """Return the shipped scenarios whose names begin like this, for the shell's completion."""
    from testbed.scenario.shipped import shipped_scenarios  # noqa: PLC0415

    return [name for name in shipped_scenarios() if name.startswith(start)]


ScenarioName = Annotated[
    str,
    typer.Argument(
        metavar="SCENARIO",
        help="A scenario file (TOML), or the name of a shipped one: see `testbed list`.",
        show_default=False,
        autocompletion=_completed,
    ),
]
Changes = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="KEY=VALUE",
        help="Another value for a key: gyro.noise_rad_s=0.01. Repeatable.",
    ),
]
Json = Annotated[bool, typer.Option("--json", help="Print the result as JSON, and nothing else.")]
Quiet = Annotated[bool, typer.Option("--quiet", help="Print nothing but errors.")]
Out = Annotated[
    Path | None,
    typer.Option(metavar="DIR", help="New or empty folder for the results; by default a fresh one under runs/."),
]
MOST_SEEDS = 1000
"""Of a reproduction: each takes minutes."""
Seed = Annotated[
    int | None, typer.Option(min=0, max=LARGEST_SEED, help="Seed of all noise; by default the scenario's.")
]


class Commands(TyperGroup):
    """Lets interrupts reach the one place that reports them; Typer would end the process without a word."""

    def invoke(self, ctx: Any) -> Any:  # noqa: ANN401 - Typer keeps its type to itself
        """Run a command."""
        try:
            return super().invoke(ctx)
        except KeyboardInterrupt as interrupt:
            raise Interrupted(*interrupt.args) from interrupt


_HELP = {"help_option_names": ["-h", "--help"], "max_content_width": 120}
"""Help as wide as the terminal, up to 120 columns: in the usual 80 what a command is for is cut off."""

app = typer.Typer(
    name="testbed",
    cls=Commands,
    help="Identify a spacecraft's inertia, simulator in the loop.",
    no_args_is_help=True,
    context_settings=_HELP,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)


def _print_version(wanted: bool) -> None:
    if wanted:
        print(f"testbed {version('testbed')}")
        raise typer.Exit


@app.callback()
def main(
    _: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None:
    """Identify a spacecraft's inertia, simulator in the loop."""


# Commands import what they need when they are called: engines take a second or two to load.


def _choose_output(*, json: bool, quiet: bool) -> None:
    from testbed.cli.console import choose_output  # noqa: PLC0415

    choose_output(json=json, quiet=quiet)


@app.command()
def run(
    scenario: ScenarioName,
    out: Out = None,
    seed: Seed = None,
    dispersed: Annotated[
        bool, typer.Option("--dispersed", help="Draw the scenario's [dispersion], as a campaign's run with this seed.")
    ] = False,
    view: Annotated[bool, typer.Option("--view", help="Open the recording when the run is done.")] = False,
    changes: Changes = None,
    json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Design, fly, estimate and record a scenario."""
    from testbed.cli.run import run_scenario  # noqa: PLC0415

    _choose_output(json=json, quiet=quiet)
    raise typer.Exit(run_scenario(scenario, changes or (), out, seed, drawn=dispersed, view=view))


@app.command()
def montecarlo(
    scenario: ScenarioName,
    runs: Annotated[int, typer.Option(metavar="N", min=2, max=MOST_RUNS, help="How many runs.", show_default=False)],
    seed: Annotated[
        int | None,
        typer.Option(min=0, max=LARGEST_SEED, help="From which every run has its seed; by default the scenario's."),
    ] = None,
    out: Out = None,
    resume: Annotated[bool, typer.Option("--resume", help="Go on with the campaign in DIR.")] = False,
    scheduler: Annotated[
        str | None, typer.Option(metavar="ADDRESS", help="Fly on a Dask cluster: tcp://host:port of its scheduler.")
    ] = None,
    workers: Annotated[
        int | None,
        typer.Option(metavar="N", min=1, max=MOST_WORKERS, help="Cores to use on this machine; by default all."),
    ] = None,
    check: Annotated[
        int,
        typer.Option(metavar="N", min=0, max=MOST_RUNS, help="Fly N of the runs by both engines, and compare them."),
    ] = 0,
    changes: Changes = None,
    json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Fly a scenario many times, each run with its own noise and dispersions, and give statistics."""
    from testbed.cli.montecarlo import run_montecarlo  # noqa: PLC0415

    _choose_output(json=json, quiet=quiet)
    code = run_montecarlo(
        scenario,
        changes or (),
        runs,
        seed,
        out,
        resume=resume,
        scheduler=scheduler,
        workers=workers,
        check=check,
    )
    raise typer.Exit(code)


@app.command(name="campaign-plan")
def campaign_plan(
    scenario: ScenarioName,
    effect: Annotated[
        str | None,
        typer.Option(
            metavar="NAME", help="Wanted: the name of `any` effect, of ID or of ID:COMPONENT; by default any."
        ),
    ] = None,
    inertia_std: Annotated[
        str | None,
        typer.Option(metavar="STD", help="Wanted instead: J to this standard deviation in kg m², or J11=STD,J22=STD."),
    ] = None,
    data: Annotated[
        Path | None, typer.Option(metavar="FOLDER", help="Flights flown already; with --resume, new ones too.")
    ] = None,
    flights: Annotated[int, typer.Option(metavar="N", min=1, max=MOST_SEEDS, help="At most.")] = 20,
    alpha: Annotated[float, typer.Option(help="Probability of a false name, at whatever flight it stops.")] = 0.05,
    maneuvers: Annotated[
        str, typer.Option(metavar="chosen|own", help="By expected gain, or the scenario's own in every flight.")
    ] = "chosen",
    seed: Seed = None,
    out: Out = None,
    resume: Annotated[bool, typer.Option("--resume", help="Go on with the plan in DIR.")] = False,
    changes: Changes = None,
    json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Fly until an effect is named for sure, or J is known well enough; without a [truth], one flight a call."""
    from testbed.cli.campaign_plan import plan_campaign  # noqa: PLC0415

    _choose_output(json=json, quiet=quiet)
    wanted = (effect, inertia_std)
    raise typer.Exit(
        plan_campaign(
            scenario, changes or (), wanted, data, out, flights, alpha, seed, maneuvers=maneuvers, resume=resume
        )
    )


@app.command()
def reproduce(
    out: Out = None,
    quick: Annotated[
        bool, typer.Option("--quick", help="A tenth of the flights: under 4 minutes on two cores.")
    ] = False,
    seed: Annotated[int, typer.Option(min=0, max=LARGEST_SEED, help="Seed of everything.")] = 1,
    runs: Annotated[
        int | None,
        typer.Option(metavar="N", min=2, max=MOST_RUNS, help="Of each maneuver of Table 2; 1000, with --quick 100."),
    ] = None,
    seeds: Annotated[
        int,
        typer.Option(
            metavar="N", min=1, max=MOST_SEEDS, help="Judge the claims again with N seeds from --seed on, and count."
        ),
    ] = 1,
    resume: Annotated[bool, typer.Option("--resume", help="Go on with the reproduction in DIR.")] = False,
) -> None:
    """Make the paper's tables and figures again, beside its own numbers and this project's."""
    from testbed.cli.reproduce import reproduce_paper  # noqa: PLC0415

    raise typer.Exit(reproduce_paper(out, seed, runs, quick=quick, resume=resume, seeds=seeds))


@app.command()
def design(
    scenario: ScenarioName,
    out: Out = None,
    seed: Seed = None,
    changes: Changes = None,
    json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Design a scenario's maneuver, without flying it."""
    from testbed.cli.design import design_scenario  # noqa: PLC0415

    _choose_output(json=json, quiet=quiet)
    design_scenario(scenario, changes or (), out, seed)


@app.command()
def estimate(
    scenario: ScenarioName,
    data: Annotated[Path, typer.Option(metavar="FOLDER", help="Folder of records: NAME.csv or NAME.parquet.")],
    out: Out = None,
    changes: Changes = None,
    json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Estimate the inertia from records measured elsewhere; the scenario is the nominal model."""
    from testbed.cli.estimate import estimate_records  # noqa: PLC0415

    _choose_output(json=json, quiet=quiet)
    estimate_records(scenario, changes or (), data, out)


@app.command()
def diagnose(
    scenario: ScenarioName,
    data: Annotated[Path, typer.Option(metavar="FOLDER", help="Folder of records: NAME.csv or NAME.parquet.")],
    reference: Annotated[
        Path | None,
        typer.Option(metavar="HEALTHY", help="Folder of healthy records: only what is new against them is named."),
    ] = None,
    out: Out = None,
    resume: Annotated[bool, typer.Option("--resume", help="Go on with the interrupted diagnosis in DIR.")] = False,
    changes: Changes = None,
    json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Find where the nominal model and measured records disagree, and name the effect that is missing."""
    from testbed.cli.diagnose import diagnose_records  # noqa: PLC0415

    _choose_output(json=json, quiet=quiet)
    raise typer.Exit(diagnose_records(scenario, changes or (), data, out, resume=resume, reference=reference))


@app.command(name="import")
def import_log(
    log: Annotated[
        list[Path],
        typer.Argument(metavar="LOG...", help="ULog, MCAP, ROS bag, CSV or Parquet; several become one data set."),
    ],
    log_map: Annotated[
        Path | None,
        typer.Option("--map", metavar="MAP.toml", help="Which topics and fields are which channels, and how."),
    ] = None,
    out: Out = None,
    guess: Annotated[
        bool, typer.Option("--guess", help="Print a map proposed from names and units, to be checked.")
    ] = False,
    json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Import logs of another program as records."""
    from testbed.cli.imports import import_records  # noqa: PLC0415

    _choose_output(json=json, quiet=quiet)
    import_records(log, log_map, out, guess=guess, json=json)


@app.command()
def conceal(
    scenario: ScenarioName,
    out: Annotated[Path, typer.Option(metavar="DIR", help="New or empty folder for data and answer.")],
    seed: Annotated[int, typer.Option(min=0, max=LARGEST_SEED, help="Seed of everything.", show_default=False)],
    effect: Annotated[list[str] | None, typer.Option(metavar="ID", help="Hide this effect; may be repeated.")] = None,
    random: Annotated[bool, typer.Option("--random", help="Hide one effect, whichever is drawn.")] = False,
    size: Annotated[
        float | None,
        typer.Option(
            min=1e-3, max=1e3, help="In smallest detectable sizes, in sigma for what no library lists; else drawn."
        ),
    ] = None,
    runs: Annotated[int | None, typer.Option(metavar="N", min=1, max=50, help="How many; by default drawn.")] = None,
) -> None:
    """Make a blind data set with hidden effects, or none, and a sealed answer; in a checkout only."""
    from testbed.cli.conceal import conceal_effects  # noqa: PLC0415

    conceal_effects(scenario, out, effect or (), seed, drawn=random, size=size, runs=runs)


@app.command()
def score(
    diagnoses: Annotated[
        Path, typer.Argument(metavar="DIAGNOSES", help="Folder with case_*/diagnosis.json.", show_default=False)
    ],
    answers: Annotated[
        Path, typer.Argument(metavar="ANSWERS", help="Folder with case_*/answer.json.", show_default=False)
    ],
    out: Annotated[Path | None, typer.Option(metavar="FILE", help="New file for the score card as JSON.")] = None,
) -> None:
    """Score many diagnoses against sealed answers, each figure with its interval."""
    from testbed.cli.score import score_diagnoses  # noqa: PLC0415

    score_diagnoses(diagnoses, answers, out)


@app.command()
def compare(
    folders: Annotated[
        list[Path],
        typer.Argument(metavar="RUN...", help="Folders of runs, or of campaigns, two or more.", show_default=False),
    ],
    out: Out = None,
    json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Compare runs, or campaigns, side by side."""
    from testbed.cli.compare import compare_results  # noqa: PLC0415

    _choose_output(json=json, quiet=quiet)
    compare_results(folders, out)


@app.command(name="list")
def list_shipped() -> None:
    """List the shipped scenarios and what each is for."""
    from testbed.cli.scenarios import list_scenarios  # noqa: PLC0415

    list_scenarios()


@app.command()
def new(
    name: Annotated[str, typer.Argument(metavar="NAME", help="Of the scenario, and of its file.", show_default=False)],
    source: Annotated[
        str,
        typer.Option(
            "--from",
            metavar="SCENARIO",
            help="To copy: a scenario file, or the name of a shipped one.",
            autocompletion=_completed,
        ),
    ] = "zero_g",
) -> None:
    """Write NAME.toml, a scenario of your own, from another one."""
    from testbed.cli.scenarios import new_scenario  # noqa: PLC0415

    new_scenario(name, source)


@app.command()
def adopt(
    model: Annotated[Path, typer.Argument(metavar="FILE", help="MJCF (.xml) or URDF.", show_default=False)],
    out: Annotated[
        Path | None, typer.Option(metavar="SCENARIO.toml", help="New file; by default the model's name, here.")
    ] = None,
    wheel: Annotated[
        list[str] | None, typer.Option(metavar="NAME", help="This joint is a reaction wheel; repeatable.")
    ] = None,
    rotor: Annotated[
        list[str] | None, typer.Option(metavar="NAME", help="This joint is a gyro's rotor; repeatable.")
    ] = None,
    ignore: Annotated[
        list[str] | None, typer.Option(metavar="NAME", help="This joint is locked as drawn; repeatable.")
    ] = None,
    quiet: Quiet = False,
) -> None:
    """Write a scenario from a model of your own, and say what was taken for what."""
    from testbed.cli.adopt import adopt_model  # noqa: PLC0415

    _choose_output(json=False, quiet=quiet)
    adopt_model(model, out, wheel or (), rotor or (), ignore or ())


@app.command()
def check(scenario: ScenarioName, changes: Changes = None) -> None:
    """Check a scenario: everything that is wrong with it at once."""
    from testbed.cli.check import check_scenario  # noqa: PLC0415

    check_scenario(scenario, changes or ())


@app.command()
def export(
    folder: Annotated[
        Path, typer.Argument(metavar="FOLDER", help="Of a run, of estimates or of a diagnosis.", show_default=False)
    ],
    mjcf: Annotated[Path | None, typer.Option(metavar="FILE", help="New file, for MuJoCo.")] = None,
    urdf: Annotated[Path | None, typer.Option(metavar="FILE", help="New file; URDF knows no motors.")] = None,
    estimator: Annotated[
        str | None, typer.Option(metavar="NAME", help="Whose estimate; by default the most efficient one.")
    ] = None,
    quiet: Quiet = False,
) -> None:
    """Write the estimated platform as MJCF or URDF, for other programs."""
    from testbed.cli.export import export_platform  # noqa: PLC0415

    _choose_output(json=False, quiet=quiet)
    export_platform(folder, mjcf, urdf, estimator)


@app.command()
def view(
    run: Annotated[
        Path,
        typer.Argument(
            metavar="RUN",
            help="Folder of a run, a diagnosis or a reproduction, or a recording (.rrd).",
            show_default=False,
        ),
    ],
    web: Annotated[bool, typer.Option("--web", help="In the browser, served on loopback only.")] = False,
    offline: Annotated[bool, typer.Option("--offline", help="With --web: the page asks no other host.")] = False,
) -> None:
    """Open a run's recording in the rerun viewer."""
    from testbed.cli.view import view_run  # noqa: PLC0415

    view_run(run, web=web, offline=offline)


effects_app = typer.Typer(
    name="effects",
    cls=Commands,
    help="Effects of your own library, which later diagnoses know by their names.",
    no_args_is_help=True,
    context_settings=_HELP,
    rich_markup_mode=None,
)
app.add_typer(effects_app)


@effects_app.command()
def save(
    diagnosis: Annotated[
        Path,
        typer.Argument(metavar="DIAGNOSIS", help="Folder of a diagnosis that named a formula.", show_default=False),
    ],
    name: Annotated[
        str, typer.Argument(metavar="NAME", help="Of the effect: small letters, digits and _.", show_default=False)
    ],
    number: Annotated[
        int | None, typer.Option(min=1, metavar="N", help="Which formula, where the diagnosis named several.")
    ] = None,
) -> None:
    """Keep a formula that a diagnosis named as an effect, as data in your own library."""
    from testbed.cli.effects import save_effect  # noqa: PLC0415

    save_effect(diagnosis, name, number)


@effects_app.command(name="list")
def list_effects() -> None:
    """List the effects of your own library."""
    from testbed.cli.effects import list_kept  # noqa: PLC0415

    list_kept()
