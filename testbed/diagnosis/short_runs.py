"""Where a search begins for an effect that moves the platform too far for a linearisation to lead there.

Over a run of half a minute the centre of mass of a table that is off by 70 micrometres turns it upside down: along the
motion that is predicted without it, its derivatives are those of another motion. Over a sixteenth of the run it has
turned the platform by a 256th of that, and what fits there, each part with an initial rate of its own, is near what
fits the whole. The simplest form of multiple shooting.

Source: Bock, "Recent advances in parameter identification techniques for ODE", Numerical Treatment of Inverse Problems
in Differential and Integral Equations (1983).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from testbed.arrays import Array, Theta
from testbed.diagnosis.data import Runs, chosen
from testbed.diagnosis.descent import ROUGHLY
from testbed.diagnosis.fitting import fitted
from testbed.diagnosis.model import Fit, Hypothesis
from testbed.errors import InputError
from testbed.estimation.telemetry import Telemetry
from testbed.records.checks import MINIMUM_SAMPLES

_PARTS = 16
"""Into which a run is cut at most; each has as many samples as a record needs.

Source: chosen; a constant torque that turns a platform by half a revolution in a run turns it by a degree in a part."""


def start_of_short_runs(
    runs: Runs, fit: Fit, placed: Sequence[Hypothesis], starts: Sequence[Array]
) -> tuple[Theta, list[Array]] | None:
    """Return inertia and effects that fit the parts of runs; None where runs have none, or nothing fits them.

    Args:
        runs: to fit as a whole.
        fit: of the model without the newest effect.
        placed: all effects.
        starts: of their parameters, shapes (K,).
    """
    short = _short(runs, placed)
    if short is None:
        return None
    try:
        found = fitted(short, placed, fit.theta, starts, enough=ROUGHLY)
    except (InputError, np.linalg.LinAlgError):  # the motion runs away even so
        return None
    return found.theta, [value[0] for value in found.values.effects]


def _short(runs: Runs, placed: Sequence[Hypothesis]) -> Runs | None:
    """Return the parts of runs side by side, as the gyro has them; None where a part would be no run."""
    if runs.windowed or (runs.grid.runs[0].surroundings is None and any(each.hooks.needs_attitude for each in placed)):
        return None  # these are short already, or of parts it is not known how they are turned to one another
    parts = [(number, part) for number, run in enumerate(runs.grid.runs) for part in _parts(run)]
    if len(parts) <= len(runs.names):
        return None
    return chosen(runs, *zip(*parts, strict=True))  # parts of one run share its name, and with it its trim


def _parts(run: Telemetry) -> Iterator[Telemetry]:
    count = min(_PARTS, len(run.gyro_time) // MINIMUM_SAMPLES)
    for rows in np.array_split(np.arange(len(run.gyro_time)), max(count, 1)):
        first, last = run.gyro_time[rows[0]], run.gyro_time[rows[-1]]
        begin = max(int(np.searchsorted(run.actuator_time, first, side="right")) - 1, 0)
        end = int(np.searchsorted(run.actuator_time, last)) + 1
        yield run.with_actuator_rows(slice(begin, end)).with_gyro_rows(slice(rows[0], rows[-1] + 1))
