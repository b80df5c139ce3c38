"""testbed campaign-plan: fly until a verdict is sure, or say what to fly next."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from rich.progress import SpinnerColumn, TimeElapsedColumn
from rich.table import Table
from rich.text import Text

from testbed.cli.console import (
    Bars,
    command_line,
    console,
    description_column,
    entry,
    further_command,
    print_as_json,
    say,
    say_interrupted,
    show,
    warn,
)
from testbed.cli.failures import COMPLETED, INTERRUPTED
from testbed.cli.options import changed_flight, print_folder, require_folder
from testbed.cli.tables import plain_table
from testbed.errors import InputError
from testbed.formats.plan import PlanResult
from testbed.library.plan_flights import Maneuvers, PlanSetup
from testbed.library.plans import plan_in, require_plan, wanted_of
from testbed.library.records import read_records
from testbed.outputs.folder import reserved_folder
from testbed.outputs.plan_folder import PLAN, PlanFolder
from testbed.report.plan import (
    factor_words,
    leading_words,
    next_words,
    plan_verdict,
    std_words,
    verdict_words,
    wish_words,
)

_MANEUVERS: dict[str, Maneuvers] = {"chosen": "chosen", "own": "own"}


def plan_campaign(
    source: str,
    changes: Sequence[str],
    wanted: tuple[str | None, str | None],
    data: Path | None,
    out: Path | None,
    flights: int,
    alpha: float,
    seed: int | None,
    *,
    maneuvers: str,
    resume: bool,
) -> int:
    """Fly, or propose a flight, until what is wanted is known; print and keep every flight.

    Args:
        source: path of the scenario, or name of a shipped one.
        changes: of the scenario, KEY=VALUE each.
        wanted: the effect whose name is wanted, and the standard deviations of the inertia; one of them, or neither.
        data: folder of records flown already; None without.
        out: new or empty folder, or that of the plan to go on with; None for a fresh one.
        flights: at most.
        alpha: probability of a false name.
        seed: of simulated flights; the scenario's where None.
        maneuvers: chosen or own.
        resume: whether to go on with the plan in the folder.

    Returns:
        The exit code; Ctrl-C keeps every flight that was flown.

    Raises:
        InputError: something that was given cannot be used.
    """
    scenario = changed_flight(source, changes)
    require_folder("plan", out, resume=resume)
    if maneuvers not in _MANEUVERS:
        raise InputError(f"--maneuvers {maneuvers}: give {' or '.join(_MANEUVERS)}")
    wish = wanted_of(scenario, *wanted)
    require_plan(alpha, flights)
    records = None if data is None else read_records(data)
    with reserved_folder(out, f"{scenario.name}-plan", resume=resume) as folder, _bars() as bars:
        task = bars.add_task("Reading", total=None)
        setup = PlanSetup(
            scenario=scenario,
            wanted=wish,
            alpha=alpha,
            most_flights=flights,
            seed=scenario.seed if seed is None else seed,
            maneuvers=_MANEUVERS[maneuvers],
            folder=PlanFolder(path=folder.path),
            progress=lambda what: bars.update(task, description=what[:1].upper() + what[1:]),
        )
        shown = _Flights(bars, len(setup.folder.kept()[0].flights) if resume else 0)
        try:
            found = plan_in(setup, records, command_line(), resume=resume, after=shown.show)
        except KeyboardInterrupt:
            bars.stop()
            say_interrupted(f"; every flight is kept: repeat the command with --out {folder.path} --resume to go on.")
            return INTERRUPTED
        bars.stop()
    shown.show(found.result)
    _print_end(found.result, folder.path)
    return COMPLETED


def _bars() -> Bars:
    return Bars(SpinnerColumn(), description_column(), TimeElapsedColumn(), transient=True)


class _Flights:
    """Prints each flight of this call once, as it comes."""

    def __init__(self, bars: Bars, known: int) -> None:
        self._bars, self._shown, self._begun = bars, known, False

    def show(self, state: PlanResult) -> None:
        """Print what is new."""
        new = state.flights[self._shown :]
        if not new and self._begun:
            return
        self._bars.stop()  # what is printed beside a bar that moves would be torn
        if not self._begun:
            self._begun = True
            entry("Wanted", wish_words(state))
            entry("Flown", "in MuJoCo, on the scenario's [truth]" if state.simulated else "by you, one after the other")
        for flight in new:
            entry(f"Flight {flight.number}", f"{flight.record}: {_said(state, flight.number - 1)}")
        self._shown = len(state.flights)
        self._bars.start()


def _said(state: PlanResult, index: int) -> str:
    flight = state.flights[index]
    leading = f"e-value {factor_words(flight.log_e_value)}, leading {leading_words(flight)}"
    if state.wanted.effect is None:
        return f"worst standard deviation {std_words(flight, state)} times the wanted one; {leading}"
    return leading if flight.verdict is None else f"{leading}; diagnosis {verdict_words(flight)}"


def _print_end(state: PlanResult, folder: Path) -> None:
    if state.flights:
        say()
        show(_table(state))
    for notice in state.notices:
        warn("note", notice)
    say()
    verdict = plan_verdict(state)
    colour = {"good": "green", "warn": "yellow", "bad": "red"}.get(verdict.tone, "default")
    console.print(Text.assemble(("Verdict", colour), f"    {(state.outcome or 'not yet').replace('_', ' ')}"))
    entry("", verdict.text)
    if state.next is not None:
        entry("Next", next_words(state))
        entry("", f"Fly {folder / state.next.scenario}, put its record into a folder, and repeat the command with")
        entry("", f"--data FOLDER --out {folder} --resume")
    say()
    print_folder(folder)
    if state.flights:
        diagnose = further_command("diagnose", folder / "scenario.toml", "--data", folder / "records")
        say(f"Records    {diagnose}")
    print_as_json(folder / PLAN)


def _table(state: PlanResult) -> Table:
    table = plain_table("Flights: e-values against no effect, with all flights up to each")
    columns = ["flight", "record", "e-value", "leading effect", "its e-value", "diagnosis"]
    if state.wanted.effect is None:
        columns[-1] = "std over wanted"
    for title in columns:
        table.add_column(title, no_wrap=True)
    for flight in state.flights:
        last = verdict_words(flight) if state.wanted.effect is not None else std_words(flight, state)
        table.add_row(
            str(flight.number),
            flight.record,
            factor_words(flight.log_e_value),
            leading_words(flight),
            factor_words(flight.leading_log_e_value),
            last,
        )
    return table
