"""Arguments that no command knows what to do with, and output folders that cannot be had."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from pathlib import Path

from support.processes import ROOT
from tests.robustness.case import ANY, COMPLETED, REFUSED, Case, written
from tests.robustness.scenario_files import TEXT

DESIGNED = ROOT / "scenarios" / "paper_d_optimal.toml"
GOOD = written({"scenario.toml": TEXT})


def cases() -> Iterator[Case]:
    """Give a case for every line and every folder."""
    for line, codes, says in _LINES:
        yield Case(
            name=f"command line: {' '.join(map(_shortened, line))}",
            prepare=GOOD,
            commands=(line,),
            codes=codes,
            says=says,
            fast="1000000000000" in line or line == ("fly",),
        )
    for name, (prepare, out, says) in _FOLDERS.items():
        for command, scenario in (("run", "scenario.toml"), ("montecarlo", "scenario.toml"), ("design", str(DESIGNED))):
            more = ("--runs", "2") if command == "montecarlo" else ()
            yield Case(
                name=f"output folder: {name} ({command})",
                prepare=_with_scenario(prepare),
                commands=((command, scenario, *more, "--out", out),),
                says=says,
                fast=command == "run" and name in {"a file", "below a file"},
            )


def _shortened(argument: str) -> str:
    return argument if len(argument) < 40 else f"{argument[:10]}... of {len(argument)}"


_LINES: tuple[tuple[tuple[str, ...], tuple[int, ...], tuple[str, ...]], ...] = (
    ((), (COMPLETED, REFUSED), ("usage",)),
    (("fly",), (REFUSED,), ("no such command",)),
    (("run",), (REFUSED,), ("missing argument",)),
    (("run", "scenario.toml", "again.toml"), (REFUSED,), ("unexpected",)),
    (("run", "--speed", "fast"), (REFUSED,), ("no such option",)),
    (("run", "scenario.toml", "--seed"), (REFUSED,), ("requires an argument",)),
    (("run", "scenario.toml", "--seed", "one"), (REFUSED,), ("valid integer",)),
    (("run", "scenario.toml", "--seed", "-1"), (REFUSED,), ("seed", "range")),
    (("run", "scenario.toml", "--seed", "1.5"), (REFUSED,), ("valid integer",)),
    (("run", "scenario.toml", "--seed", "9" * 5000), (REFUSED,), ("seed", "range", "valid")),
    (("run", "scenario.toml", "--seed", str(2**63)), (REFUSED,), ("seed", "range")),
    (("run", ""), (REFUSED,), ()),
    (("run", "x" * 5000), (REFUSED,), ("name too long", "long")),
    (("run", "[red]scenario[/].toml"), (REFUSED,), ("[red]scenario[/].toml",)),
    (("run", "no_such"), (REFUSED,), ("zero_g_campaign",)),
    (("check", "basic"), (COMPLETED,), ("a valid scenario (basic)",)),
    (("check", "basic", "--set", "seed=7"), (COMPLETED,), ("a valid scenario (basic)",)),
    (("check", "basic", "--set", "seed"), (REFUSED,), ("give key=value",)),
    (("check", "basic", "--set", "=1"), (REFUSED,), ("give key=value",)),
    (("check", "basic", "--set", "seed.of=1"), (REFUSED,), ("seed is no table",)),
    (("check", "basic", "--set", "gyro=1"), (REFUSED,), ("should be a table",)),
    (("check", "basic", "--set", "gyro.noise=1"), (REFUSED,), ("did you mean noise_rad_s",)),
    (("check", "basic", "--set", "gyro.noise_rad_s=nan"), (REFUSED,), ("finite",)),
    (("check", "basic", "--set", "seed=" + "9" * 5000), (REFUSED,), ("seed",)),
    (("check", "basic", "--set", "seed=" + "[" * 5000), (REFUSED,), ("seed",)),
    (("check", "basic", "--set", "seed=1\nname = 'other'"), (REFUSED,), ("seed",)),
    (("check", "basic", "--set", ".".join("a" * 5000) + "=1"), (REFUSED,), ("parts",)),
    (("check", "basic", "--set", "seed=\udcff\udcfe"), (REFUSED,), ("seed",)),
    (("compare", "."), (REFUSED,), ("two folders",)),
    (("compare", ".", "nowhere"), (REFUSED,), ("holds neither",)),
    (("new", "scenario", "--from", "basic"), (REFUSED,), ("exists",)),
    (("new", "a b", "--from", "basic"), (REFUSED,), ("name",)),
    (("new", "nowhere/mine", "--from", "basic"), (REFUSED,), ("cannot be written",)),
    (("new", "x" * 5000, "--from", "basic"), (REFUSED,), ("long",)),
    (("check", "nothing.toml"), (REFUSED,), ("nothing.toml",)),
    (("montecarlo", "scenario.toml"), ANY, ()),
    (("montecarlo", "scenario.toml", "--runs", "0"), (REFUSED,), ("runs", "range")),
    (("montecarlo", "scenario.toml", "--runs", "1"), (REFUSED,), ("run", "range")),
    (("montecarlo", "scenario.toml", "--runs", "-5"), (REFUSED,), ("runs", "range")),
    (("montecarlo", "scenario.toml", "--runs", "many"), (REFUSED,), ("valid integer",)),
    (("montecarlo", "scenario.toml", "--runs", "1000000000000"), (REFUSED,), ("runs", "range")),
    (("montecarlo", "scenario.toml", "--runs", "2", "--workers", "0"), (REFUSED,), ("workers", "range")),
    (("montecarlo", "scenario.toml", "--runs", "2", "--workers", "100000"), (REFUSED,), ("workers", "range")),
    (("montecarlo", "scenario.toml", "--runs", "2", "--resume"), (REFUSED,), ("--out",)),
    (("montecarlo", "scenario.toml", "--runs", "2", "--scheduler", "nowhere"), (REFUSED,), ("nowhere",)),
    (("montecarlo", "scenario.toml", "--runs", "2", "--scheduler", "tcp://127.0.0.1:1"), (REFUSED,), ("127.0.0.1:1",)),
    (("estimate", "scenario.toml"), (REFUSED,), ("--data",)),
    (("estimate", "scenario.toml", "--data", "nowhere"), (REFUSED,), ("nowhere",)),
    (("diagnose", "scenario.toml"), (REFUSED,), ("--data",)),
    (("diagnose", "scenario.toml", "--data", ""), (REFUSED,), ()),
    (("view", "nowhere"), (REFUSED,), ("nowhere",)),
    (("view", "scenario.toml"), (REFUSED,), ("not a whole recording",)),
    (("view", "scenario.toml", "--offline"), (REFUSED,), ("--web",)),
    (("score", "scenario.toml"), (REFUSED,), ()),
    (("conceal", "scenario.toml"), (REFUSED,), ()),
    (("reproduce", "--runs", "0"), (REFUSED,), ("runs", "range")),
    (("reproduce", "--seed", "-1"), (REFUSED,), ("seed", "range")),
)


def _with_scenario(prepare: Callable[[Path], object]) -> Callable[[Path], None]:
    def both(folder: Path) -> None:
        GOOD(folder)
        prepare(folder)

    return both


def _full_folder(folder: Path) -> None:
    (folder / "out").mkdir()
    (folder / "out" / "notes.txt").write_text("mine")


def _unwritable(folder: Path) -> None:
    (folder / "out").symlink_to("/proc/self")


_FOLDERS: dict[str, tuple[Callable[[Path], object], str, tuple[str, ...]]] = {
    "a file": (lambda folder: (folder / "out").write_text("mine"), "out", ("is a file",)),
    "not empty": (_full_folder, "out", ("not empty",)),
    "below a file": (lambda folder: (folder / "file").write_text("mine"), "file/out", ("file/out",)),
    "a link to itself": (lambda folder: (folder / "out").symlink_to("out"), "out", ("out",)),
    "a link to nothing": (lambda folder: (folder / "out").symlink_to("nothing/below"), "out", ("out",)),
    "where nothing can be written": (_unwritable, "out", ("out",)),
    "a device": (lambda _: None, os.devnull, (os.devnull,)),
    "a name that is too long": (lambda _: None, "o" * 300, ("o" * 300,)),
    "a name of nothing": (lambda _: None, "", ()),
}
