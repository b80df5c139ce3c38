"""Make a whole blind set: python -m concealing.blind_set --data DIR --answers DIR --seed N [--null 200 ...].

Cases are numbered in random order, made in parallel, and left alone where they are already whole: an interrupted run
goes on where it was. Case k depends on the seed and on k alone.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from itertools import product
from pathlib import Path

import numpy as np

from concealing.case import Case
from concealing.files import conceal
from concealing.library import LISTED, UNLISTED
from concealing.order import Order, case_generator, case_name, order_generator, shuffled, turns
from concealing.sealing import SEAL
from concealing.strata import (
    FLOWN_EFFECTS,
    FLOWN_MULTIPLES,
    MULTIPLES,
    NEVER_HIDDEN,
    UNLISTED_SIGMA,
    random_case,
)


@dataclass(frozen=True, kw_only=True)
class Counts:
    """How many cases of each stratum."""

    null: int = 200
    single: int = 420
    pair: int = 70
    unlisted: int = 70
    sigma_understated: int = 20
    sigma_overstated: int = 20
    flown: int = 40
    flown_null: int = 16


def orders(counts: Counts, seed: int) -> list[Order]:
    """Return the cases of a set in their random order; effects and sizes take turns, so that each gets its share."""
    rng = order_generator(seed)
    return shuffled([*_wanted(counts, rng)], rng)


def make(order: Order, seed: int, scenario: Path, data: Path, answers: Path) -> Path:
    """Make one case where it is not whole yet; return its data folder."""
    name = case_name(order)
    if not (data / name / SEAL).exists():
        conceal(case_of(order, seed, scenario), data / name, answers / name)
    return data / name


def case_of(order: Order, seed: int, scenario: Path) -> Case:
    """Return a case as it was ordered: a function of the set's seed and the case's number."""
    return random_case(case_generator(seed, order), order.stratum, scenario, order.effect, order.multiple)


def _wanted(counts: Counts, rng: np.random.Generator) -> Iterator[tuple[str, str | None, float | None]]:
    listed = [name for name in LISTED if name not in NEVER_HIDDEN]
    yield from [("null", None, None)] * counts.null
    yield from (("single", *each) for each in turns(rng, product(listed, MULTIPLES), counts.single))
    yield from (("pair", name, None) for name in turns(rng, _with_cmgs(listed), counts.pair))
    yield from (("unlisted", *each) for each in turns(rng, product(UNLISTED, UNLISTED_SIGMA), counts.unlisted))
    yield from [("sigma_understated", None, None)] * counts.sigma_understated
    yield from [("sigma_overstated", None, None)] * counts.sigma_overstated
    yield from (("flown", *each) for each in turns(rng, product(FLOWN_EFFECTS, FLOWN_MULTIPLES), counts.flown))
    yield from [("flown", None, None)] * counts.flown_null


def _with_cmgs(names: list[str]) -> list[str]:
    return [name for name in names if "cmg" in LISTED[name].actuation]


def main() -> None:
    """Read the command line and make the set."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--data", type=Path, required=True)
    parser.add_argument("--answers", type=Path, required=True)
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--scenario", type=Path, default=Path("scenarios/diagnose.toml"))
    parser.add_argument("--jobs", type=int, default=1)
    for name in Counts.__dataclass_fields__:
        parser.add_argument(f"--{name.replace('_', '-')}", type=int, default=getattr(Counts, name))
    options = parser.parse_args()
    counts = Counts(**{name: getattr(options, name) for name in Counts.__dataclass_fields__})
    todo = orders(counts, options.seed)
    with ProcessPoolExecutor(options.jobs) as pool:
        made = [pool.submit(make, each, options.seed, options.scenario, options.data, options.answers) for each in todo]
        for count, future in enumerate(made, start=1):
            print(f"\r{future.result().name} {count} of {len(todo)}", end="", flush=True)
    print()


if __name__ == "__main__":
    main()
