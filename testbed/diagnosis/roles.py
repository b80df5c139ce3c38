"""Which runs a diagnosis fits and which it holds out: as they say, or dealt so that what shows in one run is fitted."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from math import inf, log

import numpy as np

from testbed.arrays import Flags
from testbed.diagnosis.settings import SETTINGS
from testbed.effects.gyro_saturation import is_clipped
from testbed.errors import InputError
from testbed.estimation.contact import JUMP_CHANCE, log_chance_of_jump
from testbed.estimation.telemetry import Telemetry
from testbed.records.record import Record


def by_role(
    runs: Sequence[tuple[Record, Sequence[Telemetry]]], fitted: Collection[str] = ()
) -> tuple[list[int], list[int]]:
    """Return the indices of the runs to fit and of those to hold out.

    Args:
        runs: records, and what is used of each.
        fitted: names of records that are fitted whatever is dealt, as are those with the role "fit"; where any is said
            to be held out, no others are.

    Raises:
        InputError: every run is to be held out.
    """
    roles = [record.details.role for record, _ in runs]
    stated = "heldout" in roles
    kept = [index for index, role in enumerate(roles) if role == "fit" or runs[index][0].details.name in fitted]
    heldout = [index for index, role in enumerate(roles) if role == "heldout"] if stated else _dealt(runs, kept)
    fit = [index for index in range(len(runs)) if index not in heldout]
    if not fit:
        raise InputError('every run has role = "heldout": give at least one run the role "fit"')
    while unfitted := [
        index for index in heldout if (_axes_of([runs[index]]) & ~_axes_of(runs[each] for each in fit)).any()
    ]:
        if stated:
            raise InputError(
                f'{runs[unfitted[0]][0].details.name} has role = "heldout" and turns about an axis that no run with '
                'the role "fit" turns about: it could not be predicted; give it the role "fit"'
            )
        fit, heldout = sorted([*fit, unfitted[0]]), [index for index in heldout if index != unfitted[0]]
    return fit, heldout


def _axes_of(runs: Iterable[tuple[Record, Sequence[Telemetry]]]) -> Flags:
    """Return about which body axes any of some runs turns, shape (3,)."""
    return np.asarray(np.any([part.live for _, parts in runs for part in parts], axis=0))


def _dealt(runs: Sequence[tuple[Record, Sequence[Telemetry]]], fitted: Collection[int]) -> list[int]:
    """Return which runs are held out where none has a role: every third, and at least one of two.

    What shows in a single run, a touch, a clipped reading or what goes with the square of the rate, can only be found
    where it is fitted: such a run changes places with its neighbour. Where all neighbours seem to jump, as where rotors
    spin down, the one that does the most is fitted.
    """
    count, every = len(runs), SETTINGS.heldout_every
    due = range(every - 1, count, every) if count >= every else range(1, count)
    kept = {_fastest(runs), *fitted}
    groups = [[each for each in range(max(last - every + 1, 0), last + 1) if each not in kept] for last in due]
    return [_ordinary(group, runs) for group in groups if group]


_FAR_FASTER = 2.0
"""Times the body rate of every other run, from which one is fitted whatever is dealt.

Source: formula: of a drag that goes with the square of the rate it shows 16 times the χ². Of 200 sets (seed 15731) nine
have such a run; in one of them the drag that was hidden showed in it alone, and it was held out."""


def _fastest(runs: Sequence[tuple[Record, Sequence[Telemetry]]]) -> int | None:
    """Return the run that turns far faster than all others; None where there is none, or but two runs."""
    if len(runs) < 3:  # of two, one is held out whatever it shows
        return None
    rates = [max(float(np.sqrt(np.mean(part.body_rate**2))) for part in parts) for _, parts in runs]
    *_, second, first = sorted(rates)
    return rates.index(first) if first > _FAR_FASTER * second else None


def _ordinary(group: Sequence[int], runs: Sequence[tuple[Record, Sequence[Telemetry]]]) -> int:
    """Return the last run that shows nothing that may show in it alone; else the last but the one with the most."""
    shown = {index: _singularity(runs[index][1]) for index in group}
    plain = [index for index in group if shown[index] == 0.0]
    others = [index for index in group if shown[index] < max(shown.values())]
    return (plain or others or group)[-1]


def _singularity(parts: Sequence[Telemetry]) -> float:
    """Return by how much parts of a run show what may show in it alone; 0 where they do not."""
    if any(is_clipped([part]) for part in parts):
        return inf
    surprise = -min(map(log_chance_of_jump, parts))
    return surprise if surprise > -log(JUMP_CHANCE) else 0.0
