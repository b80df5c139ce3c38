"""The folder of a campaign, after a disk or a person has been at it; what can be mended is, the rest is refused."""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path

from support.campaigns import small_scenario
from support.processes import outcome, started
from tests.robustness.case import COMPLETED, REFUSED, Scene, broken

_RUNS = 30
"""Two parts, of 25 runs and of 5."""


def cases() -> Iterator[Scene]:
    """Give a scene for every damage."""
    for name, (damage, code) in _DAMAGES.items():
        yield Scene(name=f"campaign: {name}", play=_resumed(damage, code), fast=False)


def _resumed(damage: Callable[[Path], object], expected: int) -> Callable[[Path], Iterator[str]]:
    def play(folder: Path) -> Iterator[str]:
        scenario, out = small_scenario(folder), folder / "out"
        arguments = ("montecarlo", scenario, "--workers", 1, "--out", "out")
        with started(*arguments, "--runs", _RUNS, cwd=folder) as process:
            outcome(process)
        before = _statistics(out)
        damage(out)
        with started(*arguments, "--runs", _RUNS, "--resume", cwd=folder) as process:
            code, output, complaints = outcome(process)
        if code != expected:
            yield f"exit code {code}, not {expected}: {(complaints or output)[-600:]}"
        if word := broken(output + complaints):
            yield f"prints {word}: {(complaints or output)[-600:]}"
        if code == COMPLETED and _statistics(out) != before:
            yield "the statistics are others than those of the campaign that nothing was done to"
        if code == REFUSED and not complaints.strip():
            yield "refused without a word"

    return play


def _statistics(out: Path) -> object:
    """Return what a campaign found; how long it took, and by which command line, is another matter."""
    content = json.loads((out / "montecarlo.json").read_text(encoding="utf-8"))
    return {name: value for name, value in content.items() if name not in {"seconds", "provenance"}}


def _flipped(path: Path, place: int) -> None:
    content = bytearray(path.read_bytes())
    content[place] ^= 0xFF
    path.write_bytes(bytes(content))


def _part(number: int) -> str:
    return f"runs/part-{number:05d}.parquet"


def _manifest(change: Callable[[dict[str, object]], object]) -> Callable[[Path], None]:
    def damage(out: Path) -> None:
        path = out / "campaign.json"
        content = json.loads(path.read_text(encoding="utf-8"))
        change(content)
        path.write_text(json.dumps(content), encoding="utf-8")

    return damage


_DAMAGES: dict[str, tuple[Callable[[Path], object], int]] = {
    "nothing": (lambda _: None, COMPLETED),
    "a part with a flipped byte": (lambda out: _flipped(out / _part(0), 500), COMPLETED),
    "a part with a flipped footer": (lambda out: _flipped(out / _part(1), -9), COMPLETED),
    "a part cut short": (lambda out: os.truncate(out / _part(0), 100), COMPLETED),
    "an empty part": (lambda out: os.truncate(out / _part(0), 0), COMPLETED),
    "a part that is gone": (lambda out: (out / _part(0)).unlink(), COMPLETED),
    "all parts gone": (lambda out: shutil.rmtree(out / "runs"), COMPLETED),
    "parts exchanged": (
        lambda out: (
            (out / _part(0)).rename(out / "runs" / "kept"),
            (out / _part(1)).rename(out / _part(0)),
            (out / "runs" / "kept").rename(out / _part(1)),
        ),
        COMPLETED,
    ),
    "a copied part": (lambda out: shutil.copyfile(out / _part(0), out / _part(99999)), COMPLETED),
    "a stray part": (lambda out: (out / "runs" / "part-junk.parquet").write_bytes(b"junk"), COMPLETED),
    "a folder for a part": (lambda out: ((out / _part(0)).unlink(), (out / _part(0)).mkdir()), COMPLETED),
    "a device for a part": (
        lambda out: ((out / _part(0)).unlink(), (out / _part(0)).symlink_to("/dev/zero")),
        COMPLETED,
    ),
    "a part half written by a killed process": (
        lambda out: (out / "runs" / ".part-00000.parquet.part").write_bytes(b"PAR1"),
        COMPLETED,
    ),
    "statistics and page gone": (
        lambda out: [(out / name).unlink() for name in ("report.html", "provenance.json")],
        COMPLETED,
    ),
    "no manifest": (lambda out: (out / "campaign.json").unlink(), REFUSED),
    "an empty manifest": (lambda out: (out / "campaign.json").write_text(""), REFUSED),
    "a manifest of noise": (lambda out: (out / "campaign.json").write_bytes(bytes(range(256))), REFUSED),
    "a manifest that is a list": (lambda out: (out / "campaign.json").write_text("[]"), REFUSED),
    "a manifest nesting 5,000 deep": (
        lambda out: (out / "campaign.json").write_text('{"a": ' * 5000 + "1" + "}" * 5000),
        REFUSED,
    ),
    "a manifest nesting 100,000 lists deep": (
        lambda out: (out / "campaign.json").write_text("[" * 100_000 + "]" * 100_000),
        REFUSED,
    ),
    "a manifest with a number of 5,000 digits": (
        lambda out: (out / "campaign.json").write_text('{"seconds": ' + "9" * 5000 + "}"),
        REFUSED,
    ),
    "a manifest that never ends": (
        lambda out: ((out / "campaign.json").unlink(), (out / "campaign.json").symlink_to("/dev/zero")),
        REFUSED,
    ),
    "a manifest of another seed": (_manifest(lambda content: content["campaign"].update(seed=77)), REFUSED),
    "a manifest of another campaign": (_manifest(lambda content: content.update(campaign={})), REFUSED),
    "a manifest without times": (_manifest(lambda content: content.update(seconds="long")), REFUSED),
    "another scenario of the same name": (
        lambda out: (out.parent / "small.toml").write_text(
            (out.parent / "small.toml").read_text().replace("noise_rad_s = 0.002", "noise_rad_s = 0.003")
        ),
        REFUSED,
    ),
}
