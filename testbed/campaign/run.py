"""Run a campaign: have every block flown that is not kept yet, and keep each as it comes."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import pyarrow as pa

from testbed.campaign.columns import schema_of
from testbed.campaign.executor import Executor, Notify
from testbed.campaign.kept_parts import KeptParts
from testbed.campaign.manifest import Manifest, claimed, write_manifest
from testbed.campaign.plan import CampaignPlan, blocks_of
from testbed.campaign.runs import Runs, RunsFolder, RunsInMemory
from testbed.errors import InputError
from testbed.files import FolderBusyError, only_writer

FEWEST_RUNS = 2


@dataclass(frozen=True, kw_only=True)
class Progress:
    """Callbacks that report the progress of a campaign.

    Attributes:
        kept: called with how many runs more are kept: first those of an earlier start, then each block.
        notify: called with a sentence for each worker that died and each file that was set aside.
    """

    kept: Callable[[int], None] = lambda _runs: None
    notify: Notify = lambda _text: None


SILENT = Progress()


def run_campaign(plan: CampaignPlan, folder: Path | None, executor: Executor, progress: Progress = SILENT) -> pa.Table:
    """Fly and estimate all runs of a campaign; what a folder holds already is not flown again.

    What is damaged or foreign in that folder is set aside, and flown again.

    Args:
        plan: of the campaign.
        folder: keeps the parts under runs/, and campaign.json; None keeps the runs in memory.
        executor: gets the blocks flown.
        progress: called after every block.

    Returns:
        One row per run, in their order; columns as in `schema_of`.

    Raises:
        InputError: fewer than two runs, another campaign's folder, a full disk, or workers that cannot do it; what was
            flown is kept.
    """
    if plan.runs < FEWEST_RUNS:
        raise InputError(f"a campaign of {plan.runs} runs has no scatter; ask for {FEWEST_RUNS} or more")
    schema = schema_of(plan.scenario)
    if folder is None:
        memory = RunsInMemory(schema=schema)
        _fly_missing(plan, memory, executor, progress)
        return memory.table()
    manifest = claimed(folder, plan)
    journal = _Journal(folder=folder, manifest=manifest, parts=dict(manifest.parts or {}), began=time.monotonic())
    parts = KeptParts(folder=folder / "runs", checksums=journal.parts, record=journal.write)
    parts.prepare()
    runs = RunsFolder(parts=parts, schema=schema)
    with _alone(parts.folder), _resumable(folder):
        runs.sift(blocks_of(plan), progress.notify, trusted=manifest.parts is not None)
        with journal.kept():
            _fly_missing(plan, runs, executor, progress)
    return runs.table()


def _fly_missing(plan: CampaignPlan, runs: Runs, executor: Executor, progress: Progress) -> None:
    blocks = list(blocks_of(plan))
    missing = [block for block in blocks if not runs.has(block)]
    progress.kept(plan.runs - sum(len(block.seeds) for block in missing))
    if not missing:
        return
    finished = executor.finished(plan, missing, progress.notify)
    try:
        for block in finished:
            runs.keep(block)
            progress.kept(len(block.rows))
    finally:
        finished.close()


@contextmanager
def _alone(folder: Path) -> Iterator[None]:
    """Refuse a second campaign in one folder."""
    try:
        with only_writer(folder):
            yield
    except FolderBusyError:
        raise InputError(
            f"{folder}: another campaign is writing to it; wait for it, or choose another folder"
        ) from None


@contextmanager
def _resumable(folder: Path) -> Iterator[None]:
    """Say of a campaign that cannot go on that it can later."""
    try:
        yield
    except InputError as error:
        raise InputError(f"{error}\nWhat was flown is kept in {folder}: resume it (--out {folder} --resume)") from error


@dataclass(frozen=True, kw_only=True)
class _Journal:
    """Keeps campaign.json up to date.

    Attributes:
        folder: of the campaign.
        manifest: as this start found it.
        parts: checksums of what is kept by now.
        began: when this start did, on the monotonic clock, s.
    """

    folder: Path
    manifest: Manifest
    parts: dict[str, str]
    began: float

    def write(self, *, complete: bool = False) -> None:
        """Write campaign.json with the parts that are kept now."""
        seconds = time.monotonic() - self.began
        write_manifest(self.folder, self.manifest.after(seconds, self.parts, complete=complete))

    @contextmanager
    def kept(self) -> Iterator[None]:
        """Write campaign.json at the start and the end of a block; marked complete unless the block raised an error."""
        complete = False
        self.write()
        try:
            yield
            complete = True
        finally:
            self.write(complete=complete)
