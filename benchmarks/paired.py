"""Two things timed in turn, so that what else the machine does falls on both."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from subprocess import PIPE, Popen

Action = Callable[[], float]
"""Does its work and says how long it took, s."""


@dataclass(frozen=True, kw_only=True)
class PairedTimes:
    """Medians of two actions timed in turn.

    Attributes:
        ours: s.
        theirs: s.
        ratio: median of theirs over ours, pair by pair.
    """

    ours: float
    theirs: float
    ratio: float


def paired(ours: Action, theirs: Action, pairs: int) -> PairedTimes:
    """Time ours, theirs, ours, theirs, ... after one round that does not count."""
    ours(), theirs()
    times = [(ours(), theirs()) for _ in range(pairs)]
    return PairedTimes(
        ours=statistics.median(first for first, _ in times),
        theirs=statistics.median(second for _, second in times),
        ratio=statistics.median(second / first for first, second in times),
    )


def seconds(action: Callable[[], object]) -> float:
    """Return how long an action takes, s."""
    began = time.perf_counter()
    action()
    return time.perf_counter() - began


def processor_seconds(action: Callable[[], object]) -> float:
    """Return the processor time that an action takes, s."""
    began = time.process_time()
    action()
    return time.process_time() - began


@contextmanager
def workers(commands: list[list[str]]) -> Iterator[Action]:
    """Keep processes at hand that do their work together; yields the action that sets them all to work once.

    A process imports what it needs, prints "ready", and then prints "done" for every line that it reads. What it costs
    to start it is not timed.
    """
    members = [Popen(command, stdin=PIPE, stdout=PIPE, text=True) for command in commands]
    try:
        _await(members, "ready")
        yield lambda: seconds(lambda: _work(members))
    finally:
        for member in members:
            member.communicate()


def _work(members: list[Popen[str]]) -> None:
    for member in members:
        assert member.stdin is not None
        member.stdin.write("go\n")
        member.stdin.flush()
    _await(members, "done")


def _await(members: list[Popen[str]], word: str) -> None:
    for member in members:
        assert member.stdout is not None
        line = member.stdout.readline().strip()
        if line != word:
            raise RuntimeError(f"{' '.join(member.args)}: said {line!r} instead of {word!r}")  # type: ignore[arg-type]
