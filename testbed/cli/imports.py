"""testbed import: a log of another program as a data set."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from rich.table import Table

from testbed.cli.console import command_line, entry, further_command, print_as_json, say, show, warn
from testbed.cli.tables import plain_table
from testbed.errors import InputError
from testbed.library.imports import ImportedRecords, guess_map, import_log
from testbed.logs.convert import ImportedChannel
from testbed.outputs.folder import reserved_folder

_MOST_NAMED = 12
"""Topics that are not used and are printed by name; provenance.json names all."""


def import_records(logs: Sequence[Path], log_map: Path | None, out: Path | None, *, guess: bool, json: bool) -> None:
    """Import logs, print where each channel came from and what was left out; or print a proposed map.

    Args:
        logs: their paths.
        log_map: path of MAP.toml.
        out: new or empty folder; None for a fresh one.
        guess: whether to propose a map instead.
        json: whether JSON was asked for.

    Raises:
        InputError: log, map or output folder cannot be used.
    """
    if guess:
        if log_map is not None:
            raise InputError("--guess: proposes a map; leave --map out, or --guess")
        if out is not None:
            raise InputError("--guess: prints a map and writes nothing; leave --out out, or --guess")
        if json:
            raise InputError("--guess: prints a map, which is TOML; leave --json out, or --guess")
        if len(logs) > 1:
            raise InputError("--guess: proposes a map for one log; give one, the others are read by the same map")
        print(guess_map(logs[0]), end="")
        return
    if log_map is None:
        raise InputError("--map: is missing; give MAP.toml, or --guess to have one proposed")
    records = import_log(logs, log_map)
    with reserved_folder(out, f"{logs[0].stem}-import") as folder:
        folder.deliver(lambda place: records.write(place, command_line()))
    _print(records)
    say()
    say(f"Folder     {folder.path}")
    say(f"Next       {further_command('estimate', 'SCENARIO', '--data', folder.path)}, or diagnose")
    print_as_json(folder.path / "provenance.json")


def _print(records: ImportedRecords) -> None:
    for stamp in records.made.inputs:
        say(f"Read       {stamp.path}: {stamp.size:,} bytes, sha256 {stamp.sha256[:16]}...")
    for name, channel in records.channels.items():
        entry("Channel", f"{name}: {_words(channel)}")
    say()
    show(_run_table(records))
    if records.dropped or records.unused or records.unchecked or records.pauses:
        say()
    for each in records.dropped:
        warn("dropped", each)
    for each in records.pauses:
        warn("missing", each)
    for each in records.unchecked:
        warn("unchecked", f"{records.file.path.name}, {each}; confirm it and take the mark away")
    if records.unused:
        more = f" and {len(records.unused) - _MOST_NAMED} more" if len(records.unused) > _MOST_NAMED else ""
        entry("Not used", ", ".join(records.unused[:_MOST_NAMED]) + more)


def _words(channel: ImportedChannel) -> str:
    """Return where a channel came from and what was done to it."""
    source = " of ".join(part for part in (", ".join(channel.fields), channel.topic) if part)
    rate = "" if channel.rate_hz is None else f" at {channel.rate_hz:.4g} Hz"
    count = f"{channel.samples:,} samples{rate}"
    return "; ".join([source, f"clock: {channel.clock}", count, *channel.converted])


def _run_table(records: ImportedRecords) -> Table:
    table = plain_table("Runs")
    for column in ("run", "from s", "to s", "rows"):
        table.add_column(column, justify="left" if column == "run" else "right")
    for record in records:
        table.add_row(record.details.name, f"{record.time[0]:.3f}", f"{record.time[-1]:.3f}", f"{len(record.time):,}")
    return table
