"""Work of several kinds at once, in processes of this machine."""

from __future__ import annotations

import multiprocessing
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from testbed.campaign.worker import workers_environment
from testbed.errors import InputError
from testbed.reproduction.progress import Progress


@dataclass(frozen=True, kw_only=True)
class Job:
    """A call that needs nothing of any other.

    Attributes:
        part: of the reproduction that it belongs to.
        items: of that part that it does: flights, designs.
        call: a function of a module.
        arguments: of the call.
    """

    part: str
    items: int
    call: Callable[..., Any]
    arguments: tuple[Any, ...]


def done_by_crew(jobs: Sequence[Job], workers: int, progress: Progress) -> list[Any]:
    """Return what the jobs give, in their order.

    Args:
        jobs: begun in this order; long ones first keep all workers busy to the end.
        workers: processes.
        progress: told of every part, and of its jobs as they end.

    Raises:
        InputError: a worker died, or a job raised it.
    """
    totals = Counter[str]()
    for job in jobs:
        totals[job.part] += job.items
    advance = {part: progress(part, items) for part, items in totals.items()}
    with _crew(workers) as crew:
        with workers_environment():
            futures: dict[Future[Any], Job] = {crew.submit(job.call, *job.arguments): job for job in jobs}
        for future in as_completed(futures):
            _raise_failure(future)
            advance[futures[future].part](futures[future].items)
        return [future.result() for future in futures]


def _raise_failure(future: Future[Any]) -> None:
    try:
        future.result()
    except BrokenProcessPool:
        raise InputError("a worker process died: look whether memory runs out, and reproduce again") from None


@contextmanager
def _crew(workers: int) -> Iterator[ProcessPoolExecutor]:
    """Give processes that end with the block, whatever they are doing when an error or Ctrl-C ends it."""
    others = set(multiprocessing.active_children())
    context = multiprocessing.get_context(
        "spawn"
    )  # a forked process would share locks of threads that it does not have
    pool = ProcessPoolExecutor(workers, mp_context=context)
    try:
        yield pool
    finally:
        pool.shutdown(wait=False, cancel_futures=True)
        for process in set(multiprocessing.active_children()) - others:
            process.kill()
