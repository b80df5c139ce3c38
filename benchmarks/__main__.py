"""Everything that is measured against something else, in one table: `make bench`, `make bench-long`.

python -m benchmarks [PART ...] [--long] [--write]

Without PART, every part that takes minutes, or with --long the parts that take longer. With --write the rows go into
docs/benchmarks.md. Each part also runs alone, `python -m benchmarks.flight` and so on, and `python -m benchmarks
--figures` prints what is measured against a bound instead of another code.
"""

from __future__ import annotations

import argparse
import importlib
import json
import subprocess
import sys
import tempfile
from dataclasses import asdict
from pathlib import Path

from benchmarks.ratios import Ratio
from benchmarks.table import PAGE, PartRows, here_and_now, page, read_parts, write_parts

PARTS = {
    "flight": "benchmarks.flight:ratios",
    "campaign": "benchmarks.campaign:ratios",
    "engines": "benchmarks.engines:ratios",
    "basilisk": "benchmarks.basilisk:ratios",
    "sysid": "benchmarks.sysid:ratios",
    "design": "benchmarks.design:ratios",
    "recording": "benchmarks.recording:ratios",
    "logs": "benchmarks.logs:ratios",
}
LONG_PARTS = {
    "campaign_size": "benchmarks.campaign:size_ratios",
    "compiled_campaign": "benchmarks.engines:campaign_ratios",
    "sysid_scatter": "benchmarks.sysid:scatter_ratios",
}
FIGURES = ("benchmarks.flight", "benchmarks.design", "benchmarks.estimators", "benchmarks.monte_carlo")
_MEASURE = "--measure"


def main() -> None:
    """Measure parts, each in a process of its own, so that none warms up another."""
    chosen = _arguments()
    if chosen.figures:
        _print_figures()
        return
    known = LONG_PARTS if chosen.long else PARTS
    measured = here_and_now()
    order, fresh, failed = [*PARTS, *LONG_PARTS], {}, []
    for name in chosen.parts or known:
        try:
            fresh[name] = PartRows(measured=measured, rows=measure(name))
        except subprocess.CalledProcessError:
            failed.append(name)  # it has said why; the others are measured all the same
            continue
        if chosen.write:
            write_parts(read_parts() | fresh, order)
    print("\n" + page(fresh, order))
    if chosen.write:
        print(f"Written to {PAGE}")
    if failed:
        sys.exit(f"could not be measured: {', '.join(failed)}; the table keeps what it had of them")


def measure(name: str) -> tuple[Ratio, ...]:
    """Return the rows of a part, measured in a process of its own."""
    print(f"\n== {name}", flush=True)
    with tempfile.TemporaryDirectory() as folder:
        rows = Path(folder) / "rows.json"
        subprocess.run([sys.executable, "-m", "benchmarks", _MEASURE, name, str(rows)], check=True)
        return tuple(Ratio(**row) for row in json.loads(rows.read_text(encoding="utf-8")))


def _measure_here(name: str, path: Path) -> None:
    module, function = (PARTS | LONG_PARTS)[name].split(":")
    rows = getattr(importlib.import_module(module), function)()
    path.write_text(json.dumps([asdict(row) for row in rows]), encoding="utf-8")


def _print_figures() -> None:
    for part in FIGURES:
        print(f"\n== python -m {part}", flush=True)
        subprocess.run([sys.executable, "-m", part], check=True)


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__.splitlines()[0])
    parser.add_argument("parts", nargs="*", metavar="PART", help=", ".join([*PARTS, *LONG_PARTS]))
    parser.add_argument("--long", action="store_true", help="the parts that take longer than minutes")
    parser.add_argument("--write", action="store_true", help="write the rows into docs/benchmarks.md")
    parser.add_argument("--figures", action="store_true", help="print what is measured against a bound")
    chosen = parser.parse_args()
    unknown = set(chosen.parts) - set(PARTS) - set(LONG_PARTS)
    if unknown:
        parser.error(f"no part {', '.join(sorted(unknown))}; there are {', '.join([*PARTS, *LONG_PARTS])}")
    return chosen


if __name__ == "__main__":
    if sys.argv[1:2] == [_MEASURE]:
        _measure_here(sys.argv[2], Path(sys.argv[3]))
    else:
        main()
