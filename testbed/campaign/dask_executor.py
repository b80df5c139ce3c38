"""Workers of a Dask cluster, on this machine or on others."""

from __future__ import annotations

import logging
import socket
from collections.abc import Generator, Hashable, Iterator, Sequence
from concurrent.futures import CancelledError
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import islice

from distributed import Client, Future, as_completed
from distributed.scheduler import KilledWorker

from testbed.campaign.executor import MOST_DEATHS, BlockRows, Notify
from testbed.campaign.manifest import deciding_versions
from testbed.campaign.plan import Block, CampaignPlan
from testbed.campaign.rows import Row, block_rows
from testbed.errors import InputError

_PATIENCE = 8.0
"""s, to find a scheduler, and again to find a worker."""
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

    def finished(self, plan: CampaignPlan, blocks: Sequence[Block], notify: Notify) -> Generator[BlockRows]:  # noqa: ARG002 - the scheduler replaces workers silently
        """Fly blocks; as in `Executor`."""
        with _connected(self.address) as client:
            waiting, flying = iter(blocks), as_completed()
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
            return future.result()
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


def _submit(
    client: Client, plan: CampaignPlan, blocks: Iterator[Block], flying: as_completed, given: dict[Hashable, Block]
) -> None:
    for block in blocks:
        # Sent with each block: a plan kept on a worker would be lost with it.
        future = client.submit(_flown, plan, block, deciding_versions(), pure=False)
        given[future.key] = block
        flying.add(future)


def _flown(plan: CampaignPlan, block: Block, versions: dict[str, str]) -> list[Row]:
    """Fly a block on a worker; one with other versions would give other numbers.

    Raises:
        InputError: this worker's versions differ.
    """
    here = deciding_versions()
    if here != versions:
        other = ", ".join(f"{name} {here[name]} instead of {versions[name]}" for name in here if here != versions)
        raise InputError(f"the worker on {socket.gethostname()} has {other}; install the same versions")
    return block_rows(plan, block)


def _window(client: Client) -> int:
    """Return how many blocks are to be with the cluster; workers may have come and gone."""
    return max(_AHEAD * sum(client.ncores().values()), 1)


@contextmanager
def _connected(address: str) -> Iterator[Client]:
    """Connect to a scheduler that has workers.

    Raises:
        InputError: there is no scheduler, or it has no workers.
    """
    logging.getLogger("distributed").setLevel(logging.CRITICAL)  # what goes wrong is said in the message
    try:
        client = Client(address, timeout=_PATIENCE, set_as_default=False)
    except (OSError, ValueError) as error:
        raise InputError(f"{address}: no Dask scheduler answers there; start one with `dask scheduler`") from error
    with client:
        try:
            client.wait_for_workers(1, timeout=_PATIENCE)
        except TimeoutError as error:
            raise InputError(
                f"{address}: the scheduler has no workers; start one with `dask worker {address} --nthreads 1`"
            ) from error
        yield client
