"""Long runs cut into windows, and what telemetry gives of each part of a record.

Runs are averaged down to the rate that the motion needs, and cut into windows. A body whose torques are known in part
runs away from any prediction, however good its model: after some seconds the error is as large as the motion, and says
nothing. Over a short window it has not grown yet.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from math import sqrt
from typing import NamedTuple

import numpy as np
import scipy
from numpy.typing import NDArray

from testbed.arrays import Array, Flags, Series
from testbed.assembly.contact import cut_at_contact
from testbed.assembly.platform import Body
from testbed.assembly.telemetry import axes_key, telemetry_of
from testbed.diagnosis.bridging import bridged_stretches
from testbed.diagnosis.settings import SETTINGS
from testbed.dynamics.inertia import PARAMETER_NAMES
from testbed.effects.gyro_saturation import flat_tops
from testbed.errors import InputError
from testbed.estimation.gyro_noise import gyro_noise_of
from testbed.estimation.outliers import BY_CHANCE, gross_outliers
from testbed.estimation.telemetry import Telemetry, covered_part
from testbed.records.checks import MINIMUM_SAMPLES
from testbed.records.record import Record
from testbed.records.selection import telemetry_only, usable
from testbed.scenario.body import BodyScenario
from testbed.signals import AXES

_FULL = 0.5
"""Share of the usual number of samples that an average has to be of: with half, its noise is √2 times what is stated,
and beside a gap nothing is averaged over more than half a period that was not seen."""


def averaged(telemetry: Telemetry, rate: float) -> Telemetry:
    """Return telemetry whose samples are means over 1 / rate, and of the times over which they were taken.

    Args:
        telemetry: of one run.
        rate: Hz; samples that come more slowly, or hardly faster, are left as they are.
    """
    gyro, actuators = (_bins(time, rate) for time in (telemetry.gyro_time, telemetry.actuator_time))
    return replace(
        telemetry.with_actuator_samples(actuators.mean(telemetry.actuator_time), actuators.mean),
        gyro_time=gyro.mean(telemetry.gyro_time),
        body_rate=gyro.mean(telemetry.body_rate),
        gyro_noise=telemetry.gyro_noise / sqrt(gyro.usual),
    )


def windows_of(telemetry: Telemetry, horizon: float) -> list[Telemetry]:
    """Return windows that follow one another, each with what the actuators did a horizon before its first sample.

    Args:
        telemetry: of a run that is not cut.
        horizon: length of a window, s.

    Raises:
        InputError: the run is shorter than two windows, or every window holds too few samples.
    """
    start, end = telemetry.gyro_time[[0, -1]]
    period = float(np.median(np.diff(telemetry.gyro_time)))
    count = int((end + period - start) / horizon)
    if count < 2 or horizon < MINIMUM_SAMPLES * period:
        raise InputError(
            f"{end - start:.3g} s at {1.0 / period:.3g} Hz cannot be cut into windows of {horizon} s of "
            f"{MINIMUM_SAMPLES} samples and a first one for their initial states: change diagnosis.horizon_s"
        )
    begins = start + horizon * np.arange(1, count)
    windows = [_between(telemetry, first, first + horizon) for first in begins]
    full = [window for window in windows if len(window.gyro_time) >= MINIMUM_SAMPLES]  # fewer where the gyro has a gap
    if not full:
        raise InputError(
            f"no {horizon} s of it hold {MINIMUM_SAMPLES} gyro samples: give a more complete record, or change "
            "diagnosis.horizon_s"
        )
    return full


def _between(telemetry: Telemetry, first: float, last: float) -> Telemetry:
    """Return the gyro samples between two times, and the actuators' from as long before to one sample after."""
    own = (telemetry.gyro_time >= first) & (telemetry.gyro_time < last)
    begin = max(int(np.searchsorted(telemetry.actuator_time, 2.0 * first - last)) - 1, 0)
    rows = slice(begin, int(np.searchsorted(telemetry.actuator_time, last)) + 1)
    return telemetry.with_actuator_rows(rows).with_gyro_rows(own)


