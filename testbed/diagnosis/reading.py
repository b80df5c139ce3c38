"""From records to the runs of a diagnosis: their roles, their gaps, their noise; what cannot be used is said."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields, replace
from itertools import pairwise
from typing import Any

import numpy as np

from testbed.arrays import Theta
from testbed.assembly.contact import cut_at_contact
from testbed.assembly.estimation import telemetry_of
from testbed.assembly.platform import Body
from testbed.diagnosis.data import Runs, runs_of
from testbed.diagnosis.fitting import fitted
from testbed.diagnosis.model import Fit
from testbed.diagnosis.noise import readings_of
from testbed.diagnosis.plausibility import require_this_platform
from testbed.diagnosis.roles import by_role
from testbed.diagnosis.spikes import without_spikes
from testbed.diagnosis.telemetry_noise import with_telemetry_noise
from testbed.diagnosis.windows import averaged, windows_of
from testbed.dynamics.inertia import theta_of
from testbed.effects.fast_changes import variance_ratio
from testbed.errors import InputError
from testbed.estimation.gyro_noise import gyro_noise_of
from testbed.estimation.telemetry import BRIDGED_PERIODS, Telemetry, covered_part
from testbed.records.checks import MINIMUM_SAMPLES
from testbed.records.record import Record
from testbed.records.selection import telemetry_only
from testbed.scenario.body import BodyScenario
from testbed.signals import AXES

_BRIDGED = 0.3
"""s. Without an applied torque the whole momentum lasts through a gap; only the attitude by which it turns is less
certain behind it. A gimbal that swings by 0.3 rad at 1 Hz costs 6e-4 rad."""
_STUCK = 0.9
"""Share of an axis's samples at one and the same value, beyond which it shows no motion; noise repeats none."""


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


@dataclass(frozen=True, kw_only=True, eq=False)
class _Part:
    """A stretch of a record without a gap in its actuators' telemetry, or a window of the stretch that it names."""

    name: str
    telemetry: Telemetry
    stretch: str | None = None


def data_set_of(records: Sequence[Record], scenario: BodyScenario, nominal: Body) -> DataSet:
    """Return the runs to fit and those to hold out.

    Args:
        records: measured.
        scenario: the gyro's noise where neither a record states it nor its samples tell it.
        nominal: geometry of the units, and the inertia that is believed.

    Raises:
        InputError: no record can be used, the runs' channels differ, or they are of another platform or in other units.
    """
    usable: list[tuple[Record, tuple[_Part, ...]]] = []
    refused: list[str] = []
    notices: list[tuple[str, str]] = []
    for record in records:
        try:
            usable.append((record, tuple(_parts(record, scenario, nominal, notices))))
        except InputError as error:
            refused.append(str(error))
    if not usable:
        raise InputError("\n".join(refused))
    theta = theta_of(nominal.inertia)
    together = _together(usable, range(len(usable)))
    require_this_platform(together, theta)
    baseline = fitted(together, [], theta, [])
    usable = _without_spikes(usable, together, baseline, notices)
    stated = all(_states_noise(record) for record, _ in usable)
    level = None if stated else _noise_of_all(usable, theta)
    fit, heldout = by_role([(record, [part.telemetry for part in parts]) for record, parts in usable])

    def of(chosen: Sequence[int]) -> Runs:
        runs = _together(usable, chosen)
        return with_telemetry_noise(runs, baseline.theta) if level is None else _believed(runs, level)

    return DataSet(
        runs=of(fit),
        heldout=of(heldout) if heldout else None,
        fit_records=tuple(usable[index][0].details.name for index in fit),
        heldout_records=tuple(usable[index][0].details.name for index in heldout),
        notices=(*(f"left out: {reason}" for reason in refused), *_grouped(notices)),
    )


def _without_spikes(
    usable: list[tuple[Record, tuple[_Part, ...]]], together: Runs, fit: Fit, notices: list[tuple[str, str]]
) -> list[tuple[Record, tuple[_Part, ...]]]:
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


def _noise_of_all(usable: Sequence[tuple[Record, tuple[_Part, ...]]], theta: Theta) -> tuple[float, float] | None:
    """Return the noise that the samples of all runs tell together, rad/s, and its degrees of freedom.

    None where they are too few.
    """
    runs = _together(usable, range(len(usable)))
    runs = runs.with_sigma(np.sqrt(np.mean(runs.sigma**2, axis=0)))
    ratio, freedom = variance_ratio(readings_of(runs, fitted(runs, [], theta, [])), np.ones(3, dtype=bool))
    return (float(np.sqrt(ratio * np.mean(runs.sigma**2))), freedom) if freedom > 0.0 else None


def _believed(runs: Runs, level: tuple[float, float]) -> Runs:
    """Return the runs with the noise that their samples tell; that of the actuators' telemetry is in it."""
    noise, freedom = level
    return replace(runs.with_sigma(np.full(3, noise)), noise_freedom=freedom)


