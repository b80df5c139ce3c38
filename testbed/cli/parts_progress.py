"""The progress of work in parts: a bar for each part, with its rate and the time left."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    TaskID,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)

from testbed.cli.console import RATE_PERIOD, Bars, RateColumn, description_column
from testbed.reproduction.progress import Advance, Progress


@contextmanager
def parts_progress() -> Iterator[Progress]:
    """Show a bar for each part of the reproduction once it begins, on standard error."""
    columns = (
        description_column(),
        BarColumn(),
        MofNCompleteColumn(),
        RateColumn("/s"),
        TimeElapsedColumn(),
        TimeRemainingColumn(),
        TextColumn("left"),
    )
    with Bars(*columns, speed_estimate_period=RATE_PERIOD) as bars:

        def begin(part: str, items: int) -> Advance:
            task: TaskID = bars.add_task(part, total=items)
            return lambda done: bars.update(task, advance=done)

        yield begin
