"""Records as MCAP: a topic a channel, messages in JSON with a schema, every number with all its digits."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import tomli_w

from testbed.arrays import Array
from testbed.errors import OutputError
from testbed.files import whole_file
from testbed.logs.extra import library
from testbed.records.details import details_keys
from testbed.records.record import Record
from testbed.signals import SIGNALS

_TIME = "time_s"
_VALUE = "value"
"""Field of a signal that is a single number."""
_EXTRA = "/extra"
"""Topic of the columns that no signal bears; a row each."""


def write_mcap(record: Record, path: Path) -> Path:
    """Write a record as MCAP, and beside it PATH.map.toml, with which it is imported again bit for bit.

    A message stands for a row in which its channel was sampled; `time_s` in it is the row's time, and the log's own
    time counts nanoseconds from the first row.

    Args:
        record: the run.
        path: of the file; one that is there is replaced.

    Raises:
        InputError: the extra `testbed[logs]` is not installed.
        OutputError: the file cannot be written.
    """
    writers = library("mcap.writer", "writing MCAP")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with whole_file(path) as part, part.open("wb") as file:
            writer = writers.Writer(file)
            writer.start(library="testbed")
            _write(writer, record)
            writer.finish()
        path.with_suffix(".map.toml").write_text(tomli_w.dumps(map_keys(record)), encoding="utf-8")
    except OSError as error:
        raise OutputError(f"{path}: cannot be written ({error.strerror}); choose another folder") from error
    return path


def map_keys(record: Record) -> dict[str, Any]:
    """Return the map that imports a record again from the MCAP file that `write_mcap` writes."""
    stated = {key: value for key, value in details_keys(record.details).items() if key != "name"}
    return {
        "schema": 1,
        "source": record.details.source,
        **stated,
        "clock": {"field": _TIME, "unit": "s", "origin": "clock"},
        "channels": {name: _channel_keys(name, record) for name in SIGNALS if name in record.channels},
    }


def _channel_keys(name: str, record: Record) -> dict[str, Any]:
    unit = SIGNALS[name].unit.replace("·", "*").replace("²", "^2")
    return {"topic": f"/{name}", "fields": list(_fields(name, record)), **({"unit": unit} if unit else {})}


def _fields(name: str, record: Record) -> tuple[str, ...]:
    """Return what a signal's components are called in a message; letters only begin a name in JSON paths."""
    signal = SIGNALS[name].sized(record.channels[name].shape[1])
    return tuple(f"_{each}" if each.isdigit() else each for each in signal.components) or (_VALUE,)


def _write(writer: Any, record: Record) -> None:  # noqa: ANN401 - the library is optional
    topics = {f"/{name}": _fields(name, record) for name in record.channels} | (
        {_EXTRA: tuple(record.extra_columns)} if record.extra_columns else {}
    )
    channels = {
        topic: writer.register_channel(topic=topic, message_encoding="json", schema_id=_schema(writer, topic, fields))
        for topic, fields in topics.items()
    }
    begin = record.time[0] if len(record.time) else 0.0
    received = np.round((record.time - begin) * 1e9).astype(np.int64)
    messages = {f"/{name}": list(_messages(record, name)) for name in record.channels}
    for row, time in enumerate(record.time.tolist()):
        for topic, channel in channels.items():
            content = _extra(record, row) if topic == _EXTRA else messages[topic][row]
            if content is not None:
                data = json.dumps({_TIME: time, **content}, allow_nan=False).encode()
                ticks = int(received[row])
                writer.add_message(channel, log_time=ticks, publish_time=ticks, data=data)


def _schema(writer: Any, topic: str, fields: tuple[str, ...]) -> int:  # noqa: ANN401
    """Register the JSON Schema of a topic."""
    kind = {} if topic == _EXTRA else {"type": ["number", "null"]}
    unit = SIGNALS[topic[1:]].unit if topic != _EXTRA else ""
    properties = {_TIME: {"type": "number", "description": "s"}} | {
        field: {**kind, "description": unit or "1"} for field in fields
    }
    schema = {"type": "object", "title": topic[1:], "properties": properties, "required": [_TIME]}
    identity: int = writer.register_schema(
        name=f"testbed.{topic[1:]}", encoding="jsonschema", data=json.dumps(schema, ensure_ascii=False).encode()
    )
    return identity


def _messages(record: Record, name: str) -> Iterator[Mapping[str, float | None] | None]:
    """Yield a channel's messages, a row each; None where it was not sampled."""
    values: Array = record.channels[name]
    fields = _fields(name, record)
    for row in values.tolist():
        numbers = [None if number != number else number for number in row]  # noqa: PLR0124 - NaN alone differs from itself
        yield None if all(number is None for number in numbers) else dict(zip(fields, numbers, strict=True))


def _extra(record: Record, row: int) -> dict[str, Any]:
    """Return the other columns of a row; what JSON has no word for as text, or null."""
    content = {}
    for name, column in record.extra_columns.items():
        value = column[row].item() if isinstance(column[row], np.generic) else column[row]
        plain = (
            value is None or isinstance(value, (bool, int, str)) or (isinstance(value, float) and np.isfinite(value))
        )
        content[name] = value if plain else (None if isinstance(value, float) else str(value))
    return content