class _Bins(NamedTuple):
    """Samples that are averaged together: the first of each bin, which bins are full, and what a sample counts there.

    Attributes:
        first: shape (B,).
        full: shape (B,).
        shares: shape (F,), of the full ones.
        usual: number of samples in a bin.
    """

    first: NDArray[np.intp]
    full: Flags
    shares: Array
    usual: float

    def mean(self, samples: Array) -> Array:
        """Return the means of a channel's samples, shape (N,) or (N, C), in the full bins, shape (F,) or (F, C)."""
        sums = np.add.reduceat(samples, self.first, axis=0)[self.full]
        return np.asarray((sums.T * self.shares).T)


_HARDLY_FASTER = 1.0 / 1.5
"""Periods of the means from one sample to the next, up to which samples are averaged: of those as slow as the means,
stamps that come a little early leave some means without any, which would be gaps."""


def _bins(time: Series, rate: float) -> _Bins:
    is_faster = float(np.median(np.diff(time))) * rate < _HARDLY_FASTER
    number = np.floor((time - time[0]) * rate).astype(np.intp) if is_faster else np.arange(len(time))
    first = np.flatnonzero(np.diff(number, prepend=-1))
    counts = np.diff(np.append(first, len(time)))
    usual = float(np.median(counts))
    full = counts >= _FULL * usual
    return _Bins(first, full, 1.0 / counts[full], usual)


PARTS_USED = "parts are used"
"""How a notice on gaps ends; an estimate cuts records by a rule of its own."""
STAND_ALONE = "alone, far from the neighbours: left out"


@dataclass(frozen=True, kw_only=True, eq=False)
class Part:
    """A stretch of a record without a gap that cuts it, or a window of the stretch that it names."""

    name: str
    telemetry: Telemetry
    stretch: str | None = None


def parts_of(record: Record, scenario: BodyScenario, nominal: Body, notices: list[tuple[str, str]]) -> Iterator[Part]:
    """Yield a record's stretches, or their windows.

    Args:
        record: measured.
        scenario: the gyro's noise where neither the record states it nor its samples tell it; the horizon.
        nominal: geometry of the units, and the nominal inertia.
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
    if "stuck" not in scenario.diagnosis.accept:
        _require_moving_gyro(name, telemetry)
    notices.extend((name, notice) for notice in (*_coverage_notices(measured, telemetry), *attitude_notices(telemetry)))
    telemetry = _without_gross_outliers(name, telemetry, notices)
    if scenario.diagnosis.sample_rate_hz is not None:
        telemetry = averaged(telemetry, scenario.diagnosis.sample_rate_hz)
    stretches = list(_without_gaps(telemetry, nominal))
    if not stretches:
        raise InputError(
            f"{name}: no {MINIMUM_SAMPLES} gyro samples lie between two gaps of the actuators' "
            "telemetry: give a longer or a more complete record"
        )
    if len(stretches) > 1:
        notices.append((name, f"its actuators' telemetry has gaps; {len(stretches)} {PARTS_USED}"))
    horizon = scenario.diagnosis.horizon_s
    many = len(stretches) > 1
    parts = [
        Part(name=f"{name} part {number}" if many else name, telemetry=stretch)
        for number, stretch in enumerate(stretches, start=1)
    ]
    yield from parts if horizon is None else _windows(name, parts, horizon)


def _windows(name: str, stretches: Sequence[Part], horizon: float) -> list[Part]:
    """Return the windows of stretches; one that is too short for any has none.

    Raises:
        InputError: not one of the stretches has a window.
    """
    found: list[Part] = []
    refused = ""
    for part in stretches:
        try:
            windows = windows_of(part.telemetry, horizon)
        except InputError as error:
            refused = str(error)
            continue
        found += [
            Part(name=f"{part.name} at {each.gyro_time[0]:.2f} s", telemetry=each, stretch=part.name)
            for each in windows
        ]
    if not found:
        raise InputError(f"{name}: {refused}")
    return found


def _with_noise(record: Record, telemetry: Telemetry, notices: list[tuple[str, str]]) -> Telemetry:
    """Return the telemetry with a noise that residuals can be divided by.

    Raises:
        InputError: no noise is stated, and the samples do not tell it.
    """
    name, stated = record.details.name, record.details.gyro_noise
    if telemetry.gyro_noise > 0.0 and stated != 0.0:
        return telemetry
    noise = gyro_noise_of(telemetry.gyro_time, telemetry.body_rate[:, np.array(telemetry.live)])
    if noise is None:
        raise InputError(
            f"{name}: the gyro's noise is stated as zero and cannot be estimated from its samples: state "
            f"gyro_noise_rad_s in {name}.toml"
        )
    notices.append((name, "a gyro noise of zero is stated; what the samples show is used instead"))
    return replace(telemetry, gyro_noise=noise)


def _without_gross_outliers(name: str, telemetry: Telemetry, notices: list[tuple[str, str]]) -> Telemetry:
    (clipped,) = flat_tops([telemetry])
    gone = np.any(gross_outliers(telemetry.body_rate, telemetry.gyro_noise) & ~clipped, axis=1)
    if not gone.any():
        return telemetry
    notices.append((name, outliers_notice(int(gone.sum()))))
    return telemetry.with_gyro_rows(~gone)


_RARELY = 0.01
"""Chance of more samples beyond the noise from which on they are no more than noise makes.

