"""The terminal: one console, and the progress of a multi-start design."""

from __future__ import annotations

import json
import shlex
import shutil
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import timedelta
from math import ceil, inf, isfinite
from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING, Any

from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    ProgressColumn,
    Task,
    TaskID,
    TextColumn,
    TimeElapsedColumn,
)
from rich.table import Table
from rich.text import Text

from testbed.cli.table_layout import fitted
from testbed.files import readable

if TYPE_CHECKING:
    from testbed.maneuver.design import Start  # it would bring CasADi to every command

# No text is read as rich's markup: what users call things may look like it.
console = Console(markup=False, emoji=False, highlight=False, soft_wrap=True)
terminal = Console(markup=False, emoji=False, highlight=False, soft_wrap=True, stderr=True)
LABEL_WIDTH = 11
"""Columns before the text of an entry."""
RATE_PERIOD = 120.0
"""s, over which the rate of a campaign is averaged: blocks come in every few seconds."""


def command_line() -> str:
    """Return the command as it was given, quoted for a shell."""
    return shlex.join(map(readable, [Path(sys.argv[0]).name, *sys.argv[1:]]))


def further_command(*words: object) -> str:
    """Return a command to go on with, as this person can call it: by its name where that is on the path."""
    called = sys.argv[0]
    name = called if Path(called).stem == "testbed" and shutil.which("testbed") is None else "testbed"
    return shlex.join(readable(str(word)) for word in (name, *words))


@dataclass(kw_only=True)
class _Output:
    """What a command prints.

    Attributes:
        json: whether its result as JSON, and nothing else, on standard output.
        quiet: whether nothing but errors.
    """

    json: bool = False
    quiet: bool = False


_OUTPUT = _Output()


def choose_output(*, json: bool, quiet: bool) -> None:
    """Choose what this command prints: its result for people, as JSON, or nothing but errors."""
    _OUTPUT.json, _OUTPUT.quiet = json, quiet
    console.quiet = json or quiet
    terminal.quiet = quiet


def print_as_json(path: Path) -> None:
    """Print a result that was written, with its folder, where JSON was asked for."""
    if _OUTPUT.json:
        content = json.loads(path.read_text(encoding="utf-8"))
        print(json.dumps(content | {"folder": str(path.parent)}, indent=1))


def say(text: str = "") -> None:
    """Print text as it is."""
    console.print(text)


def say_interrupted(how: str) -> None:
    """Say that a command was interrupted and how to go on; on standard error where results alone are printed.

    Args:
        how: it ended, in words that follow on "Interrupted".
    """
    print(f"Interrupted{how}", file=sys.stderr if console.quiet else None)


def show(table: Table) -> None:
    """Print a table, in parts one below the other where it is too wide."""
    for part in fitted(table, console):
        console.print(part)


def warn(what: str, why: str) -> None:
    """Print a sentence whose first words stand out; broken between words on a terminal."""
    text = Text.assemble((f"{what}:", "yellow"), f" {why}")
    console.print(text, soft_wrap=not console.is_terminal)


def entry(label: str, text: str) -> None:
    """Print a text beside its label: broken between words on a terminal, elsewhere on one line, to be searched."""
    indent = " " * LABEL_WIDTH
    width = console.width if console.is_terminal else sys.maxsize
    say(
        fill(
            text.replace(" %", "\N{NO-BREAK SPACE}%") if console.is_terminal else text,
            width,
            initial_indent=label.ljust(LABEL_WIDTH),
            subsequent_indent=indent,
            break_long_words=False,
            break_on_hyphens=False,
        )
    )


def entries(label: str, texts: Sequence[str]) -> None:
    """Print texts below each other, the first one beside their label."""
    for number, text in enumerate(texts):
        entry("" if number else label, text)


def line(text: str) -> None:
    """Print a line that begins with its label, as `entry` does."""
    entry(text[:LABEL_WIDTH].rstrip(), text[LABEL_WIDTH:])


LINE_PERIOD = 10.0
"""s between two lines on how far a work is, where standard error is no terminal; a short command prints none."""


class Bars(Progress):
    """Progress on standard error: bars on a terminal, else now and then a line, as a log of a batch system keeps it."""

    def __init__(self, *columns: ProgressColumn, **options: Any) -> None:  # noqa: ANN401 - those of Progress
        """Take the columns of the bars, and further options of rich's Progress."""
        super().__init__(*columns, console=terminal, disable=not terminal.is_terminal, **options)
        self._printed = time.monotonic()

    def update(self, task_id: TaskID, **changes: Any) -> None:  # noqa: ANN401
        """Change a task, as in Progress."""
        super().update(task_id, **changes)
        if terminal.is_terminal or time.monotonic() - self._printed < LINE_PERIOD:
            return
        self._printed = time.monotonic()
        task = next(each for each in self.tasks if each.id == task_id)
        done = "" if task.total is None or task.total <= 1 else f": {task.completed:.0f} of {task.total:.0f}"
        terminal.print(f"{task.description}{done}")


@contextmanager
def design_progress(starts: int) -> Iterator[Callable[[Start], None]]:
    """Show how many starts of a design are done and the best cost so far, on standard error.

    Args:
        starts: number of starts; 0 where nothing is designed, and nothing is shown.
    """
    columns = (description_column(), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with Bars(*columns, transient=True) as progress:
        task = progress.add_task("Designing the maneuver", total=starts, visible=starts > 0)
        best = inf

        def report(start: Start) -> None:
            nonlocal best
            best = min(best, start.cost)
            found = f", best cost {best:.4g}" if isfinite(best) else ""
            progress.update(task, description=f"Designing the maneuver{found}", advance=1)

        yield report


def description_column() -> TextColumn:
    """Return the column that says what is being done."""
    return TextColumn("{task.description}", markup=False)


class RateColumn(ProgressColumn):
    """How fast items are done, since the start: those of a block come all at once, which would mislead any window."""

    def __init__(self, unit: str) -> None:
        """Remember the unit, such as runs/s."""
        super().__init__()
        self._unit = unit

    def render(self, task: Task) -> Text:
        """Return the rate; a dash until it is known."""
        rate = rate_of(task)
        return Text(f"{rate:.3g} {self._unit}" if rate else f"- {self._unit}")


class TimeLeftColumn(ProgressColumn):
    """How long it will take at the rate since the start."""

    def render(self, task: Task) -> Text:
        """Return the time; a dash until it is known."""
        rate = rate_of(task)
        return Text(f"{timedelta(seconds=ceil((task.remaining or 0.0) / rate))} left" if rate else "-:--:-- left")


def rate_of(task: Task) -> float:
    """Return how many items a second were done; what was there at the start, its field `before`, does not count."""
    done = task.completed - task.fields.get("before", 0)
    elapsed = task.finished_time if task.finished else task.elapsed
    return done / elapsed if elapsed else 0.0
