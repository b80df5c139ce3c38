"""The blind sets of craft with wheels: python -m benchmarks.blind_wheels make|run|card --seed S --cases N.

Two sets of N cases, three in ten without an effect: `cubesat_wheels`, which flies freely, and `air_bearing`, which
stands on a ball joint; --platforms takes one of them. The stages are those of `benchmarks.platform_sets`.
"""

from __future__ import annotations

from pathlib import Path

from benchmarks import platform_sets
from concealing.order import Order
from concealing.wheel_set import make_wheels, wheel_orders

_SCENARIOS = {name: Path("scenarios") / f"{name}.toml" for name in ("cubesat_wheels", "air_bearing")}
SEED, CASES = 52817, 100
"""Of the set whose card is kept, which nobody had looked at when it was diagnosed; and cases of each platform."""
_HEAD = """# The blind set of craft with wheels

Written by `python -m benchmarks.blind_wheels card --write`; do not edit. Each figure is explained in
[scoring.md](scoring.md).

    python -m benchmarks.blind_wheels make          # 100 cases of each platform into runs/, with their sealed answers
    python -m benchmarks.blind_wheels run           # diagnoses them; both can be interrupted, and go on where they were
    python -m benchmarks.blind_wheels card --write  # scores what has been diagnosed so far into this page

The concealing engine flies a CubeSat with four wheels, `cubesat_wheels`, freely, and a table on a ball bearing under
gravity, `air_bearing`, by equations, formulas and a reader of its own: no MJCF, no code of the testbed but the
records' writer. Wheel speeds follow a plan of the nominal platform, open-loop. An effect is hidden at two or four
times its smallest detectable size, counted in what of the records came through; three cases in ten have none. What can
be hidden: the effects of the published table that sit in no gimbal, dry friction, coloured noise, late telemetry; a
wheel's inertia, axis and tachometer, the friction of its bearing, its motor's torque and lag, its imbalance; and on
the bearing the centre of mass and the air. Appendages and loose masses are not: these slow turns hardly excite them.

"""


def _orders(platform: str, cases: int, seed: int) -> list[Order]:
    return wheel_orders(_SCENARIOS[platform], cases, seed)


SETS = platform_sets.PlatformSets(
    module="benchmarks.blind_wheels",
    page="blind-wheels",
    scenarios=_SCENARIOS,
    orders=_orders,
    make=make_wheels,
    seed=SEED,
    cases=CASES,
    head=_HEAD,
)


if __name__ == "__main__":
    platform_sets.main(SETS)
