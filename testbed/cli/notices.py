"""A page's verdict and notices on the terminal, above all those that put the figures in doubt."""

from __future__ import annotations

from collections.abc import Iterable

from rich.text import Text

from testbed.cli.console import LABEL_WIDTH, console, entry, warn
from testbed.report.frame.blocks import Notice

_COLOURS = {"good": "green", "warn": "yellow", "bad": "red"}
_WORDS = {"good": "good", "warn": "in doubt", "bad": "bad"}


def print_verdict(verdict: Notice) -> None:
    """Print a verdict: its word in colour, then its text."""
    label = Text("Verdict".ljust(LABEL_WIDTH), style=_COLOURS.get(verdict.tone, ""))
    console.print(label + Text(_WORDS.get(verdict.tone, "")))
    entry("", verdict.text)


def print_notices(notices: Iterable[Notice]) -> None:
    """Print notices, a line each; those that warn stand out."""
    for notice in notices:
        if notice.tone == "plain":
            entry("note", notice.text)
        else:
            warn("warning", notice.text)
