"""The progress of a campaign."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from rich.progress import BarColumn, MofNCompleteColumn, TimeElapsedColumn

from testbed.campaign.run import Progress as CampaignProgress
from testbed.cli.console import Bars, RateColumn, TimeLeftColumn, description_column


@contextmanager
def campaign_progress(runs: int) -> Iterator[CampaignProgress]:
    """Show how many runs of a campaign are kept, how fast they come and how long it will take, on standard error.

    Args:
        runs: of the campaign.
    """
    columns = (
        description_column(),
        BarColumn(),
        MofNCompleteColumn(),
        RateColumn("runs/s"),
        TimeElapsedColumn(),
        TimeLeftColumn(),
    )
    with Bars(*columns, transient=True) as progress:
        task = None

        def kept(more: int) -> None:
            nonlocal task
            if task is None:
                task = progress.add_task("Flying", total=runs, completed=more, before=more)
            else:
                progress.update(task, advance=more)

        yield CampaignProgress(kept=kept, notify=lambda text: progress.console.print(f"note: {text}"))
