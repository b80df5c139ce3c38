"""Estimates of the gimbal-space design flown in MuJoCo's closed loop 1,000 times: bias, scatter, coverage.

Run with `python -m benchmarks.monte_carlo`; `testbed montecarlo` does it for any scenario and keeps the runs.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

from benchmarks.flight import SCENARIOS
from testbed.cli.app import app
from testbed.cli.failures import exit_code_of

RUNS = 1000


def main() -> None:
    """Fly the campaign and print its statistics."""
    with tempfile.TemporaryDirectory() as place:
        out = str(Path(place) / "campaign")
        command = ["montecarlo", str(SCENARIOS / "gimbal_d_optimal.toml"), "--runs", str(RUNS), "--out", out]
        code = exit_code_of(lambda: app(command))
    sys.exit(code)


if __name__ == "__main__":
    main()
