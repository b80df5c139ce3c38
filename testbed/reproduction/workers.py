"""Work of several kinds side by side, in processes of this machine."""

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
from testbed.reproduction.parts import NOWHERE, Parts
from testbed.reproduction.progress import Progress


@dataclass(frozen=True, kw_only=True)
class Job:
    """A call that needs nothing of any other.

    Attributes:
        name: under which its result is kept; None where that is not worth it.
        part: of the reproduction that it belongs to.
        items: of that part that it does: flights, designs.
        call: a function of a module.
        arguments: of the call.
    """

    name: str | None
    part: str
    items: int
    call: Callable[..., Any]
    arguments: tuple[Any, ...]


def done_by_workers(jobs: Sequence[Job], workers: int, progress: Progress, parts: Parts = NOWHERE) -> list[Any]:
    """Return what the jobs give, in their order; what is kept is not done again.

    Args:
        jobs: begun in this order; long ones first keep all workers busy to the end.
        workers: processes.
        progress: called with every part, and of its jobs as they end.
        parts: that are finished; each job's result is added as it ends.

    Raises:
        InputError: a worker died, or a job raised it.
    """
    totals = Counter[str]()
    for job in jobs:
        totals[job.part] += job.items
    advance = {part: progress(part, items) for part, items in totals.items()}
    results = [None if job.name is None else parts.result(job.name) for job in jobs]
    missing = [index for index, result in enumerate(results) if result is None]
    for index in set(range(len(jobs))).difference(missing):
        advance[jobs[index].part](jobs[index].items)
    if not missing:
        return results
    with _pool(workers) as pool:
        with workers_environment():
            futures = {pool.submit(jobs[index].call, *jobs[index].arguments): index for index in missing}
        for future in as_completed(futures):
            job, result = jobs[futures[future]], _result(future)
            results[futures[future]] = result
            if job.name is not None:
                parts.keep(job.name, result)
            advance[job.part](job.items)
    return results


def _result(future: Future[Any]) -> Any:  # noqa: ANN401 - whatever the job gives
    try:
        return future.result()
    except BrokenProcessPool:
        raise InputError("a worker process died: look whether memory runs out, and reproduce again") from None


@contextmanager
def _pool(workers: int) -> Iterator[ProcessPoolExecutor]:
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
