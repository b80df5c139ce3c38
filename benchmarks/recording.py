"""Recording in columns against recording row by row: 200,000 scalars into a file, as `testbed.recording` does it.

Run with `python -m benchmarks.recording`.
"""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
import rerun as rr

from benchmarks.paired import paired, seconds
from benchmarks.ratios import Ratio

SCALARS, PAIRS = 200_000, 3
ENTITY = "body_rate/x"


def ratios() -> list[Ratio]:
    """Return the row: the same scalars under one entity, written to a recording file either way."""
    times = np.arange(SCALARS) / 16.0
    values = np.sin(times)
    took = paired(
        lambda: seconds(lambda: in_columns(times, values)), lambda: seconds(lambda: in_rows(times, values)), PAIRS
    )
    return [
        Ratio(
            what=f"recording {SCALARS:,} scalars in columns against row by row",
            ours=f"{took.ours:.3f} s",
            theirs=f"rr.log {took.theirs:.2f} s",
            ratio=took.ratio,
            target="",
            command="python -m benchmarks.recording",
            note=f"both flushed to a file, median of {PAIRS} pairs",
        )
    ]


def in_columns(times: np.ndarray, values: np.ndarray) -> None:
    """Send all scalars at once."""
    with tempfile.TemporaryDirectory() as folder:
        stream = _stream(Path(folder))
        stream.send_columns(ENTITY, [rr.TimeColumn("time", duration=times)], rr.Scalars.columns(scalars=values))
        stream.disconnect()


def in_rows(times: np.ndarray, values: np.ndarray) -> None:
    """Log the scalars one after the other, as a loop would."""
    with tempfile.TemporaryDirectory() as folder:
        stream = _stream(Path(folder))
        for time, value in zip(times, values, strict=True):
            stream.set_time("time", duration=time)
            stream.log(ENTITY, rr.Scalars(value))
        stream.disconnect()


def _stream(folder: Path) -> rr.RecordingStream:
    stream = rr.RecordingStream("benchmark")
    stream.save(folder / "benchmark.rrd")
    return stream


if __name__ == "__main__":
    for row in ratios():
        print(row)