def _grouped(notices: Sequence[tuple[str, str]]) -> Iterator[str]:
    """Yield what is said of records, once for all of which the same is said."""
    for said in dict.fromkeys(text for _, text in notices):
        yield f"{', '.join(name for name, text in notices if text == said)}: {said}"


def _parts(record: Record, scenario: BodyScenario, nominal: Body, notices: list[tuple[str, str]]) -> Iterator[_Part]:
    """Yield a record's stretches; what there is to say of it is added to the notices.

    Raises:
        InputError: the record cannot be used.
    """
    name = record.details.name
    if record.extra_columns:
        notices.append((name, f"kept, but not used: {', '.join(record.extra_columns)}"))
    measured = telemetry_only(record)
    if scenario.estimation.cut_at_contact:
        measured, contact = cut_at_contact(measured, scenario, nominal)
        if contact is not None:
            notices.append((name, f"cut at {contact.last_free:.3f} s, where it shows a contact"))
    telemetry = _with_noise(name, telemetry_of(measured, scenario, nominal), notices)
    _require_moving_gyro(name, telemetry)
    if scenario.diagnosis.sample_rate_hz is not None:
        telemetry = averaged(telemetry, scenario.diagnosis.sample_rate_hz)
    stretches = list(_without_gaps(telemetry))
    if not stretches:
        raise InputError(
            f"{name}: no {MINIMUM_SAMPLES} gyro samples lie between two gaps of the actuators' "
            "telemetry: give a longer or a more complete record"
        )
    if len(stretches) > 1:
        notices.append((name, f"its actuators' telemetry has gaps; {len(stretches)} parts are used"))
    horizon = scenario.diagnosis.horizon_s
    for number, stretch in enumerate(stretches, start=1):
        named = name if len(stretches) == 1 else f"{name} part {number}"
        if horizon is None:
            yield _Part(name=named, telemetry=stretch)
        else:
            yield from _windows(named, stretch, horizon)


def _windows(name: str, stretch: Telemetry, horizon: float) -> Iterator[_Part]:
    try:
        for window in windows_of(stretch, horizon):
            yield _Part(name=f"{name} at {window.gyro_time[0]:.2f} s", telemetry=window, stretch=name)
    except InputError as error:
        raise InputError(f"{name}: {error}") from None


def _with_noise(name: str, telemetry: Telemetry, notices: list[tuple[str, str]]) -> Telemetry:
    """Return the telemetry with a noise that residuals can be divided by.

    Raises:
        InputError: no noise is stated, and the samples do not tell it.
    """
    if telemetry.gyro_noise > 0.0:
        return telemetry
    noise = gyro_noise_of(telemetry.gyro_time, telemetry.body_rate)
    if noise is None:
        raise InputError(
            f"{name}: the gyro's noise is stated as zero and its samples do not tell it: state gyro_noise_rad_s in "
            f"{name}.toml"
        )
    notices.append((name, "a gyro noise of zero is stated; what the samples show is used instead"))
    return replace(telemetry, gyro_noise=noise)


def _require_moving_gyro(name: str, telemetry: Telemetry) -> None:
    for axis, rate in zip(AXES, telemetry.body_rate.T, strict=True):
        values, counts = np.unique(np.abs(rate), return_counts=True)
        if counts.max() > _STUCK * len(rate):
            raise InputError(
                f"{name}: the gyro's {axis} axis reads {values[counts.argmax()]:.4g} rad/s in size "
                f"in {counts.max()} of {len(rate)} samples: it is saturated or dead; take the run out"
            )


def _without_gaps(telemetry: Telemetry) -> Iterator[Telemetry]:
    """Yield the stretches without a gap of their actuator samples over which no motion can be predicted."""
    interval = np.diff(telemetry.actuator_time)
    longest = BRIDGED_PERIODS * float(np.median(interval)) if len(interval) else 0.0
    if telemetry.applied_torque is None:
        longest = max(longest, _BRIDGED)
    behind = np.flatnonzero(interval > longest) + 1
    edges = [0, *behind.astype(int).tolist(), len(telemetry.actuator_time)]
    for first, last in pairwise(edges):
        try:
            stretch = covered_part(_rows(telemetry, slice(first, last)))
        except InputError:
            continue
        if len(stretch.gyro_time) >= MINIMUM_SAMPLES:
            yield stretch


def _rows(telemetry: Telemetry, rows: slice) -> Telemetry:
    """Return the telemetry with some of its actuator samples."""
    of_actuators = {field.name for field in fields(telemetry)} - {"gyro_time", "body_rate"}
    values = {name: getattr(telemetry, name) for name in of_actuators}
    kept: dict[str, Any] = {name: each[rows] for name, each in values.items() if isinstance(each, np.ndarray)}
    return replace(telemetry, **kept)


def _together(usable: Sequence[tuple[Record, tuple[_Part, ...]]], chosen: Sequence[int]) -> Runs:
    parts = [part for index in chosen for part in usable[index][1]]
    runs = runs_of([part.name for part in parts], [part.telemetry for part in parts])
    return replace(runs, windowed=tuple(part.stretch for part in parts if part.stretch is not None))
