"""The record of one run: its time base and channels, and what is known about the run as a whole."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from testbed.arrays import Array, Series
from testbed.files import FileStamp
from testbed.signals import SIGNALS


@dataclass(frozen=True, kw_only=True)
class RunDetails:
    """What NAME.toml says of a run (docs/reference/records.md); None where it says nothing.

    Attributes:
        name: what a person calls the run.
        source: measured or simulated.
        gyro_noise: standard deviation of the gyro's white noise per sample, rad/s.
        usable_from: first usable time, s.
        usable_to: last usable time, s.
        role: whether a diagnosis may fit the run or holds it out.
        axes: body axes about which the platform can turn in this run, such as z; all that the scenario has where None.
    """

    name: str
    source: Literal["measured", "simulated"] = "measured"
    gyro_noise: float | None = None
    usable_from: float | None = None
    usable_to: float | None = None
    role: Literal["fit", "heldout"] | None = None
    axes: tuple[str, ...] | None = None


@dataclass(frozen=True, kw_only=True, repr=False)
class Record:
    """A run's time series.

    Attributes:
        time: strictly increasing, shape (N,), s.
        channels: by signal name (`testbed.signals.SIGNALS`), shape (N, width); NaN where a channel was not sampled.
            A signal of width 1 has shape (N, 1).
        details: what is known of the run as a whole.
        files: that it was read from; none of a flight that was simulated just now.
        extra_columns: columns that the signal table does not know, by column name, shape (N,), of any type.
    """

    time: Series
    channels: Mapping[str, Array]
    details: RunDetails
    files: tuple[FileStamp, ...] = ()
    extra_columns: Mapping[str, NDArray[Any]] = field(default_factory=dict)

    def __repr__(self) -> str:
        sent = [name for name in self.channels if SIGNALS[name].telemetry]
        known = len(self.channels) - len(sent)
        more = f", and {known} that only a simulation knows" if known else ""
        return f"{self.details.name}: {len(self.time)} rows over {np.ptp(self.time):.3g} s, {', '.join(sent)}{more}"
