"""The cases of a set in their random order."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import cycle, islice
from typing import Any

import numpy as np

_ORDER = 1_000_000
"""Spawn key of the order of a set; cases have smaller ones."""


@dataclass(frozen=True, kw_only=True)
class Order:
    """One case to make.

    Attributes:
        index: of the case, from 0.
        stratum: part of the score card.
        effect: id of the (first) effect; None for any, or none.
        multiple: its size, as its stratum counts it.
    """

    index: int
    stratum: str
    effect: str | None
    multiple: float | None


def case_name(order: Order) -> str:
    """Return the name of a case's folders."""
    return f"case_{order.index + 1:04d}"


def order_generator(seed: int) -> np.random.Generator:
    """Return the source of a set's order."""
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(_ORDER,)))


def case_generator(seed: int, order: Order) -> np.random.Generator:
    """Return the source of all that is random in a case: a function of the set's seed and the case's number."""
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(order.index,)))


def shuffled(wanted: Sequence[tuple[str, str | None, float | None]], rng: np.random.Generator) -> list[Order]:
    """Return orders of strata, effects and sizes in random order."""
    return [
        Order(index=index, stratum=wanted[pick][0], effect=wanted[pick][1], multiple=wanted[pick][2])
        for index, pick in enumerate(rng.permutation(len(wanted)))
    ]


def turns(rng: np.random.Generator, of: Iterable[Any], count: int) -> Iterable[Any]:
    """Return so many of a few in turns, in random order: each as often as any other, but for one."""
    few = [*of]
    return islice(cycle([few[index] for index in rng.permutation(len(few))]), count)
