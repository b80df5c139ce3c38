"""Which runs are fitted and which are held out."""

from __future__ import annotations

from collections.abc import Sequence

from testbed.effects.contact import shows_a_jump
from testbed.effects.gyro_saturation import is_clipped
from testbed.errors import InputError
from testbed.estimation.telemetry import Telemetry
from testbed.records.record import Record

EVERY = 3
"""Of runs without a role, every third is held out."""


def by_role(runs: Sequence[tuple[Record, Sequence[Telemetry]]]) -> tuple[list[int], list[int]]:
    """Return the indices of the runs to fit and of those to hold out.

    Args:
        runs: records, and what is used of each.

    Raises:
        InputError: every run is to be held out.
    """
    roles = [record.details.role for record, _ in runs]
    heldout = [index for index, role in enumerate(roles) if role == "heldout"] if any(roles) else _dealt(runs)
    fit = [index for index in range(len(runs)) if index not in heldout]
    if not fit:
        raise InputError('every run has role = "heldout": give at least one run the role "fit"')
    return fit, heldout


def _dealt(runs: Sequence[tuple[Record, Sequence[Telemetry]]]) -> list[int]:
    """Return which runs are held out where none has a role: every third, and at least one of two.

    What shows in a single run, a touch or a clipped reading, can only be found where it is fitted: such a run changes
    places with its neighbour.
    """
    count = len(runs)
    special = [any(shows_a_jump(part) or is_clipped([part]) for part in parts) for _, parts in runs]
    due = range(EVERY - 1, count, EVERY) if count >= EVERY else range(1, count)
    groups = [range(max(last - EVERY + 1, 0), last + 1) for last in due]
    return [next((index for index in reversed(group) if not special[index]), group[-1]) for group in groups]
