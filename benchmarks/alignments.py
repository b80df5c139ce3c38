"""Alignments from many closed-loop flights, with designed null motion and with pseudo-inverse steering.

Run with `python -m benchmarks.alignments [RUNS]`.
"""

from __future__ import annotations

import sys
import time

import numpy as np

from testbed.reproduction.alignments import Alignments, SteeringStatistics, alignments

CORES = 2
SEED = 1
GROUPS = {
    "inertia": slice(0, 6),
    "axis about s": slice(6, 12),
    "axis about t": slice(12, 18),
    "encoder zero": slice(18, 24),
    "momentum scale": slice(24, 30),
}


def main() -> None:
    """Print scatter, claims and coverage of every parameter, both null spaces, and the figures to reach."""
    runs = int(sys.argv[1]) if len(sys.argv) > 1 else 100
    began = time.perf_counter()
    found = alignments(runs, SEED, workers=CORES)
    print(f"{runs} platforms, each flown twice for 10 s in MuJoCo's closed loop: {time.perf_counter() - began:.0f} s")
    print_parameters(found)
    for statistics in (found.null_motion, found.pseudo_inverse):
        print_steering(statistics)
    print_figures(found)


def print_parameters(found: Alignments) -> None:
    """Print a line for each parameter."""
    print(f"{'':24}{'':7}{'null motion':^34}{'pseudo-inverse':^34}{'scatter':>9}")
    heading = f"{'scatter':>12}{'claimed':>12}{'covers':>10}"
    print(f"{'parameter':24}{'unit':7}{heading}{heading}{'ratio':>9}")
    for index, (name, unit) in enumerate(zip(found.names, found.units, strict=True)):
        row = "".join(
            f"{each.scatter[index]:12.2e}{each.claimed[index]:12.2e}{each.coverage[index]:10.1%}"
            for each in (found.null_motion, found.pseudo_inverse)
        )
        print(f"{name:24}{unit:7}{row}{found.scatter_ratio[index]:9.1f}")


def print_steering(statistics: SteeringStatistics) -> None:
    """Print what a steering's flights used, and the null space of the first one's record."""
    print(
        f"{statistics.steering}: {statistics.failed} failed, {statistics.saturated:.3f} s at a limit, gimbal rate to "
        f"{statistics.gimbal_rate:.0%}, body rate off the reference by {statistics.rate_difference:.1e} rad/s rms"
    )
    for line in statistics.null_space:
        print(f"  open: {line}")


def print_figures(found: Alignments) -> None:
    """Print the figures with what they have to reach."""
    low, high = found.coverage_range
    for statistics in (found.null_motion, found.pseudo_inverse):
        coverage = statistics.coverage
        print(
            f"{statistics.steering}: 95 % intervals cover {coverage.min():.0%} to {coverage.max():.0%}, mean "
            f"{coverage.mean():.1%}   (each within {low:.0%} to {high:.0%})"
        )
    for name, part in GROUPS.items():
        print(f"scatter ratio, {name}: median {np.median(found.scatter_ratio[part]):.1f}")
    print(f"scatter ratio, all designed for: median {found.median_ratio:.1f}   (at least 2)")


if __name__ == "__main__":
    main()