Source: convention."""


def outliers_notice(count: int, samples: int = 0) -> str:
    """Return what to say of gyro samples that were left out.

    Args:
        count: of these.
        samples: of all, if such a share of them may lie so by noise alone.
    """
    said = f"{count} gyro {'sample stands' if count == 1 else 'samples stand'} {STAND_ALONE}"
    by_noise = float(scipy.stats.poisson.sf(count - 1, BY_CHANCE * samples)) > _RARELY
    return f"{said}, as noise alone makes of so many" if by_noise else said


_COVERED = 0.8
"""Share of a record's length from which on it needs no word that gyro or actuators begin later or end earlier.

Source: chosen; a maneuver's telemetry may be sent a little longer or shorter than its gyro's."""


def _coverage_notices(measured: Record, telemetry: Telemetry) -> Iterator[str]:
    """Yield what to say of a record whose gyro or actuators are silent through most of it, as after a dropout."""
    whole = float(np.ptp(usable(measured).time))
    covered = float(min(telemetry.gyro_time[-1], telemetry.actuator_time[-1]))
    covered -= float(max(telemetry.gyro_time[0], telemetry.actuator_time[0]))
    if covered < _COVERED * whole:
        yield f"gyro and actuators both have samples in {covered:.3g} s of its {whole:.3g} s: only these are used"


def attitude_notices(telemetry: Telemetry) -> Iterator[str]:
    """Yield what to say of a sensor of the attitude that is late, or wrong at times."""
    known = telemetry.surroundings
    if known is not None and known.left_out:
        wrong = "sample of the attitude is" if known.left_out == 1 else "samples of the attitude are"
        yield f"{known.left_out} {wrong} far from those beside it, and not used"
    if known is not None and known.lag:
        side = "later" if known.lag > 0.0 else "earlier"
        yield f"the attitude is sampled {1e3 * abs(known.lag):.2g} ms {side} than the gyro: compared so"


def _require_moving_gyro(name: str, telemetry: Telemetry) -> None:
    axes = zip(AXES, telemetry.body_rate.T, telemetry.live, strict=True)
    for number, (axis, rate, live) in enumerate(axes, start=1):
        if not live:
            continue
        values, counts = np.unique(np.abs(rate), return_counts=True)
        if counts.max() > SETTINGS.stuck_share * len(rate):
            about = ", ".join(parameter for parameter in PARAMETER_NAMES if str(number) in parameter)
            others = np.array([other != axis for other in AXES])
            raise InputError(
                f"{name}: the gyro's {axis} axis reads {values[counts.argmax()]:.4g} rad/s in size "
                f"in {counts.max()} of {len(rate)} samples: it is saturated or dead, so that {about} cannot be "
                f"determined; take the run out, or, if the rig does not turn about {axis}, say so: "
                f"{axes_key(others)} in [platform] of the scenario; if the samples are right as they are, add "
                '"stuck" to accept in [diagnosis]'
            )


def _without_gaps(telemetry: Telemetry, nominal: Body) -> Iterator[Telemetry]:
    """Yield the stretches without a gap of their actuator samples over which no motion can be predicted."""
    for rows in bridged_stretches(telemetry, nominal.turned_inertia):
        try:
            stretch = covered_part(telemetry.with_actuator_rows(rows))
        except InputError:
            continue
        if len(stretch.gyro_time) >= MINIMUM_SAMPLES:
            yield stretch
