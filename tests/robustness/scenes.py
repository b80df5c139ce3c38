"""What happens around a command: signals, other commands at the same time, and machines that lack something."""

from __future__ import annotations

import os
import resource
import shutil
import signal
import subprocess
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path

from support.campaigns import small_scenario
from support.processes import ROOT, WAITING, of_group, outcome, started, until
from tests.robustness.case import COMPLETED, REFUSED, Scene, broken, written
from tests.robustness.records import good_records
from tests.robustness.scenario_files import TEXT

INTERRUPTED = 130
BASIC = ROOT / "scenarios" / "basic.toml"
DIAGNOSED = ROOT / "scenarios" / "diagnose.toml"
DESIGNED = ROOT / "scenarios" / "paper_d_optimal.toml"
_WORK: dict[str, tuple[str, tuple[object, ...]]] = {
    "check": ("true_platform", (BASIC,)),
    "run": ("fly", (BASIC, "--out", "out")),
    "design": ("design", (DESIGNED, "--out", "out")),
    "estimate": ("read_records", (DIAGNOSED, "--data", "data", "--out", "out")),
    "diagnose": ("read_records", (DIAGNOSED, "--data", "data", "--out", "out")),
    "montecarlo": ("flown_into", (BASIC, "--runs", 2, "--out", "out")),
    "reproduce": ("reproduce", ("--quick", "--out", "out")),
}
"""Where each command can be made to wait, and its arguments."""


def cases() -> Iterator[Scene]:
    """Give every scene."""
    yield from _signals()
    yield from _kills()
    yield from _races()
    yield from _machines()


def _ended(process: subprocess.Popen[str], codes: tuple[int, ...]) -> Iterator[str]:
    """Say what a command printed or returned that none may."""
    code, output, complaints = outcome(process)
    if code not in codes:
        yield f"exit code {code}, not one of {codes}: {(complaints or output or '')[-600:]}"
    if word := broken((output or "") + (complaints or "")):
        yield f"prints {word}: {(complaints or output)[-600:]}"


def _left(folder: Path, allowed: set[str]) -> Iterator[str]:
    if stray := {path.name for path in folder.iterdir()} - allowed:
        yield f"left {', '.join(sorted(stray))}"
    if parts := list(folder.rglob(".part*")):
        yield f"left {', '.join(map(str, parts))}"


def _signals() -> Iterator[Scene]:
    for command, (work, arguments) in _WORK.items():
        for sent in (signal.SIGINT, signal.SIGTERM):
            for ignored in (False, True):

                def play(
                    folder: Path,
                    command: str = command,
                    work: str = work,
                    arguments: tuple[object, ...] = arguments,
                    sent: signal.Signals = sent,
                    ignored: bool = ignored,
                ) -> Iterator[str]:
                    waiting = WAITING.format(command=command, work=work)
                    with started(command, *arguments, cwd=folder, before=waiting, signals_ignored=ignored) as process:
                        until((folder / "here").exists, process)
                        process.send_signal(sent)
                        yield from _ended(process, (INTERRUPTED,))
                        if of_group(process.pid):
                            yield "left processes behind"
                    # A campaign and a reproduction keep what they have and say how to go on with it.
                    kept = {"out"} if command in {"montecarlo", "reproduce"} else set()
                    yield from _left(folder, {"here", *kept})

                inherited = "ignored" if ignored else "heard"
                yield Scene(
                    name=f"signal: {sent.name}, {inherited} before, in {command}",
                    play=play,
                    fast=command == "design" and sent == signal.SIGINT,
                )


def _kills() -> Iterator[Scene]:
    """A command that was killed is no obstacle for the next one of the same name."""
    for command in ("run", "estimate"):
        for at in ("work", "writing"):

            def play(folder: Path, command: str = command, at: str = at) -> Iterator[str]:
                good_records(folder / "data")
                work, arguments = _WORK[command]
                before = WAITING.format(command=command, work=work) if at == "work" else _KILLED_WHILE_WRITING
                with started(command, *arguments, cwd=folder, before=before) as process:
                    if at == "work":
                        until((folder / "here").exists, process)
                        process.kill()
                    process.wait()
                with started(command, *arguments, cwd=folder) as process:
                    yield from _ended(process, (COMPLETED,))
                yield from _left(folder, {"here", "data", "out"})

            yield Scene(name=f"signal: KILL while at {at} in {command}", play=play, fast=False)


