"""Import of ten minutes at 200 Hz: `python -m benchmarks.logs`, against the formats' own libraries in a plain loop.

A gyro at 200 Hz and torques at 50 Hz, 150,000 messages. The import reads, decodes, hashes, converts, sorts and checks;
the loop reads and decodes the same two topics and keeps the numbers.
"""

from __future__ import annotations

import json
import resource
import tempfile
import time
from collections.abc import Callable
from operator import attrgetter
from pathlib import Path
from typing import Any

import mcap.reader
import mcap_ros2.decoder
import numpy as np
import pyulog

import testbed as tb
from benchmarks.paired import paired, seconds
from benchmarks.ratios import Ratio
from support import logs

ROWS, PAIRS = 120_000, 3
LIMIT = 5.0
"""s; target of each import."""


def ratios() -> list[Ratio]:
    """Return a row for each format."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        return [
            _ratio("ULog", "pyulog", logs.write_ulog(folder / "a.ulg", ROWS), logs.ULOG_MAP, _by_pyulog),
            _ratio("MCAP, JSON", "mcap", logs.write_json_mcap(folder / "j.mcap", ROWS), logs.JSON_MAP, _by_mcap_json),
            _ratio(
                "MCAP, ROS 2",
                "mcap-ros2-support",
                logs.write_ros_mcap(folder / "r.mcap", ROWS),
                logs.ROS_MAP,
                _by_mcap_ros,
            ),
        ]


def _ratio(kind: str, library: str, path: Path, keys: dict[str, Any], theirs: Callable[[Path], object]) -> Ratio:
    took = paired(lambda: seconds(lambda: tb.import_log(path, keys)), lambda: seconds(lambda: theirs(path)), PAIRS)
    began = time.process_time()
    tb.import_log(path, keys)
    processor = time.process_time() - began
    return Ratio(
        what=f"import of ten minutes at 200 Hz, {kind}",
        ours=f"{took.ours:.2f} s, {processor:.2f} s of processor time",
        theirs=f"{library} in a loop {took.theirs:.2f} s",
        ratio=took.ratio,
        target=f"under {LIMIT:g} s",
        command="python -m benchmarks.logs",
        note=f"150,000 messages of two topics, median of {PAIRS} pairs; ours also hashes, converts and checks",
    )


def _by_pyulog(path: Path) -> object:
    return pyulog.ULog(str(path), ["vehicle_angular_velocity", "thrusters"]).data_list


def _by_mcap_json(path: Path) -> object:
    with path.open("rb") as file:
        read = mcap.reader.make_reader(file).iter_messages(["/imu", "/torque"], log_time_order=False)
        messages = [(channel.topic, json.loads(message.data)) for _, channel, message in read]
    return np.array([[message["rate"][axis] for axis in "xyz"] for topic, message in messages if topic == "/imu"])


def _by_mcap_ros(path: Path) -> object:
    get = attrgetter("angular_velocity.x", "angular_velocity.y", "angular_velocity.z")
    with path.open("rb") as file:
        reader = mcap.reader.make_reader(file, decoder_factories=[mcap_ros2.decoder.DecoderFactory()])
        read = reader.iter_decoded_messages(["/imu", "/wrench"], log_time_order=False)
        return np.array([get(message) for _, channel, _, message in read if channel.topic == "/imu"])


if __name__ == "__main__":
    for row in ratios():
        print(row)
    print(f"{resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024:.0f} MB at most")
