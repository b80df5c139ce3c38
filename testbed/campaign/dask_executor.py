"""Workers of a Dask cluster, on this machine or on others."""

from __future__ import annotations

import asyncio
import logging
import socket
from collections.abc import Generator, Hashable, Iterator, Sequence
from concurrent.futures import CancelledError
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import islice

from distributed import Client, Future, as_completed
from distributed.core import rpc
from distributed.scheduler import KilledWorker

from testbed.assembly.engine import engine_of
from testbed.campaign.executor import MOST_DEATHS, BlockRows, Notify
from testbed.campaign.manifest import deciding_versions
from testbed.campaign.plan import Block, CampaignPlan
from testbed.campaign.rows import Row, block_rows
from testbed.errors import InputError

_PATIENCE = 5.0
"""s, to find a scheduler."""
_AHEAD = 2
"""Blocks submitted for each thread of the cluster: one to fly, one to fly next."""


@dataclass(frozen=True, kw_only=True)
class DaskExecutor:
    """An executor on a Dask cluster.

    A worker that dies loses nothing: the scheduler gives its block to another, and each block is taken from the
    scheduler once.

    Attributes:
        address: of the scheduler, tcp://host:port.
    """

    address: str

    def require_workers(self) -> None:
        """Refuse a cluster that cannot fly, before any work is done for it.

        Raises:
            InputError: no scheduler answers, or it has no workers.
        """
        try:
            workers = asyncio.run(_workers_of(self.address))
        except (OSError, ValueError, TimeoutError, TypeError, KeyError, MemoryError) as error:  # also: no Dask
            raise InputError(
                f"{self.address}: no Dask scheduler answers there; give the address (--scheduler) that "
                "`dask scheduler` prints, such as tcp://127.0.0.1:8786"
            ) from error
        if not workers:
            raise InputError(
                f"{self.address}: the scheduler has no workers; start some with "
                f"`dask worker {self.address} --nthreads 1`"
            )

    def finished(self, plan: CampaignPlan, blocks: Sequence[Block], notify: Notify) -> Generator[BlockRows]:  # noqa: ARG002 - the scheduler replaces workers silently
        """Fly blocks; as in `Executor`."""
        self.require_workers()
        with _connected(self.address) as client:
            waiting, flying = iter(blocks), as_completed(loop=client.loop)
            given: dict[Hashable, Block] = {}
            _submit(client, plan, islice(waiting, _window(client)), flying, given)
            for future in flying:
                block = given.pop(future.key)
                rows = self._rows_of(future, block)
                future.release()
                _submit(client, plan, islice(waiting, max(_window(client) - len(given), 1)), flying, given)
                yield BlockRows(block=block, rows=rows)

    def _rows_of(self, future: Future[list[Row]], block: Block) -> list[Row]:
        try:
            rows: list[Row] = future.result()
        except KilledWorker as error:
            runs = f"runs {block.first} to {block.first + len(block.seeds) - 1}"
            raise InputError(
                f"{self.address}: {MOST_DEATHS} workers died on {runs}; look at their logs, and whether their memory "
                "runs out"
            ) from error
        except ImportError as error:
            raise InputError(
                f"{self.address}: its workers cannot fly ({error}); install the same testbed where they run"
            ) from error
        except (CancelledError, OSError) as error:
            raise InputError(f"{self.address}: the connection to the scheduler was lost") from error
        return rows


def _submit(
    client: Client, plan: CampaignPlan, blocks: Iterator[Block], flying: as_completed, given: dict[Hashable, Block]
) -> None:
    versions = deciding_versions(engine_of(plan.scenario, many=True))
    for block in blocks:
        # Sent with each block: a plan kept on a worker would be lost with it.
        future = client.submit(_flown, plan, block, versions, pure=False)
        given[future.key] = block
        flying.add(future)


def _flown(plan: CampaignPlan, block: Block, versions: dict[str, str]) -> list[Row]:
    """Fly a block on a worker; one with other versions would give other numbers.

    Raises:
        InputError: this worker's versions differ.
    """
    here = deciding_versions(engine_of(plan.scenario, many=True))
    if here != versions:
        differing = [name for name in versions if here[name] != versions[name]]
        other = ", ".join(f"{name} {here[name]} instead of {versions[name]}" for name in differing)
        raise InputError(f"the worker on {socket.gethostname()} has {other}; install the same versions")
    return block_rows(plan, block)


def _window(client: Client) -> int:
    """Return how many blocks are to be with the cluster; workers may have come and gone."""
    threads: int = sum(client.ncores().values())
    return max(_AHEAD * threads, 1)


@contextmanager
def _connected(address: str) -> Iterator[Client]:
    for part in ("client", "core"):
        logging.getLogger(f"distributed.{part}").setLevel(logging.CRITICAL)  # what goes wrong is said in the message
    with Client(address, timeout=_PATIENCE, set_as_default=False) as client:
        yield client


async def _workers_of(address: str) -> int:
    """Ask a scheduler how many workers it has."""
    async with rpc(address, timeout=_PATIENCE) as scheduler:
        identity = await asyncio.wait_for(scheduler.identity(), _PATIENCE)
    return len(identity["workers"])
