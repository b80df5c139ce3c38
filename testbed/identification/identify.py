"""Estimate the inertia from measured records: gate, estimate each, test, combine."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from testbed.arrays import Series, Theta
from testbed.assembly.contact import cut_at_contact
from testbed.assembly.platform import Body
from testbed.assembly.telemetry import telemetry_of
from testbed.diagnosis.actuator_telemetry import unknown_between, where_known
from testbed.diagnosis.bridging import bridged_stretches
from testbed.diagnosis.data import Runs
from testbed.diagnosis.reading import TOO_EXACT, gated, sent_as
from testbed.diagnosis.windows import PARTS_USED, STAND_ALONE, outliers_notice
from testbed.dynamics.inertia import PARAMETER_NAMES, theta_of
from testbed.errors import InputError
from testbed.estimation.gaps import GYRO_BRIDGED, between_gaps, gaps
from testbed.estimation.telemetry import Telemetry
from testbed.experiment.combining import combine_estimations
from testbed.experiment.experiment import CombinedEstimation, Estimation
from testbed.experiment.measured import estimate_record
from testbed.records.checks import MINIMUM_SAMPLES
from testbed.records.notices import grouped
from testbed.records.record import Record
from testbed.records.selection import in_parts, part_of, sampled, telemetry_only
from testbed.scenario.body import BodyScenario
from testbed.scenario.diagnosis import Diagnosis

LONGEST_GATED = 120.0
"""s of a record that the gate looks at, where it turns the most: units and platform show in any maneuver, and the gate
predicts 64 instants a second."""
MOST_AT_ONCE = 100_000
"""Gyro samples that are estimated from at once, which takes 0.6 GB; a longer record is taken for several runs."""
_NO_ALIGNMENTS = "estimation.alignments is of flights that `testbed run` flies: none were estimated from it"


@dataclass(frozen=True, kw_only=True)
class Identification:
    """The inertia from measured records.

    Attributes:
        records: that were estimated from, cut where they show a contact, in parts where they are long.
        estimations: of each of them, by its name.
        combined: of all of them.
        notices: what a reader has to know of the records.
        refused: why records were left out.
        torque_drawn: whether an applied torque is drawn from sample to sample, as of one that is not said to be held.
        nominal_theta: inertia that the estimates have to be near, kg·m²; None where the scenario accepts any other.
        records_used: records that gave an estimate, whole or in parts.
    """

    records: tuple[Record, ...]
    estimations: Mapping[str, Estimation]
    combined: CombinedEstimation
    notices: tuple[str, ...]
    refused: tuple[str, ...]
    torque_drawn: bool
    nominal_theta: Theta | None
    records_used: int

    @property
    def what_is_combined(self) -> str:
        """What the combined estimate is of, for people: "3 records", or "4 parts of one record"."""
        used = "one record" if self.records_used == 1 else f"{self.records_used} records"
        parts = len(self.estimations)
        return used if parts == self.records_used else f"{parts} parts of {used}"


def identify(scenario: BodyScenario, nominal: Body, records: Sequence[Record]) -> Identification:
    """Estimate the inertia from every record that allows it, and from all of them together.

    Args:
        scenario: the nominal model and the estimators.
        nominal: its platform.
        records: measured; what only a simulation knows is not looked at.

    Raises:
        InputError: the records cannot be this platform's, or none gives an estimate.
    """
    notices: list[tuple[str, str]] = []
    cut = [_cut(scenario, nominal, telemetry_only(record), notices) for record in records]
    plain = scenario.model_copy(
        update={
            "diagnosis": Diagnosis(accept=scenario.diagnosis.accept, applied_torque=scenario.diagnosis.applied_torque)
        }
    )  # neither averaged nor cut into windows
    passed = gated([_looked_at(record) for record in cut], plain, nominal, at_rest=True)
    _require_free(passed.together)
    if passed.together.grid.torque_held:
        scenario = sent_as(scenario, "held")
    notices += [(record.details.name, _unused(record)) for record in records if record.extra_columns]
    # Outliers are counted below, all of them, parts are those of the estimators, and these compare no torques.
    elsewhere = (STAND_ALONE, PARTS_USED, TOO_EXACT)
    notices += [notice for notice in passed.notices if not any(said in notice[1] for said in elsewhere)]
    if scenario.estimation.alignments:
        notices += [(record.details.name, _NO_ALIGNMENTS) for record in cut]
    estimations: dict[str, Estimation] = {}
    refused = list(passed.refused)
    usable = {record.details.name for record, _ in passed.usable}
    parts: list[Record] = []
    records_used = 0
    for record in (each for each in cut if each.details.name in usable):
        made = list(_estimated(scenario, nominal, record, notices, refused))
        parts += [part for part, _ in made]
        estimations |= {part.details.name: estimation for part, estimation in made}
        records_used += bool(made)
    if not estimations:
        raise InputError("\n".join(refused))
    notices += [(name, text) for name, each in estimations.items() for text in _estimation_notices(each)]
    return Identification(
        records=tuple(parts),
        estimations=estimations,
        combined=combine_estimations(estimations),
        notices=(*grouped(notices), *passed.doubts),
        refused=tuple(refused),
        torque_drawn=_drawn(passed.together.grid.runs[0]),
        nominal_theta=None if "inertia" in scenario.diagnosis.accept else theta_of(nominal.inertia),
        records_used=records_used,
    )


def _drawn(run: Telemetry) -> bool:
    return run.applied_torque is not None and not run.torque_held


def _require_free(runs: Runs) -> None:
    """Refuse rigs that turn about some axes only: the estimators here are for all six parameters.

    Raises:
        InputError: what such runs determine of the inertia is named.
    """
    shown = runs.inertia_shown
    if not runs.live.all():
        names = ", ".join(name for name, yes in zip(PARAMETER_NAMES, shown, strict=True) if yes)
        raise InputError(
            f"the runs turn about some axes only, which shows {names} of the inertia: `testbed diagnose` estimates "
            "what they show and leaves the rest out; an estimate needs runs that turn freely"
        )


def _cut(scenario: BodyScenario, nominal: Body, record: Record, notices: list[tuple[str, str]]) -> Record:
    """Cut a record at the first contact that it shows, where the scenario asks for it."""
    if not scenario.estimation.cut_at_contact:
        return record
    try:
        cut, contact = cut_at_contact(record, scenario, nominal)
    except InputError:  # its own message follows when it is estimated from
        return record
    if contact is not None:
        place = f"contact found at {contact.first_seen:.3f} s, the body rate jumps by {contact.rate_jump:.2g} rad/s"
        notices.append((record.details.name, f"{place}; record cut at {contact.last_free:.3f} s"))
    return cut


def _estimated(
    scenario: BodyScenario, nominal: Body, record: Record, notices: list[tuple[str, str]], refused: list[str]
) -> Iterator[tuple[Record, Estimation]]:
    """Yield the parts of a record with their estimates: whole ones where a momentum of zero lasts through its gaps.

    Args:
        scenario: as of `identify`.
        nominal: its platform.
        record: measured.
        notices: of all records, by name; that this one is cut is added.
        refused: why nothing can be estimated from a part is added.
    """
    try:
        pieces = uninterrupted_parts(record, scenario, nominal)
    except InputError as error:
        refused.append(str(error))
        return
    is_cut = not any(piece is record for piece in pieces)
    if is_cut and _lasts_through_gaps(scenario, record):
        noticed: list[tuple[str, str]] = []
        left_out: list[str] = []
        whole = list(_of_parts(scenario, nominal, in_parts(record, MOST_AT_ONCE), noticed, left_out))
        if all(estimation.initial_momentum != "estimated" for _, estimation in whole):
            notices += noticed
            refused += left_out
            yield from whole
            return
    if is_cut and pieces:
        notices.append((record.details.name, _GAPS if len(pieces) > 1 else _ONE_PART))
    if not pieces:
        refused.append(f"{record.details.name}: no {MINIMUM_SAMPLES} gyro samples lie between two gaps")
    parts = (part for piece in pieces for part in in_parts(piece, MOST_AT_ONCE))
    yield from _of_parts(scenario, nominal, parts, notices, refused)


_GAPS = "its telemetry has gaps: the parts between them are estimated by themselves, with a momentum of each"
_ONE_PART = "its telemetry has gaps: one part is used; where gravity acts, nothing says how it stood behind a gap"


def _lasts_through_gaps(scenario: BodyScenario, record: Record) -> bool:
    """Return whether the total momentum is stated to be zero, and nothing changes it."""
    driven = not record.channels.keys().isdisjoint({"applied_torque", "motor_thrust"})
    return scenario.estimation.initial_momentum == "zero" and scenario.environment.kind == "free" and not driven


def _of_parts(
    scenario: BodyScenario,
    nominal: Body,
    parts: Iterable[Record],
    notices: list[tuple[str, str]],
    refused: list[str],
) -> Iterator[tuple[Record, Estimation]]:
    for part in parts:
        try:
            estimation = estimate_record(scenario, nominal, _where_known(scenario, nominal, part, notices))
        except InputError as error:
            refused.append(str(error))
            continue
        yield part, estimation


def _where_known(scenario: BodyScenario, nominal: Body, record: Record, notices: list[tuple[str, str]]) -> Record:
    """Return a record without those gyro samples of which actuators that are slow do not show how the body turned.

    Args:
        scenario: as of `identify`.
        nominal: its platform.
        record: measured.
        notices: of all records, by name; how many samples are left out is added.

    Raises:
        InputError: the record lacks what the estimators need.
    """
    telemetry = telemetry_of(record, scenario, nominal)
    (known,) = where_known([telemetry], theta_of(nominal.inertia))
    if known is telemetry:
        return record
    every = len(telemetry.gyro_time)
    notices.append((record.details.name, unknown_between(every - len(known.gyro_time), every)))
    body_rate = np.where(np.isin(record.time, known.gyro_time)[:, None], record.channels["body_rate"], np.nan)
    return replace(record, channels={**record.channels, "body_rate": body_rate})


def uninterrupted_parts(record: Record, scenario: BodyScenario, nominal: Body) -> list[Record]:
    """Return a record in parts between gaps in which the platform turned by what nobody knows.

    The total momentum lasts through a gap, but not its direction in the body; under an applied torque neither does it.
    Where gravity acts and the attitude is that of the gyro's integral, what follows a gap is left out.

    Args:
        record: measured.
        scenario: as of `identify`.
        nominal: its platform.

    Raises:
        InputError: the record lacks what the estimators need.
    """
    telemetry = telemetry_of(record, scenario, nominal)
    driven = bridged_stretches(telemetry, nominal.turned_inertia)
    seen = between_gaps(gaps(telemetry.gyro_time, shortest=GYRO_BRIDGED))
    spans = [
        (max(first, start), min(last, end))
        for first, last in _spans(telemetry.actuator_time, driven)
        for start, end in _spans(telemetry.gyro_time, seen)
        if max(first, start) < min(last, end)
    ]
    if len(spans) <= 1:
        return [record]
    around = telemetry.surroundings
    oriented = around is None or around.measured
    return [
        part_of(record, number, first, last)
        for number, (first, last) in enumerate(spans if oriented else spans[:1], start=1)
        if np.count_nonzero((telemetry.gyro_time >= first) & (telemetry.gyro_time <= last)) >= MINIMUM_SAMPLES
    ]


def _spans(time: Series, stretches: Sequence[slice]) -> list[tuple[float, float]]:
    return [(float(time[rows.start]), float(time[rows.stop - 1])) for rows in stretches]


def _looked_at(record: Record) -> Record:
    """Return a record that is used only where it turns the most, if it is long; all of it otherwise."""
    time, body_rate = sampled(record, "body_rate")
    first = time[0] if record.details.usable_from is None else max(record.details.usable_from, time[0])
    last = time[-1] if record.details.usable_to is None else min(record.details.usable_to, time[-1])
    if last - first <= LONGEST_GATED:
        return record
    edges = np.arange(first, last, LONGEST_GATED)
    power = [float(body_rate[(time >= edge) & (time < edge + LONGEST_GATED)].var(axis=0).sum()) for edge in edges[:-1]]
    start = float(edges[int(np.argmax(power))])
    return replace(record, details=replace(record.details, usable_from=start, usable_to=start + LONGEST_GATED))


def _unused(record: Record) -> str:
    return f"kept, but not used: {', '.join(record.extra_columns)}"


def _estimation_notices(estimation: Estimation) -> Iterator[str]:
    if estimation.outliers:
        yield outliers_notice(estimation.outliers)
    chance = estimation.zero_momentum_p_value
    if estimation.initial_momentum == "estimated" and chance is not None:
        said = f"p = {chance:.2g}" if chance > 0.0 else "p < 1e-300"
        yield (
            f'the scenario says initial_momentum = "zero", which this record refuses ({said}): the momentum was '
            "estimated jointly"
        )
