"""Is a record's time in seconds? Its sample period has to be one that the scenario's gyro may have."""

from __future__ import annotations

import numpy as np

from testbed.errors import InputError
from testbed.records.record import Record
from testbed.records.selection import sampled

SLOWER, FASTER = 32.0, 250.0
"""Ratios of a record's sample period to the scenario's that are taken for another unit of time. Milliseconds of the
scenario's own gyro are 1000 times as long, of one ten times as fast still 100 times; telemetry is thinned out by ten
(a gyro of 1 kHz, logged at 100 Hz). The limit stands midway, as factors go.
Minutes are 60 times as short, but so are the samples of a gyro of 1 kHz beside one of 16 Hz. Milliseconds that were
converted twice are 1000 times as short: the limit stands midway between."""
_DIVISORS = {1e3: "ms", 1e6: "us", 1e9: "ns"}
_FACTORS = {
    60.0: "minutes",
    1e3: "thousands of seconds",
    3600.0: "hours",
    86400.0: "days",
    1e6: "millions of seconds",
    1e9: "billions of seconds",
}


def require_time_in_seconds(record: Record, sample_rate: float) -> None:
    """Refuse a time base that cannot be the scenario's.

    Args:
        record: measured or flown.
        sample_rate: of the scenario's gyro, Hz.

    Raises:
        InputError: its gyro samples lie too far apart, or too close; the message names the factor.
    """
    time, _ = sampled(record, "body_rate")
    if len(time) < 2:  # too few, which others say
        return
    period = float(np.median(np.diff(time)))
    ratio = period * sample_rate
    if 1.0 / FASTER < ratio < SLOWER:
        return
    raise InputError(
        f"{record.details.name}: time_s grows by {period:.4g} a gyro sample at the median, {ratio:.3g} times the "
        f"{1.0 / sample_rate:.4g} s of gyro.sample_rate_hz = {sample_rate:g}: {_remedy(ratio)}; if it is in seconds, "
        f"set gyro.sample_rate_hz = {1.0 / period:.3g} in the scenario"
    )


def _remedy(ratio: float) -> str:
    """Return what brings the time to seconds: of the units that it may be in, the one that fits best."""
    units = _DIVISORS if ratio > 1.0 else _FACTORS
    factor = min(units, key=lambda each: abs(np.log(ratio / each if ratio > 1.0 else ratio * each)))
    return f"{'divide' if ratio > 1.0 else 'multiply'} it by {factor:g} if it is in {units[factor]}"
