"""docs/benchmarks.md and the rows behind it, docs/benchmarks.json: what was measured last, part by part."""

from __future__ import annotations

import json
import os
import platform
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from datetime import date
from importlib.metadata import version
from pathlib import Path

from benchmarks.ratios import Ratio

DOCS = Path(__file__).resolve().parents[1] / "docs"
PAGE, ROWS = DOCS / "benchmarks.md", DOCS / "benchmarks.json"

_HEAD = """# Measured against others

Written by `make bench` and `make bench-long` (`python -m benchmarks --write`, `--long --write`); do not edit. Every
figure is a ratio of two things done in turn, in one run, on one machine: ratios hold elsewhere, times do not. More
than 1 means that ours is better, unless the row says otherwise.

| what | ratio | target | ours | theirs | command |
|---|---|---|---|---|---|
"""


@dataclass(frozen=True, kw_only=True)
class PartRows:
    """What a part measured.

    Attributes:
        measured: when and on what.
        rows: the table's.
    """

    measured: str
    rows: tuple[Ratio, ...]


def page(parts: Mapping[str, PartRows], order: Iterable[str]) -> str:
    """Return the page: one table, then how each row was measured.

    Args:
        parts: by name.
        order: of the parts; those that were never measured are left out.
    """
    present = [parts[name] for name in order if name in parts]
    lines = [_line(row) for part in present for row in part.rows]
    notes = [f"- {row.what}: {row.note}." for part in present for row in part.rows if row.note]
    where = sorted({part.measured for part in present})
    return (
        _HEAD + "\n".join(lines) + "\n\n## How\n\n" + "\n".join([*notes, "", *(f"Measured {w}." for w in where)]) + "\n"
    )


def read_parts(path: Path = ROWS) -> dict[str, PartRows]:
    """Return what was measured before; nothing where there is no file."""
    if not path.is_file():
        return {}
    stored = json.loads(path.read_text(encoding="utf-8"))
    return {
        name: PartRows(measured=part["measured"], rows=tuple(Ratio(**row) for row in part["rows"]))
        for name, part in stored.items()
    }


def write_parts(parts: Mapping[str, PartRows], order: Sequence[str]) -> None:
    """Write the rows and the page."""
    ordered = {name: parts[name] for name in order if name in parts}
    stored = {
        name: {"measured": part.measured, "rows": [asdict(row) for row in part.rows]} for name, part in ordered.items()
    }
    ROWS.write_text(json.dumps(stored, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    PAGE.write_text(page(parts, order), encoding="utf-8")


def here_and_now() -> str:
    """Return when and on what this run measures."""
    return (
        f"{date.today().isoformat()} on {os.cpu_count()} cores ({_processor()}), Python {platform.python_version()}, "
        f"mujoco {version('mujoco')}, numpy {version('numpy')}"
    )


def _line(row: Ratio) -> str:
    ratio = "not measured" if row.ratio is None else _figures(row.ratio)
    return f"| {row.what} | {ratio} | {row.target} | {row.ours} | {row.theirs} | `{row.command}` |"


def _figures(ratio: float) -> str:
    """Three figures, whole where large: 0.698, 1.14, 88.7, 1,108."""
    return f"{ratio:,.0f}" if ratio >= 100 else f"{ratio:#.3g}"


def _processor() -> str:
    cpuinfo = Path("/proc/cpuinfo")
    if not cpuinfo.is_file():
        return platform.machine()
    names = [
        line.split(":", 1)[1].strip() for line in cpuinfo.read_text().splitlines() if line.startswith("model name")
    ]
    return names[0] if names else platform.machine()
