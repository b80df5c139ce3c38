"""All figures, one after the other: `make bench`.

Each part also runs alone: `python -m benchmarks.flight`, `.design`, `.estimators`, `.monte_carlo`.
"""

from __future__ import annotations

import subprocess
import sys

PARTS = ("benchmarks.flight", "benchmarks.design", "benchmarks.estimators", "benchmarks.monte_carlo")


def main() -> None:
    """Run every part in a process of its own, so that none warms up another."""
    for part in PARTS:
        print(f"\n== python -m {part}", flush=True)
        subprocess.run([sys.executable, "-m", part], check=True)


if __name__ == "__main__":
    main()
