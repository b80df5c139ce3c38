"""What of a record can be predicted: its stretches without gaps, averaged down and cut into windows where asked for."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from testbed.assembly.contact import cut_at_contact
from testbed.assembly.estimation import telemetry_of
from testbed.assembly.platform import Body
from testbed.diagnosis.windows import averaged, windows_of, with_actuator_rows
from testbed.dynamics.inertia import PARAMETER_NAMES
from testbed.effects.gyro_saturation import flat_tops
from testbed.errors import InputError
from testbed.estimation.gyro_noise import gyro_noise_of
from testbed.estimation.outliers import gross_outliers
from testbed.estimation.telemetry import BRIDGED_PERIODS, Telemetry, covered_part
from testbed.records.checks import MINIMUM_SAMPLES
from testbed.records.record import Record
from testbed.records.selection import telemetry_only
from testbed.scenario.body import BodyScenario
from testbed.signals import AXES

_BRIDGED = 0.3
"""s. Without an applied torque the whole momentum lasts through a gap; only the attitude by which it turns is less
certain behind it. A gimbal that swings by 0.3 rad at 1 Hz costs 6e-4 rad."""
_BRIDGED_TORQUE = 0.11
"""s. An applied torque is followed at 16 Hz, and so is it over gaps that are hardly longer. Over 0.12 s what changes
between left a jump of 4e-5 N·m·s, which looks like a touch."""
STAND_ALONE = "alone, far from the neighbours: left out"
_STUCK = 0.9
"""Share of an axis's samples at one and the same value, beyond which it shows no motion; noise repeats none."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Part:
    """A stretch of a record without a gap in its actuators' telemetry, or a window of the stretch that it names."""

    name: str
    telemetry: Telemetry
    stretch: str | None = None


def parts_of(record: Record, scenario: BodyScenario, nominal: Body, notices: list[tuple[str, str]]) -> Iterator[Part]:
    """Yield a record's stretches, or their windows.

    Args:
        record: measured.
        scenario: the gyro's noise where neither the record states it nor its samples tell it; the horizon.
        nominal: geometry of the units, and the inertia that is believed.
        notices: of all records, by name; what there is to say of this one is added.

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
    telemetry = _with_noise(record, telemetry_of(measured, scenario, nominal), notices)
    _require_moving_gyro(name, telemetry)
    telemetry = _without_gross_outliers(name, telemetry, notices)
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
            yield Part(name=named, telemetry=stretch)
        else:
            yield from _windows(named, stretch, horizon)


def _windows(name: str, stretch: Telemetry, horizon: float) -> Iterator[Part]:
    try:
        for window in windows_of(stretch, horizon):
            yield Part(name=f"{name} at {window.gyro_time[0]:.2f} s", telemetry=window, stretch=name)
    except InputError as error:
        raise InputError(f"{name}: {error}") from None


def _with_noise(record: Record, telemetry: Telemetry, notices: list[tuple[str, str]]) -> Telemetry:
    """Return the telemetry with a noise that residuals can be divided by.

    Raises:
        InputError: no noise is stated, and the samples do not tell it.
    """
    name, stated = record.details.name, record.details.gyro_noise
    if telemetry.gyro_noise > 0.0 and stated != 0.0:
        return telemetry
    noise = gyro_noise_of(telemetry.gyro_time, telemetry.body_rate)
    if noise is None:
        raise InputError(
            f"{name}: the gyro's noise is stated as zero and its samples do not tell it: state gyro_noise_rad_s in "
            f"{name}.toml"
        )
    notices.append((name, "a gyro noise of zero is stated; what the samples show is used instead"))
    return replace(telemetry, gyro_noise=noise)


def _without_gross_outliers(name: str, telemetry: Telemetry, notices: list[tuple[str, str]]) -> Telemetry:
    (clipped,) = flat_tops([telemetry])
    gone = np.any(gross_outliers(telemetry.body_rate, telemetry.gyro_noise) & ~clipped, axis=1)
    if not gone.any():
        return telemetry
    notices.append((name, outliers_notice(int(gone.sum()))))
    return replace(telemetry, gyro_time=telemetry.gyro_time[~gone], body_rate=telemetry.body_rate[~gone])


def outliers_notice(count: int) -> str:
    """Return what to say of gyro samples that were left out."""
    return f"{count} gyro {'sample stands' if count == 1 else 'samples stand'} {STAND_ALONE}"


def _require_moving_gyro(name: str, telemetry: Telemetry) -> None:
    for number, (axis, rate) in enumerate(zip(AXES, telemetry.body_rate.T, strict=True), start=1):
        values, counts = np.unique(np.abs(rate), return_counts=True)
        if counts.max() > _STUCK * len(rate):
            about = ", ".join(parameter for parameter in PARAMETER_NAMES if str(number) in parameter)
            raise InputError(
                f"{name}: the gyro's {axis} axis reads {values[counts.argmax()]:.4g} rad/s in size "
                f"in {counts.max()} of {len(rate)} samples: it is saturated or dead, so that {about} cannot be "
                "determined; take the run out"
            )


def _without_gaps(telemetry: Telemetry) -> Iterator[Telemetry]:
    """Yield the stretches without a gap of their actuator samples over which no motion can be predicted."""
    interval = np.diff(telemetry.actuator_time)
    usual = float(np.median(interval)) if len(interval) else 0.0
    longest = max(BRIDGED_PERIODS * usual, _BRIDGED if telemetry.applied_torque is None else _BRIDGED_TORQUE)
    behind = np.flatnonzero(interval > longest) + 1
    edges = [0, *behind.astype(int).tolist(), len(telemetry.actuator_time)]
    for first, last in pairwise(edges):
        try:
            stretch = covered_part(with_actuator_rows(telemetry, slice(first, last)))
        except InputError:
            continue
        if len(stretch.gyro_time) >= MINIMUM_SAMPLES:
            yield stretch
