"""Where a campaign's runs are kept as they come: a folder of Parquet parts, one per block, or memory."""

from __future__ import annotations

import io
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Protocol

import pyarrow as pa
import pyarrow.parquet as pq

from testbed.campaign.executor import BlockRows, Notify
from testbed.campaign.kept_parts import KeptParts, sha256_of
from testbed.campaign.plan import Block


class Runs(Protocol):
    """Keeps finished blocks."""

    def has(self, block: Block) -> bool:
        """Return whether a block is kept, whole."""
        ...

    def keep(self, finished: BlockRows) -> None:
        """Keep a block; one that is kept already is replaced."""
        ...

    def table(self) -> pa.Table:
        """Return all runs that are kept, in their order."""
        ...


@dataclass(frozen=True, kw_only=True)
class RunsInMemory:
    """Runs that are held in memory and not written.

    Attributes:
        schema: their columns.
        parts: the blocks as tables, by index.
    """

    schema: pa.Schema
    parts: dict[int, pa.Table] = field(default_factory=dict)

    def has(self, block: Block) -> bool:
        """Return whether a block is kept."""
        return block.index in self.parts

    def keep(self, finished: BlockRows) -> None:
        """Keep a block."""
        self.parts[finished.block.index] = pa.Table.from_pylist(finished.rows, self.schema)

    def table(self) -> pa.Table:
        """Return all runs in their order."""
        tables = [self.parts[index] for index in sorted(self.parts)]
        return pa.concat_tables(tables) if tables else self.schema.empty_table()


@dataclass(frozen=True, kw_only=True)
class RunsFolder:
    """A Parquet data set that grows by a part with each block.

    Attributes:
        parts: the files, one per block.
        schema: of all parts.
    """

    parts: KeptParts
    schema: pa.Schema

    def sift(self, blocks: Iterable[Block], notify: Notify, *, trusted: bool) -> None:
        """Move files aside that are damaged or no part of the campaign, and report each.

        Args:
            blocks: of the campaign.
            notify: called with a sentence for each file that is set aside.
            trusted: whether parts have checksums; those of a campaign begun before there were any are read instead.

        Raises:
            InputError: the folder cannot be written.
        """
        by_name = {part_name(block.index): block for block in blocks}
        for name in self.parts.names():
            fault = self._fault(name, by_name.get(name), trusted=trusted)
            if fault is not None:
                flown_again = "; its runs are flown again" if name in by_name else ""
                notify(f"{self.parts.folder / name} {fault}; moved to {self.parts.set_aside(name)}{flown_again}")

    def has(self, block: Block) -> bool:
        """Return whether a block's part is there with all its runs; a block that has grown since is not."""
        content = self.parts.content(part_name(block.index))
        return content is not None and self._seeds(content) == list(block.seeds)

    def keep(self, finished: BlockRows) -> None:
        """Write a block's part, whole or not at all.

        Raises:
            InputError: it cannot be written.
        """
        content = io.BytesIO()
        pq.write_table(pa.Table.from_pylist(finished.rows, self.schema), content)
        self.parts.write(part_name(finished.block.index), content.getvalue())

    def table(self) -> pa.Table:
        """Read all runs, in their order."""
        paths = (self.parts.folder / name for name in sorted(self.parts.checksums))
        tables = [pq.read_table(path, schema=self.schema, partitioning=None) for path in paths]
        return pa.concat_tables(tables).sort_by("run") if tables else self.schema.empty_table()

    def _fault(self, name: str, block: Block | None, *, trusted: bool) -> str | None:
        if block is None:
            return "is none of this campaign's parts"
        if trusted:
            return self.parts.fault(name)
        content = self.parts.content(name)
        seeds = None if content is None else self._seeds(content)
        if content is None or not seeds or seeds != list(block.seeds[: len(seeds)]):
            return "is damaged, or another campaign's"
        self.parts.checksums[name] = sha256_of(content)
        return None

    def _seeds(self, content: bytes) -> list[int] | None:
        """Return the seeds of a part, all of which is read; None where it is not a part."""
        try:
            table = pq.read_table(io.BytesIO(content), partitioning=None)
        except (OSError, pa.ArrowException):
            return None
        return list(table["seed"].to_pylist()) if table.schema.equals(self.schema) else None


def part_name(index: int) -> str:
    """Return the name of a block's part."""
    return f"part-{index:05d}.parquet"
