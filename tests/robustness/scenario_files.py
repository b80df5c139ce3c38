"""Scenario files that are no scenario, or not quite."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from support.processes import ROOT
from tests.robustness.case import ANY, COMPLETED, REFUSED, Case, written

TEXT = (ROOT / "scenarios" / "basic.toml").read_text(encoding="utf-8")
CHECK = (("check", "scenario.toml"),)
RUN = (("run", "scenario.toml", "--out", "out"),)


def cases() -> Iterator[Case]:
    """Give a case for every file."""
    for name, (content, codes, says) in _CONTENTS.items():
        yield Case(
            name=f"scenario file: {name}",
            prepare=written({"scenario.toml": content}),
            commands=CHECK,
            codes=codes,
            says=says,
            fast=name in {"empty", "nesting 5,000 deep", "a number of 5,000 digits", "UTF-16"},
        )
    for name, prepare in _PLACES.items():
        for commands in (CHECK, RUN):
            yield Case(
                name=f"scenario file: {name} ({commands[0][0]})",
                prepare=prepare,
                commands=commands,
                says=("scenario.toml",),
                fast=name == "a device that never ends",
            )
    yield from _references()


def _after(section: str, line: str) -> str:
    return TEXT.replace(f"[{section}]", f"[{section}]\n{line}", 1)


def _without(section: str) -> str:
    lines, keep = [], True
    for line in TEXT.splitlines(keepends=True):
        if line.startswith("["):
            keep = not line.startswith(f"[{section}]")
        lines.append(line if keep else "")
    return "".join(lines)


_CONTENTS: dict[str, tuple[str | bytes, tuple[int, ...], tuple[str, ...]]] = {
    "empty": ("", (REFUSED,), ("schema", "missing")),
    "a line of prose": ("please fly", (REFUSED,), ("TOML",)),
    "noise": (np.random.default_rng(1).bytes(5000), (REFUSED,), ("UTF-8",)),
    "zeros": (bytes(5000), (REFUSED,), ("TOML",)),
    "UTF-16": (TEXT.encode("utf-16"), (REFUSED,), ("UTF-8",)),
    "Latin-1": (TEXT.replace("paper", "Größe").encode("latin-1"), (REFUSED,), ("UTF-8",)),
    "a byte order mark": (TEXT.encode("utf-8-sig"), (COMPLETED,), ()),
    "carriage returns": (TEXT.replace("\n", "\r\n"), (COMPLETED,), ()),
    "cut in half": (TEXT[: len(TEXT) // 2], (REFUSED,), ()),
    "twice": (TEXT + TEXT, (REFUSED,), ("TOML",)),
    "a section twice": (TEXT + "\n[gyro]\nnoise_rad_s = 1\n", (REFUSED,), ("TOML",)),
    "nesting 5,000 deep": ("a = " + "[" * 5000 + "]" * 5000, (REFUSED,), ("deep",)),
    "tables 5,000 deep": ("a = " + "{b = " * 5000 + "1" + "}" * 5000, (REFUSED,), ("deep",)),
    "a key of 5,000 parts": (".".join("a" * 5000) + " = 1", (REFUSED,), ()),
    "a number of 5,000 digits": (TEXT.replace("seed = 1", "seed = " + "9" * 5000), (REFUSED,), ("TOML", "digits")),
    "a fraction of 5,000 digits": (_after("controller", "x = 0." + "1" * 5000), (REFUSED,), ()),
    "five megabytes": (TEXT + "#" + "x" * 5_000_000, (REFUSED,), ("4 MB",)),
    "JSON": ('{"schema": 1}', (REFUSED,), ("TOML",)),
    "YAML": ("schema: 1\nname: basic\n", (REFUSED,), ("TOML",)),
    "another version": (TEXT.replace("schema = 1", "schema = 2"), (REFUSED,), ("schema",)),
    "no name": (TEXT.replace('name = "basic"\n', ""), (REFUSED,), ("name",)),
    "a name of a path": (TEXT.replace('"basic"', '"../basic"', 1), (REFUSED,), ("name",)),
    "a name of markup": (TEXT.replace('"basic"', '"[red]"', 1), (REFUSED,), ("name",)),
    "a name of 101 letters": (TEXT.replace('"basic"', f'"{"b" * 101}"', 1), (REFUSED,), ("name",)),
    "an empty name": (TEXT.replace('"basic"', '""', 1), (REFUSED,), ("name",)),
    "a description of markup": (TEXT.replace('description = "', 'description = "[/] [bold]{x} %s \\u0000 '), ANY, ()),
    "a negative seed": (TEXT.replace("seed = 1", "seed = -1"), (REFUSED,), ("seed",)),
    "a seed beyond 64 bits": (TEXT.replace("seed = 1", f"seed = {2**64}"), (REFUSED,), ("seed",)),
    "a seed with a point": (TEXT.replace("seed = 1", "seed = 1.5"), (REFUSED,), ("seed",)),
    "a seed that is true": (TEXT.replace("seed = 1", "seed = true"), (REFUSED,), ("seed",)),
    "a date for a number": (TEXT.replace("seed = 1", "seed = 2026-01-01"), (REFUSED,), ("seed",)),
    "an unknown section": (TEXT + "\n[thrusters]\nforce_N = 1\n", (REFUSED,), ("thrusters",)),
    "an unknown key": (_after("gyro", "colour = 1"), (REFUSED,), ("colour",)),
    "a misspelt key": (TEXT.replace("noise_rad_s", "noise_rads", 1), (REFUSED,), ("noise_rad",)),
    "infinity": (TEXT.replace("mass_kg = 4.0", "mass_kg = inf"), (REFUSED,), ("mass_kg",)),
    "not a number": (TEXT.replace("mass_kg = 4.0", "mass_kg = nan"), (REFUSED,), ("mass_kg",)),
    "an inertia of no body": (TEXT.replace("0.027]]", "0.27]]"), (REFUSED,), ("inertia",)),
    "an inertia that is not symmetric": (TEXT.replace("[[0.022, 0.0,", "[[0.022, 0.001,"), (REFUSED,), ("symmetric",)),
    "an inertia of two rows": (TEXT.replace(", [0.0, 0.0, 0.027]]", "]"), (REFUSED,), ("inertia",)),
    "five gimbals": (TEXT.replace("gimbal_angle_rad = [0.0, ", "gimbal_angle_rad = ["), (REFUSED,), ("5 entries",)),
    "a quaternion of zeros": (TEXT.replace("[1.0, 0.0, 0.0, 0.0]", "[0.0, 0.0, 0.0, 0.0]"), (REFUSED,), ("norm",)),
    "all units failed": (TEXT.replace("failed = []", "failed = [1, 2, 3, 4, 5, 6]"), (REFUSED,), ("failed",)),
    "a seventh unit failed": (TEXT.replace("failed = []", "failed = [7]"), (REFUSED,), ("failed",)),
    "a unit failed twice": (TEXT.replace("failed = []", "failed = [1, 1]"), (REFUSED,), ("failed",)),
    "no estimator": (TEXT.replace('estimators = ["', 'estimators = [] # ["', 1), (REFUSED,), ("estimators",)),
    **{
        f"no [{name}]": (_without(name), (REFUSED,), (name,)) for name in ("platform", "gyro", "estimation", "maneuver")
    },
    **{
        f"no [{name}]": (_without(name), ANY, ()) for name in ("platform", "cluster", "limits", "initial", "simulation")
    },
}


def _link_to(target: str) -> Callable[[Path], None]:
    return lambda folder: (folder / "scenario.toml").symlink_to(target)


_PLACES: dict[str, Callable[[Path], None]] = {
    "is not there": lambda _: None,
    "a folder": lambda folder: (folder / "scenario.toml").mkdir(),
    "a device that never ends": _link_to("/dev/zero"),
    "a device that is empty": _link_to("/dev/null"),
    "a pipe that nobody writes": lambda folder: os.mkfifo(folder / "scenario.toml"),
    "a link to itself": _link_to("scenario.toml"),
    "a link to nothing": _link_to("nothing.toml"),
}


def _references() -> Iterator[Case]:
    """Files that a scenario names."""
    maneuver = TEXT.replace('kind = "basic"\nduration_s = 5.0\nscale = 1.0', 'kind = "csv"\nfile = "maneuver.csv"')
    contents: dict[str, bytes] = {
        "empty": b"",
        "noise": np.random.default_rng(2).bytes(3000),
        "names alone": b"time_s,body_rate_x_rad_s,body_rate_y_rad_s,body_rate_z_rad_s\n",
        "words": b"time_s,body_rate_x_rad_s,body_rate_y_rad_s,body_rate_z_rad_s\n0,a,b,c\n1,a,b,c\n",
        "one row": b"time_s,body_rate_x_rad_s,body_rate_y_rad_s,body_rate_z_rad_s\n0,0,0,0\n",
        "time backwards": b"time_s,body_rate_x_rad_s,body_rate_y_rad_s,body_rate_z_rad_s\n"
        + b"".join(b"%d,0,0,0\n" % time for time in range(20, 0, -1)),
        "rates of 1e300": b"time_s,body_rate_x_rad_s,body_rate_y_rad_s,body_rate_z_rad_s\n"
        + b"".join(b"%d,1e300,0,0\n" % time for time in range(20)),
        "a year": b"time_s,body_rate_x_rad_s,body_rate_y_rad_s,body_rate_z_rad_s\n"
        + b"".join(b"%d,0.1,0,0\n" % (time * 1_577_880) for time in range(20)),
    }
    for name, content in contents.items():
        yield Case(
            name=f"maneuver file: {name}",
            prepare=written({"scenario.toml": maneuver, "maneuver.csv": content}),
            commands=(("check", "scenario.toml"), *RUN),
            fast=name == "words",
        )
    for name, target in (("not there", None), ("a device", "/dev/zero"), ("a folder", ".")):

        def prepare(folder: Path, target: str | None = target) -> None:
            (folder / "scenario.toml").write_text(maneuver, encoding="utf-8")
            if target is not None:
                (folder / "maneuver.csv").symlink_to(target)

        yield Case(
            name=f"maneuver file: {name}",
            prepare=prepare,
            commands=(("check", "scenario.toml"), *RUN),
            says=("maneuver.csv",),
            fast=False,
        )