_KILLED_WHILE_WRITING = """
import os, signal
import testbed.outputs.folder as folder
def killed(*_, **__):
    os.kill(os.getpid(), signal.SIGKILL)
folder.deferred_interrupts = killed
"""


def _races() -> Iterator[Scene]:
    def several(count: int, out: tuple[str, ...], winners: int) -> Callable[[Path], Iterator[str]]:
        def play(folder: Path) -> Iterator[str]:
            with ExitStack() as stack:
                processes = [
                    stack.enter_context(started("run", BASIC, "--seed", seed, *out, cwd=folder))
                    for seed in range(count)
                ]
                ends = [outcome(process) for process in processes]
            codes = sorted(code for code, _, _ in ends)
            if codes != [COMPLETED] * winners + [REFUSED] * (count - winners):
                yield f"exit codes {codes}: {ends}"
            results = list(folder.rglob("result.json"))
            if len(results) != winners:
                yield f"{len(results)} results of {winners}: {results}"

        return play

    def changed(change: Callable[[Path], object]) -> Callable[[Path], Iterator[str]]:
        def play(folder: Path) -> Iterator[str]:
            written({"scenario.toml": TEXT})(folder)
            at_work = (
                "import pathlib, time\nimport testbed.cli.run as command\nfly = command.fly\n"
                "def waiting(*arguments, **options):\n"
                "    pathlib.Path('here').touch()\n"
                "    while not pathlib.Path('go').exists(): time.sleep(0.02)\n"
                "    return fly(*arguments, **options)\n"
                "command.fly = waiting\n"
            )
            with started("run", "scenario.toml", "--out", "out", cwd=folder, before=at_work) as process:
                until((folder / "here").exists, process)
                change(folder)
                (folder / "go").touch()
                yield from _ended(process, (COMPLETED,))
            if (folder / "out" / "scenario.toml").read_text(encoding="utf-8") != TEXT:
                yield "what was stored is not what was flown"

        return play

    def two_campaigns(folder: Path) -> Iterator[str]:
        scenario = small_scenario(folder)
        arguments = ("montecarlo", scenario, "--runs", 4, "--workers", 1, "--out", "out")
        with started(*arguments, cwd=folder) as one, started(*arguments, cwd=folder) as other:
            codes = sorted(outcome(process)[0] for process in (one, other))
        if codes != [COMPLETED, REFUSED]:
            yield f"exit codes {codes}"

    def folder_vanishes(folder: Path) -> Iterator[str]:
        vanishing = (
            "import shutil\nimport testbed.cli.run as command\nfly = command.fly\n"
            "def vanishing(*arguments, **options):\n"
            "    shutil.rmtree('out')\n"
            "    return fly(*arguments, **options)\n"
            "command.fly = vanishing\n"
        )
        environment = {"TMPDIR": str(folder)}
        with started("run", BASIC, "--out", "out", cwd=folder, before=vanishing, environment=environment) as process:
            yield from _ended(process, (REFUSED,))
        if len(list(folder.rglob("result.json"))) != 1:
            yield "the result was kept nowhere"

    scenes = {
        "three runs without --out": (several(3, (), 3), True),
        "three runs with one --out": (several(3, ("--out", "out"), 1), True),
        "six runs without --out": (several(6, (), 6), False),
        "scenario edited": (changed(lambda folder: (folder / "scenario.toml").write_text("schema = 2")), False),
        "scenario deleted": (changed(lambda folder: (folder / "scenario.toml").unlink()), True),
        "scenario becomes a folder": (
            changed(lambda folder: ((folder / "scenario.toml").unlink(), (folder / "scenario.toml").mkdir())),
            False,
        ),
        "two campaigns in one folder": (two_campaigns, False),
        "the output folder is removed": (folder_vanishes, False),
    }
    for name, (play, fast) in scenes.items():
        yield Scene(name=f"race: {name}", play=play, fast=fast)


