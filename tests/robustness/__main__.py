"""All robustness cases: `python -m tests.robustness [PART OF A NAME] [--jobs N]`; exit code 1 where one fails.

With `--measured 300 --seed 7` instead: so many sets of mutated records of real flights, each diagnosed; a minute each.
"""

from __future__ import annotations

import argparse
import os
import sys
import time
from concurrent.futures import ThreadPoolExecutor

from tests.robustness.measured import measured_cases
from tests.robustness.running import failures
from tests.robustness.table import CASES


def main() -> None:
    """Run them, several at once, and print how many there were and how many failed."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("wanted", nargs="?", default="", help="only cases with this in their name")
    parser.add_argument("--jobs", type=int, default=len(os.sched_getaffinity(0)), help="at once")
    parser.add_argument("--fast", action="store_true", help="only those that the test suite runs")
    parser.add_argument("--measured", type=int, metavar="N", help="mutated real records instead, so many sets")
    parser.add_argument("--seed", type=int, default=1, help="of the mutations")
    arguments = parser.parse_args()
    cases = CASES if arguments.measured is None else measured_cases(arguments.measured, arguments.seed)
    chosen = [case for case in cases if arguments.wanted in case.name and (case.fast or not arguments.fast)]
    began, failed = time.monotonic(), 0
    with ThreadPoolExecutor(arguments.jobs) as pool:
        for complaints in pool.map(failures, chosen):
            failed += bool(complaints)
            for complaint in complaints:
                print(complaint, flush=True)
    print(f"robustness: {len(chosen)} cases, {failed} failures, {time.monotonic() - began:.0f} s")
    sys.exit(failed > 0)


if __name__ == "__main__":
    main()
