"""Where a campaign's runs are kept as they come: a folder of Parquet parts, one per block, or memory."""

from __future__ import annotations

import io
from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol

import pyarrow as pa
import pyarrow.parquet as pq

from testbed.campaign.executor import BlockRows
from testbed.campaign.plan import Block
from testbed.errors import InputError
from testbed.files import whole_file


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
    """Runs that nobody wants to keep.

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
        folder: of the parts; nothing else is in it.
        schema: of all parts.
    """

    folder: Path
    schema: pa.Schema

    def prepare(self) -> None:
        """Make the folder.

        Raises:
            InputError: it cannot be made.
        """
        try:
            self.folder.mkdir(exist_ok=True)
        except OSError as error:
            raise self._unwritable(error) from error

    def has(self, block: Block) -> bool:
        """Return whether a block's part is there and whole; one that is damaged does not count."""
        path = self._part(block.index)
        try:
            part = pq.read_table(path, columns=["seed"], partitioning=None)
            columns = pq.read_schema(path)
        except (OSError, pa.ArrowException):
            return False
        return bool(columns.equals(self.schema)) and part["seed"].to_pylist() == list(block.seeds)

    def keep(self, finished: BlockRows) -> None:
        """Write a block's part, whole or not at all.

        Raises:
            InputError: it cannot be written.
        """
        content = io.BytesIO()
        pq.write_table(pa.Table.from_pylist(finished.rows, self.schema), content)
        try:
            with whole_file(self._part(finished.block.index)) as part:
                part.write_bytes(content.getbuffer())
        except OSError as error:
            raise self._unwritable(error) from error

    def table(self) -> pa.Table:
        """Read all runs, in their order."""
        paths = sorted(self.folder.glob("part-*.parquet"))
        tables = [pq.read_table(path, schema=self.schema, partitioning=None) for path in paths]
        return pa.concat_tables(tables).sort_by("run") if tables else self.schema.empty_table()

    def _unwritable(self, error: OSError) -> InputError:
        return InputError(f"{self.folder}: cannot be written ({error.strerror}); make room there, nothing is lost")

    def _part(self, index: int) -> Path:
        return self.folder / f"part-{index:05d}.parquet"
