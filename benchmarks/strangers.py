"""Blind sets that Basilisk flies: make strangers, or python -m benchmarks.strangers make|run|card --seed S --cases N.

Two sets of N cases, a quarter without an effect: `cubesat_wheels`, which flies freely, and `microsat`, on orbit;
--platforms takes one of them. The stages are those of `benchmarks.platform_sets`. `make` installs Basilisk into an
environment of its own, under build/, when it is called first.
"""

from __future__ import annotations

from benchmarks import platform_sets
from benchmarks.strangers_cases import make_stranger, stranger_orders
from benchmarks.strangers_engine import PLATFORMS

SEED, CASES = 30917, 200
"""Of a set that nobody has looked at, and cases of each platform; 55, 411 and 412 were looked at."""
_HEAD = """# A stranger's engine

Written by `make strangers`; do not edit. Each figure is explained in [scoring.md](scoring.md), and in
[the how-to](how-to/strangers.md) how the cases are made.

"""

_FIRST_WANTED = {2.0: "≥ 85 %", 4.0: "≥ 95 %"}
"""Less than of our own engine's sets: nobody who wrote the diagnosis wrote these effects. Stated before any case was
made; until 2026-11-24 the page showed what is wanted of our own sets."""

SETS = platform_sets.PlatformSets(
    module="benchmarks.strangers",
    page="strangers",
    scenarios={name: platform.scenario for name, platform in PLATFORMS.items()},
    orders=stranger_orders,
    make=make_stranger,
    seed=SEED,
    cases=CASES,
    head=_HEAD,
    first_wanted=_FIRST_WANTED,
)


if __name__ == "__main__":
    platform_sets.main(SETS)