def _machines() -> Iterator[Scene]:
    """Terminals, environments and limits, for a command that only reads and one that writes."""

    def limited(what: int, limit: int) -> str:
        return f"import resource; resource.setrlimit({what}, ({limit}, {limit}))"

    lacks: dict[str, tuple[dict[str, str], str, tuple[int, ...]]] = {
        **{f"{width} columns": ({"COLUMNS": str(width)}, "", (COMPLETED,)) for width in (1, 20, 60, 1000)},
        "columns of text": ({"COLUMNS": "wide"}, "", (COMPLETED,)),
        "a dumb terminal": ({"TERM": "dumb"}, "", (COMPLETED,)),
        "colours forced": ({"FORCE_COLOR": "1"}, "", (COMPLETED,)),
        "no colours": ({"NO_COLOR": "1"}, "", (COMPLETED,)),
        "ASCII alone": ({"PYTHONIOENCODING": "ascii"}, "", (COMPLETED,)),
        "the C locale": ({"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}, "", (COMPLETED,)),
        "an unknown locale": ({"LC_ALL": "xx_YY.UTF-9"}, "", (COMPLETED,)),
        "no home": ({"HOME": "/nonexistent"}, "", (COMPLETED,)),
        "no temporary folder": ({"TMPDIR": "/nonexistent"}, "", (COMPLETED,)),
        "an unknown time zone": ({"TZ": "Moon/Crater"}, "", (COMPLETED,)),
        "files of 100 kB at most": ({}, limited(resource.RLIMIT_FSIZE, 100_000), (COMPLETED, REFUSED)),
        "no new files": ({}, limited(resource.RLIMIT_FSIZE, 0), (COMPLETED, REFUSED)),
        "standard output closed": ({}, "import os, sys; os.close(1); sys.stdout = None", (COMPLETED,)),
        "standard error closed": ({}, "import os, sys; os.close(2); sys.stderr = None", (COMPLETED,)),
        "standard input closed": ({}, "import os, sys; os.close(0); sys.stdin = None", (COMPLETED,)),
        "warnings on": ({"PYTHONWARNINGS": "default"}, "", (COMPLETED,)),
        "optimised Python": ({"PYTHONOPTIMIZE": "2"}, "", (COMPLETED,)),
    }
    for name, (environment, before, codes) in lacks.items():
        for command, arguments in (("check", (BASIC,)), ("run", (BASIC, "--out", "out"))):

            def play(
                folder: Path,
                command: str = command,
                arguments: tuple[object, ...] = arguments,
                environment: dict[str, str] = environment,
                before: str = before,
                codes: tuple[int, ...] = codes,
            ) -> Iterator[str]:
                with started(command, *arguments, cwd=folder, before=before, environment=environment) as process:
                    yield from _ended(process, codes)
                yield from _left(folder, {"out"} if command == "run" else set())

            yield Scene(name=f"machine: {name} ({command})", play=play, fast=False)
    for device, codes in (("/dev/full", (REFUSED,)), (os.devnull, (COMPLETED,))):
        for command, arguments in (("check", (BASIC,)), ("run", (BASIC, "--out", "out"))):

            def written_to(
                folder: Path,
                device: str = device,
                command: str = command,
                arguments: tuple[object, ...] = arguments,
                codes: tuple[int, ...] = codes,
            ) -> Iterator[str]:
                with (
                    Path(device).open("w") as lost,
                    started(command, *arguments, cwd=folder, stdout=lost) as process,
                ):
                    yield from _ended(process, codes)
                if command == "run" and not (folder / "out" / "result.json").is_file():
                    yield "the result was lost with the output"

            yield Scene(name=f"machine: output to {device} ({command})", play=written_to, fast=False)
    yield Scene(name="machine: the working folder was removed", play=_removed, fast=False)


def _removed(folder: Path) -> Iterator[str]:
    gone = folder / "gone"
    gone.mkdir()
    leaving = f"import shutil; shutil.rmtree({str(gone)!r})"
    with started("run", BASIC, cwd=gone, before=leaving) as process:
        yield from _ended(process, (REFUSED,))
    shutil.rmtree(gone, ignore_errors=True)
