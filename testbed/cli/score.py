"""testbed score: many diagnoses against the sealed answers."""

from __future__ import annotations

import json
from itertools import groupby
from pathlib import Path

from rich.box import SIMPLE_HEAD
from rich.table import Table

from testbed.cli.console import say, show, warn
from testbed.errors import InputError
from testbed.files import whole_file
from testbed.scoring.card import ScoreCard, card_content, score_card
from testbed.scoring.case import read_cases
from testbed.scoring.rows import Row


def score_diagnoses(diagnoses: Path, answers: Path, out: Path | None) -> None:
    """Print the score card of diagnoses, and write it where --out says.

    Raises:
        InputError: there are no answers or no diagnoses, an answer is not what was sealed, or the file is there.
    """
    if out is not None and out.exists():
        raise InputError(f"{out}: is there already; give --out a new file, nothing is overwritten")
    card = score_card(read_cases(diagnoses, answers))
    print_card(card)
    if out is not None:
        write_card(card, out)
        say()
        say(f"Written    {out}")


def write_card(card: ScoreCard, path: Path) -> None:
    """Write a score card as JSON.

    Raises:
        InputError: the file cannot be written.
    """
    try:
        with whole_file(path) as part:
            part.write_text(json.dumps(card_content(card), indent=1) + "\n", encoding="utf-8")
    except OSError as error:
        raise InputError(f"{path}: cannot be written ({error.strerror}); make room or choose another") from error


def print_card(card: ScoreCard) -> None:
    """Print a score card."""
    say(f"Cases      {card.cases}, {card.sealed} of their answers as they were sealed")
    for name, failure in card.failures.items():
        warn(name, f"counts as a miss: {failure}")
    say()
    show(card_table(card))
    say()
    show(confusion_table(card))


def card_table(card: ScoreCard) -> Table:
    """Return the figures, a row each, with their 95 % intervals."""
    table = Table(box=SIMPLE_HEAD, show_edge=False, pad_edge=False, padding=(0, 1, 0, 0))
    table.add_column(no_wrap=True)
    for heading in ("", "of", "95 % interval"):
        table.add_column(heading, justify="right", no_wrap=True)
    table.add_column("wanted")
    for part, rows in groupby(card.rows, key=lambda row: row.part):
        table.add_row(part, style="bold")
        for row in rows:
            table.add_row(f"  {row.what}", _value(row), str(row.of), _interval(row), row.wanted)
            if row.upper_limit is not None and row.limit_wanted:
                table.add_row("  its one-sided 95 % limit", f"{row.upper_limit:.1%}", "", "", row.limit_wanted)
    return table


def confusion_table(card: ScoreCard) -> Table:
    """Return what was said first of each hidden effect, the most frequent first."""
    table = Table("hidden", "reported first, times", box=SIMPLE_HEAD, show_edge=False, pad_edge=False)
    for hidden, counts in card.confusion.items():
        table.add_row(hidden, ", ".join(f"{label} {count}" for label, count in counts.items()))
    return table


def _value(row: Row) -> str:
    if row.value is None:
        return "-"
    return f"{row.value:.3g}" if row.hits is None else f"{row.value:.1%}"


def _interval(row: Row) -> str:
    if row.low is None or row.high is None:
        return "-"
    form = ".3g" if row.hits is None else ".1%"
    return f"{row.low:{form}} to {row.high:{form}}"
