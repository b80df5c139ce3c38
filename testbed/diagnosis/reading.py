"""From records to the runs of a diagnosis: their roles and their noise; what cannot be used is said."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from testbed.assembly.platform import Body
from testbed.diagnosis.data import Runs
from testbed.diagnosis.gate import Gated, Usable, gated, grouped, runs_together
from testbed.diagnosis.noise import pooled_noise, with_pooled_noise, with_telemetry_noise, without_spikes
from testbed.diagnosis.windows import outliers_notice
from testbed.dynamics.inertia import theta_of
from testbed.effects.gyro_saturation import is_clipped
from testbed.errors import InputError
from testbed.estimation.contact import shows_a_jump
from testbed.estimation.telemetry import Telemetry
from testbed.records.record import Record
from testbed.scenario.body import BodyScenario


@dataclass(frozen=True, kw_only=True, eq=False)
class DataSet:
    """What a folder of records gives the diagnosis.

    Attributes:
        runs: to fit.
        heldout: to verify on; None of a single run.
        fit_records: names of the records to fit.
        heldout_records: of those to verify on.
        notices: what a reader of the diagnosis has to know of the records.
    """

    runs: Runs
    heldout: Runs | None
    fit_records: tuple[str, ...]
    heldout_records: tuple[str, ...]
    notices: tuple[str, ...]

    @property
    def alone(self) -> bool:
        """Whether there is but one record, in one part or several: what it shows can be verified on no other."""
        return len(self.fit_records) == 1 and not self.heldout_records


def data_set_of(records: Sequence[Record], scenario: BodyScenario, nominal: Body) -> DataSet:
    """Return the runs to fit and those to hold out.

    Args:
        records: measured.
        scenario: the gyro's noise where neither a record states it nor its samples tell it.
        nominal: geometry of the units, and the inertia that is believed.

    Raises:
        InputError: no record can be used, the runs' channels differ, or they are of another platform or in other units.
    """
    passed = gated(records, scenario, nominal)
    theta, notices = theta_of(nominal.inertia), list(passed.notices)
    usable = _without_spikes(passed, notices)
    stated = all(_states_noise(record) for record, _ in usable)
    level = None if stated else pooled_noise(runs_together(usable, range(len(usable))), theta)
    fit, heldout = by_role([(record, [part.telemetry for part in parts]) for record, parts in usable])

    def of(chosen: Sequence[int]) -> Runs:
        runs = runs_together(usable, chosen)
        return with_telemetry_noise(runs, passed.baseline.theta) if level is None else with_pooled_noise(runs, level)

    return DataSet(
        runs=of(fit),
        heldout=of(heldout) if heldout else None,
        fit_records=tuple(usable[index][0].details.name for index in fit),
        heldout_records=tuple(usable[index][0].details.name for index in heldout),
        notices=(*(f"left out: {reason}" for reason in passed.refused), *grouped(notices)),
    )


def _without_spikes(passed: Gated, notices: list[tuple[str, str]]) -> Usable:
    """Return the parts less the gyro's outliers; of which records, is added to the notices."""
    cleaned = iter(zip(*without_spikes(passed.together, passed.baseline), strict=True))
    kept: Usable = []
    for record, parts in passed.usable:
        own = [next(cleaned) for _ in parts]
        kept.append((record, tuple(replace(part, telemetry=run) for part, (run, _) in zip(parts, own, strict=True))))
        if found := sum(count for _, count in own):
            notices.append((record.details.name, outliers_notice(found)))
    return kept


def _states_noise(record: Record) -> bool:
    return bool(record.details.gyro_noise) or record.details.source == "simulated"


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
