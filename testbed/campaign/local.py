"""Worker processes on this machine."""

from __future__ import annotations

import os
from collections import Counter, deque
from collections.abc import Generator, Iterator, Sequence
from dataclasses import dataclass, field
from multiprocessing.connection import wait

from testbed.campaign.executor import MOST_DEATHS, BlockRows, Notify
from testbed.campaign.plan import Block, CampaignPlan
from testbed.campaign.worker import Worker, WorkerDied
from testbed.errors import InputError
from testbed.interrupts import HEARING


def usable_cores() -> int:
    """Return how many cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@dataclass(frozen=True, kw_only=True)
class LocalExecutor:
    """An executor on this machine's cores.

    Attributes:
        workers: cores to use, a process each; with fewer blocks than that, processes use several threads.
    """

    workers: int = field(default_factory=usable_cores)

    def finished(self, plan: CampaignPlan, blocks: Sequence[Block], notify: Notify) -> Generator[BlockRows]:
        """Fly blocks; as in `Executor`. A block whose worker dies is given to a new one."""
        processes = min(self.workers, len(blocks))
        pool = _Pool(plan=plan, threads=self.workers // max(processes, 1), waiting=deque(blocks), notify=notify)
        try:
            for _ in range(processes):
                pool.hire()
            while pool.workers:
                yield from pool.next_answers()
        finally:
            pool.end()


@dataclass(kw_only=True)
class _Pool:
    """The workers, what they have and the remaining blocks.

    Attributes:
        plan: of the campaign.
        threads: of each worker.
        waiting: blocks that nobody has.
        notify: called with a sentence for each worker that died.
        workers: that have a block, by connection.
        deaths: of workers, by the index of the block that they had.
    """

    plan: CampaignPlan
    threads: int
    waiting: deque[Block]
    notify: Notify
    workers: list[Worker] = field(default_factory=list)
    deaths: Counter[int] = field(default_factory=Counter)

    def hire(self) -> None:
        """Start a worker on the next block."""
        worker = Worker(self.plan, self.threads)
        self.workers.append(worker)
        worker.give(self.waiting.popleft())

    def next_answers(self) -> Iterator[BlockRows]:
        """Wait a little for workers; give those that answered their next block, and replace those that died."""
        ready = wait([worker.connection for worker in self.workers], HEARING)
        for worker in [worker for worker in self.workers if worker.connection in ready]:
            block = worker.block
            assert block is not None
            try:
                rows = worker.answer()
            except WorkerDied as death:
                self._replace(worker, block, str(death))
                continue
            self._go_on(worker)
            yield BlockRows(block=block, rows=rows)

    def end(self) -> None:
        """End all workers, whatever they are doing."""
        for worker in self.workers:
            worker.end()

    def _go_on(self, worker: Worker) -> None:
        if self.waiting:
            worker.give(self.waiting.popleft())
        else:
            self._dismiss(worker)

    def _dismiss(self, worker: Worker) -> None:
        self.workers.remove(worker)
        worker.end()

    def _replace(self, worker: Worker, block: Block, how: str) -> None:
        self._dismiss(worker)
        self.deaths[block.index] += 1
        runs = f"runs {block.first} to {block.first + len(block.seeds) - 1}"
        if self.deaths[block.index] >= MOST_DEATHS:
            raise InputError(
                f"{MOST_DEATHS} worker processes in a row died on {runs} (the last was {how}): look whether memory "
                "runs out, or fly one of these runs alone; in a script of your own, start campaigns below "
                'if __name__ == "__main__":, as each worker imports it'
            )
        self.notify(f"a worker process was {how} on {runs}; they are flown again")
        self.waiting.appendleft(block)
        self.hire()
