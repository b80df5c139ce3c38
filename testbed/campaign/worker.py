"""A worker process on this machine: it flies blocks of runs and returns their rows until no block remains."""

from __future__ import annotations

import os
import signal
import traceback
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from multiprocessing import get_context, resource_tracker
from multiprocessing.connection import Connection

from testbed.campaign.plan import Block, CampaignPlan
from testbed.campaign.rows import Row, block_rows
from testbed.interrupts import deferred_interrupts

_CONTEXT = get_context("spawn")  # a forked process would share locks of threads that it does not have
_BLAS_THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


class WorkerDied(Exception):  # noqa: N818 - an event to react to, not a fault of the caller
    """The process ended without an answer; the text says how."""


class Worker:
    """A process, and the block that it has."""

    def __init__(self, plan: CampaignPlan, threads: int) -> None:
        """Start the process.

        Args:
            plan: of the campaign.
            threads: that step the platforms of a block.
        """
        self.connection, remote = _CONTEXT.Pipe()
        self._process = _CONTEXT.Process(target=_serve, args=(remote, plan, threads), daemon=True)
        with workers_environment():
            self._process.start()
        remote.close()  # so that the death of the process ends the connection
        self.block: Block | None = None

    def give(self, block: Block) -> None:
        """Hand over a block to fly; a dead process is noticed by `answer`."""
        self.block = block
        with suppress(BrokenPipeError):
            self.connection.send(block)

    def answer(self) -> list[Row]:
        """Return the rows of the block that was given.

        Raises:
            WorkerDied: the process is no more.
            Exception: whatever flying the block raised.
        """
        try:
            answer = self.connection.recv()
        except (EOFError, OSError):
            self._process.join()
            raise WorkerDied(_end_of(self._process.exitcode)) from None
        if isinstance(answer, Exception):
            raise answer
        rows: list[Row] = answer
        return rows

    def end(self) -> None:
        """End the process, whatever it is doing."""
        self._process.kill()
        self._process.join()
        self.connection.close()


def _serve(connection: Connection, plan: CampaignPlan, threads: int) -> None:
    """Fly blocks until the other side is gone."""
    with suppress(EOFError, BrokenPipeError):
        while True:
            block = connection.recv()
            try:
                answer: list[Row] | Exception = block_rows(plan, block, threads)
            except Exception as error:
                error.add_note(f"In the worker:\n{traceback.format_exc()}")  # which does not go through a pipe
                answer = error
            connection.send(answer)


@contextmanager
def workers_environment() -> Iterator[None]:
    """Let processes started here inherit one BLAS thread each, and leave Ctrl-C to their parent.

    Ctrl-C waits until they have started: one whose parent breaks off in the middle of it complains.
    """
    resource_tracker.ensure_running()  # with the first process, it would take the block of signals off again
    before = {name: os.environ.get(name) for name in _BLAS_THREADS}
    os.environ.update(dict.fromkeys(_BLAS_THREADS, "1"))
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        with deferred_interrupts():
            yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, mask)
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


def _end_of(exit_code: int | None) -> str:
    if exit_code is not None and exit_code < 0:
        return f"killed by {signal.Signals(-exit_code).name}"
    return f"ended with exit code {exit_code}"
