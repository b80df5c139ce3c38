"""Logs of other programs, damaged and huge, and maps of other logs."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import tomli_w

from support import logs
from tests.robustness.case import ANY, COMPLETED, REFUSED, Case

LOG = "log.bag"
"""The name by which ROS bags are known; the other formats are known by their first bytes."""
IMPORT = (("import", LOG, "--map", "map.toml", "--out", "out"),)
_WRITERS: dict[str, tuple[Callable[[Path], Path], dict]] = {
    "ULog": (lambda folder: logs.write_ulog(folder / "a.ulg"), logs.ULOG_MAP),
    "MCAP of JSON": (lambda folder: logs.write_json_mcap(folder / "a.mcap"), logs.JSON_MAP),
    "MCAP of ROS 2": (lambda folder: logs.write_ros_mcap(folder / "a.mcap"), logs.ROS_MAP),
    "MCAP of protobuf": (lambda folder: logs.write_protobuf_mcap(folder / "a.mcap"), logs.PROTOBUF_MAP),
    "ROS bag": (lambda folder: logs.write_bag(folder / "a.bag"), logs.ROS_MAP),
}


def cases() -> Iterator[Case]:
    """Give a case for every way in which a log or its map can be wrong."""
    for kind, (_, keys) in _WRITERS.items():
        for name, (change, codes) in _BYTES.items():
            yield _case(
                f"{kind} {name}",
                lambda kind=kind, change=change: change(_good(kind)),
                keys,
                codes,
                fast=name in ("cut in half", "with flipped bytes"),
            )
    for name, content in _NO_LOGS.items():
        yield _case(f"that is {name}", lambda content=content: content, logs.ULOG_MAP, (REFUSED,), fast=False)
    for name, (change, says) in _MAPS.items():
        keys = json.loads(json.dumps(logs.ULOG_MAP))
        change(keys)
        yield _case(
            f"map {name}", lambda: _good("ULog"), keys, (REFUSED,) if says else ANY, says, fast=name == "of another log"
        )
    yield _case("CSV of a gigabyte", lambda: b"", _TABLE_MAP, ANY, prepare=_huge_table, fast=False)
    yield _case("CSV of 20 million values", lambda: b"", _TABLE_MAP, (REFUSED,), prepare=_long_table, fast=False)


def _case(
    name: str,
    content: Callable[[], bytes],
    keys: dict,
    codes: tuple[int, ...],
    says: tuple[str, ...] = (),
    prepare: Callable[[Path], None] | None = None,
    *,
    fast: bool,
) -> Case:
    def fill(folder: Path) -> None:
        (folder / "map.toml").write_text(tomli_w.dumps(keys), encoding="utf-8")
        if prepare is None:
            (folder / LOG).write_bytes(content())
        else:
            prepare(folder)

    return Case(name=f"log: {name}", prepare=fill, commands=IMPORT, codes=codes, says=says, fast=fast)


@cache
def _good(kind: str) -> bytes:
    with TemporaryDirectory() as folder:
        return _WRITERS[kind][0](Path(folder)).read_bytes()


def _flipped(content: bytes) -> bytes:
    flipped = bytearray(content)
    for place in range(40, len(flipped), 997):
        flipped[place] ^= 0xFF
    return bytes(flipped)


_BYTES: dict[str, tuple[Callable[[bytes], bytes], tuple[int, ...]]] = {
    "whole": (lambda content: content, (COMPLETED,)),
    "cut in half": (lambda content: content[: len(content) // 2], ANY),
    "cut after 20 bytes": (lambda content: content[:20], (REFUSED,)),
    "with flipped bytes": (_flipped, ANY),
    "with zeros in its middle": (lambda content: content[:2000] + bytes(1000) + content[3000:], ANY),
    "with noise at its end": (lambda content: content + bytes(range(256)) * 10, ANY),
    "twice": (lambda content: content * 2, ANY),
    "with all sizes at their largest": (lambda content: content[:60] + b"\xff" * 40 + content[100:], ANY),
}
_NO_LOGS = {
    "empty": b"",
    "zeros": bytes(10_000),
    "a page": b"<!doctype html><title>Not found</title>",
    "JSON": b'{"time_s": [1, 2]}',
    "the beginning of ULog": b"ULog\x01\x12\x35",
    "the beginning of MCAP": b"\x89MCAP0\r\n",
    "the beginning of a bag": b"#ROSBAG V2.0\n",
    "the beginning of a database": b"SQLite format 3\0",
    "the beginning of Parquet": b"PAR1",
}


def _set(*path: str, value: object) -> Callable[[dict], None]:
    def change(keys: dict) -> None:
        for each in path[:-1]:
            keys = keys.setdefault(each, {})
        keys[path[-1]] = value

    return change


_MAPS: dict[str, tuple[Callable[[dict], None], tuple[str, ...]]] = {
    "of another log": (_set("channels", "body_rate", "topic", value="sensor_gyroo"), ("did you mean sensor_gyro",)),
    "with a field too many": (_set("channels", "body_rate", "fields", value=list("abcd")), ("names 4",)),
    "with a unit of no quantity": (_set("channels", "body_rate", "unit", value="furlong"), ("another quantity",)),
    "with a unit that computes": (_set("channels", "body_rate", "unit", value="9**9**9**9 rad/s"), ("not known",)),
    "that mirrors": (_set("channels", "body_rate", "axes", value=["x", "y", "-z"]), ("mirrors",)),
    "without channels": (_set("channels", value={}), ("body_rate: is missing",)),
    "that cuts nothing out": (_set("runs", value={"kind": "times", "spans_s": [[1e9, 2e9]]}), ("no run holds",)),
    "with a scale of 1e12": (_set("channels", "body_rate", "scale", value=[1e12] * 3), ("rad/s",)),
    "that shifts by days": (_set("channels", "body_rate", "offset_s", value=1e6), ()),
}
_TABLE_MAP = {
    "schema": 1,
    "clock": {"field": "t", "unit": "ms"},
    "channels": {
        "body_rate": {"fields": ["a", "b", "c"], "unit": "deg/s"},
        "applied_torque": {"fields": ["d", "e", "f"], "unit": "N*m"},
    },
}


def _huge_table(folder: Path) -> None:
    """A line for the names, and then one that never ends, in a file that is mostly hole."""
    with (folder / LOG).open("wb") as file:
        file.write(b"t,a,b,c,d,e,f\n1,2,3,4,5,6,7\n")
        file.truncate(10**9)


def _long_table(folder: Path) -> None:
    row = b"%d,0.1,0.2,0.3,0.4,0.5,0.6\n"
    with (folder / LOG).open("wb") as file:
        file.write(b"t,a,b,c,d,e,f\n")
        for start in range(0, 3_000_000, 100_000):
            file.write(b"".join(row % number for number in range(start, start + 100_000)))
