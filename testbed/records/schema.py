"""The signal table as documentation."""

from __future__ import annotations

from testbed.signals import SIGNALS, Signal


def signals_table() -> str:
    """Return the columns of a record as a Markdown table, one row per signal, for docs/reference/records.md."""
    head = ["| column | unit | frame | meaning | sent in flight |", "|---|---|---|---|---|"]
    return "\n".join([*head, "| `time_s` | s |  | time | yes |", *map(_row, SIGNALS.values())]) + "\n"


def _row(signal: Signal) -> str:
    first, last = f"`{signal.columns[0]}`", f"`{signal.columns[-1]}`"
    columns = first if signal.width == 1 else f"{first} ... {last}"
    sent = "yes" if signal.telemetry else "no"
    return f"| {columns} | {signal.unit or '1'} | {signal.frame} | {signal.label} | {sent} |"
