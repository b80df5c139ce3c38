"""From records to the runs of a diagnosis: their roles and their noise; what cannot be used is said."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from testbed.assembly.platform import Body
from testbed.diagnosis.data import Runs, runs_of
from testbed.diagnosis.fitting import fitted
from testbed.diagnosis.model import Fit
from testbed.diagnosis.parts import Part, parts_of
from testbed.diagnosis.plausibility import require_motion_in_si, require_this_platform
from testbed.diagnosis.pooled_noise import pooled_noise, with_pooled_noise
from testbed.diagnosis.roles import by_role
from testbed.diagnosis.spikes import without_spikes
from testbed.diagnosis.telemetry_noise import with_telemetry_noise
from testbed.dynamics.inertia import theta_of
from testbed.errors import InputError
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
    usable: list[tuple[Record, tuple[Part, ...]]] = []
    refused: list[str] = []
    notices: list[tuple[str, str]] = []
    for record in records:
        try:
            usable.append((record, tuple(parts_of(record, scenario, nominal, notices))))
        except InputError as error:
            refused.append(str(error))
    if not usable:
        raise InputError("\n".join(refused))
    theta = theta_of(nominal.inertia)
    together = _together(usable, range(len(usable)))
    require_motion_in_si(together, theta)
    baseline = fitted(together, [], theta, [])
    require_this_platform(together, baseline, theta)
    usable = _without_spikes(usable, together, baseline, notices)
    stated = all(_states_noise(record) for record, _ in usable)
    level = None if stated else pooled_noise(_together(usable, range(len(usable))), theta)
    fit, heldout = by_role([(record, [part.telemetry for part in parts]) for record, parts in usable])

    def of(chosen: Sequence[int]) -> Runs:
        runs = _together(usable, chosen)
        return with_telemetry_noise(runs, baseline.theta) if level is None else with_pooled_noise(runs, level)

    return DataSet(
        runs=of(fit),
        heldout=of(heldout) if heldout else None,
        fit_records=tuple(usable[index][0].details.name for index in fit),
        heldout_records=tuple(usable[index][0].details.name for index in heldout),
        notices=(*(f"left out: {reason}" for reason in refused), *_grouped(notices)),
    )


def _without_spikes(
    usable: list[tuple[Record, tuple[Part, ...]]], together: Runs, fit: Fit, notices: list[tuple[str, str]]
) -> list[tuple[Record, tuple[Part, ...]]]:
    """Return the parts less the gyro's lone wild samples; of which records, is added to the notices."""
    cleaned = iter(zip(*without_spikes(together, fit), strict=True))
    kept = []
    for record, parts in usable:
        own = [next(cleaned) for _ in parts]
        kept.append((record, tuple(replace(part, telemetry=run) for part, (run, _) in zip(parts, own, strict=True))))
        if wild := sum(count for _, count in own):
            samples = "sample stands" if wild == 1 else "samples stand"
            notices.append((record.details.name, f"{wild} gyro {samples} alone, far from the neighbours: left out"))
    return kept


def _states_noise(record: Record) -> bool:
    return bool(record.details.gyro_noise) or record.details.source == "simulated"


def _grouped(notices: Sequence[tuple[str, str]]) -> Iterator[str]:
    """Yield what is said of records, once for all of which the same is said."""
    for said in dict.fromkeys(text for _, text in notices):
        names = [name for name, text in notices if text == said]
        yield f"{', '.join(names)}{', each' if len(names) > 1 else ''}: {said}"


def _together(usable: Sequence[tuple[Record, tuple[Part, ...]]], chosen: Sequence[int]) -> Runs:
    parts = [part for index in chosen for part in usable[index][1]]
    runs = runs_of([part.name for part in parts], [part.telemetry for part in parts])
    return replace(runs, windowed=tuple(part.stretch for part in parts if part.stretch is not None))
