"""One mutation of what a person gives a command, and what the command has to keep whatever it is given."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeAlias

Prepare: TypeAlias = Callable[[Path], None]

COMPLETED, REFUSED, DIVERGED = 0, 2, 3
ANY = (COMPLETED, REFUSED, DIVERGED)
"""Exit codes of a command that knows what it does; 70 is a bug, and so is whatever the shell gives a crash."""
SECONDS = 120.0
"""Wall time of one command: far more than any takes alone, as the machine may be busy; what hangs takes for ever."""
MEGABYTES = 900.0
"""Of one command; the engines take 300, a diagnosis of the small records here 500."""
_BROKEN = ("Traceback", "Warning:", "Fatal Python", "Segmentation", "Aborted", "core dumped", "terminate called")


@dataclass(frozen=True, kw_only=True)
class Case:
    """A folder with something wrong in it, and the commands that meet it, one after the other.

    Attributes:
        name: what is wrong, unique.
        prepare: fills the folder.
        commands: arguments of each; one that is refused ends the case.
        codes: exit codes that the last of them may have; those before it may complete or refuse.
        says: of which one is said by the last command, in any case of letters; nothing in particular where empty.
        seconds: that each command may take.
        megabytes: that each command may take.
        fast: whether the case is one of those that the test suite runs each time.
    """

    name: str
    prepare: Prepare
    commands: tuple[tuple[str, ...], ...]
    codes: tuple[int, ...] = (REFUSED,)
    says: tuple[str, ...] = ()
    seconds: float = SECONDS
    megabytes: float = MEGABYTES
    fast: bool = True


@dataclass(frozen=True, kw_only=True)
class Scene:
    """Something that goes on around a command, played in a folder of its own.

    Attributes:
        name: what goes on, unique.
        play: does it, and gives what went wrong.
        fast: whether the test suite plays it each time.
    """

    name: str
    play: Callable[[Path], Iterator[str]]
    fast: bool


@dataclass(frozen=True, kw_only=True)
class Ended:
    """How a command ended.

    Attributes:
        code: its exit code; None where it had to be stopped.
        output: what it printed.
        complaints: what it printed on standard error.
        seconds: that it took.
        megabytes: of memory at its most, its children's included.
        left: names in the folder that were not there before.
    """

    code: int | None
    output: str
    complaints: str
    seconds: float
    megabytes: float
    left: frozenset[str] = field(default_factory=frozenset)


def faults(case: Case, ended: list[Ended]) -> Iterator[str]:
    """Return everything that commands did which none may do."""
    for arguments, end in zip(case.commands, ended, strict=False):
        for fault in _faults_of_one(case, arguments, end):
            yield f"{case.name}: testbed {' '.join(arguments)}: {fault}"
    last = ended[-1]
    expected = case.codes if len(ended) == len(case.commands) else (*case.codes, REFUSED)
    if last.code not in expected:
        yield f"{case.name}: exit code {last.code}, not one of {expected}: {_shown(last)}"
    said = (last.output + last.complaints).lower()
    if case.says and not any(word.lower() in said for word in case.says):
        yield f"{case.name}: none of {case.says} was said, but {_shown(last)}"


def broken(text: str) -> str | None:
    """Return the first word of a text that only a crash prints."""
    return next((word for word in _BROKEN if word in text), None)


def _faults_of_one(case: Case, arguments: tuple[str, ...], end: Ended) -> Iterator[str]:
    if end.code is None:
        yield f"did not end in {case.seconds} s"
    elif end.code not in ANY:
        yield f"exit code {end.code}: {_shown(end)}"
    if broken(end.complaints + end.output):
        yield f"prints what is for programmers: {_shown(end)}"
    if end.code == REFUSED and not end.complaints.strip():
        yield "refused without a word"
    if end.megabytes > case.megabytes:
        yield f"took {end.megabytes:.0f} MB, at most {case.megabytes:.0f} are allowed"
    if stray := end.left - _may_leave(arguments, end.code):
        yield f"left {', '.join(sorted(stray))}"


def _may_leave(arguments: tuple[str, ...], code: int | None) -> set[str]:
    """Return what a command may add to its folder: what --out names, or runs/, and nothing where it refuses."""
    if code == REFUSED and "montecarlo" not in arguments:
        return set()
    return {arguments[arguments.index("--out") + 1].partition("/")[0]} if "--out" in arguments else {"runs"}


def _shown(end: Ended) -> str:
    return (end.complaints or end.output).strip()[-600:]


def written(contents: Mapping[str, str | bytes]) -> Prepare:
    """Return what fills a folder with files."""

    def prepare(folder: Path) -> None:
        for name, content in contents.items():
            path = folder / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(content.encode() if isinstance(content, str) else content)

    return prepare
