"""Numbers out of decoded messages, whatever decoded them: JSON objects, protobuf messages, ROS messages.

A field is named by its path, such as `angular_velocity.x` or `data[3]`. A time in two parts, seconds and nanoseconds,
is one field of integer nanoseconds.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import replace
from math import nan
from operator import attrgetter
from typing import Any, TypeAlias

import numpy as np

from testbed.logs.streams import Numbers, Room, Stream, Topic

Steps: TypeAlias = tuple[str | int, ...]
Getter: TypeAlias = Callable[[Any], Any]

_INT64 = 2**63
_TIMES = (("sec", "nanosec"), ("sec", "nsec"), ("secs", "nsecs"), ("seconds", "nanos"))
"""Names of the two parts of a time: ROS 2, Foxglove's JSON, ROS 1, protobuf."""
_MOST_ENTRIES = 64
"""Entries of a list that are offered as fields; a map may name those beyond them too."""
_DEEPEST = 12
"""Messages within each other that are looked into."""
_BATCH = 65_536
"""Messages whose numbers are held as Python objects, which take four times the room, before they are packed."""


def topic_of(message: object, kind: str, *, received: bool = True) -> Topic:
    """Return what a topic offers, by its first message; None where it has none."""
    found = list(_leaves(message))
    return Topic(
        kind=kind,
        fields={_path(steps): float(_number(value) or 0) for steps, value in found},
        units={_path(steps): "ns" for steps, value in found if _is_time(value)},
        received=received,
    )


LOOKED_AT = 16
"""Messages of a topic that tell what it offers: of the first ones some may lack a value."""


def with_further(topic: Topic, message: object) -> Topic:
    """Return what a topic offers with the fields of a further message of it."""
    other = topic_of(message, topic.kind, received=topic.received)
    return replace(topic, fields={**other.fields, **topic.fields}, units={**other.units, **topic.units})


class Collector:
    """Collects fields of the messages of one topic."""

    def __init__(self, wanted: Collection[str], room: Room) -> None:
        """Begin without a message.

        Args:
            wanted: fields by path.
            room: counts what is collected.
        """
        self._wanted, self._room = tuple(wanted), room
        self._getters: list[Getter] | None = None
        self._rows: list[list[Any]] = []
        self._times: list[int] = []
        self._packed: list[list[Numbers]] = []
        self._received: list[Numbers] = []
        self._clocks: set[str] = set()
        self.undecoded = 0

    def add(self, message: object, received: int) -> None:
        """Take the fields of a message.

        Args:
            message: decoded; None of one that could not be.
            received: when the log took it, ns.
        """
        if message is None:
            self.undecoded += 1
            return
        if self._getters is None:
            self._begin(message)
            assert self._getters is not None
        self._rows.append([get(message) for get in self._getters])
        self._times.append(received)
        if len(self._times) == _BATCH:
            self._pack()

    def stream(self) -> Stream:
        """Return what was collected; fields that no message held are left out."""
        self._pack()
        columns = [np.concatenate(parts) for parts in zip(*self._packed, strict=True)] if self._packed else []
        fields = dict(zip(self._wanted, columns, strict=False))
        held = {name: column for name, column in fields.items() if not np.isnan(column).all()}
        received = np.concatenate([*self._received, np.zeros(0, dtype=np.int64)])
        units = dict.fromkeys(self._clocks & held.keys(), "ns")
        return Stream(fields=held, units=units, received=received)

    def _begin(self, example: object) -> None:
        known = {_path(steps): (steps, value) for steps, value in _leaves(example)}
        self._getters = []
        for name in self._wanted:
            steps, value = known.get(name, (_steps(name), None))
            if _is_time(value):
                self._clocks.add(name)
            self._getters.append(_getter(steps, example))

    def _pack(self) -> None:
        if not self._times:
            return
        self._room.take(len(self._times) * (len(self._wanted) + 1))
        self._packed.append([_column(values) for values in zip(*self._rows, strict=True)])
        self._received.append(np.array(self._times, dtype=np.int64))
        self._rows, self._times = [], []


def undecoded(collectors: Mapping[str, Collector]) -> list[str]:
    """Return what to say of messages that could not be decoded, by topic."""
    return [
        f"{collector.undecoded} messages of {topic} could not be decoded: they were left out"
        for topic, collector in collectors.items()
        if collector.undecoded
    ]


def _leaves(message: object, above: Steps = ()) -> Iterator[tuple[Steps, Any]]:
    """Yield the numbers and times of a message with the steps that lead to them."""
    for step, value in _children(message):
        steps = (*above, step)
        if _is_number(value) or _is_time(value):
            yield steps, value
        elif len(steps) < _DEEPEST:
            yield from _leaves(value, steps)


def _children(value: Any) -> Iterator[tuple[str | int, Any]]:  # noqa: ANN401
    if isinstance(value, (str, bytes)):
        return
    if isinstance(value, Mapping):
        yield from ((key, entry) for key, entry in value.items() if isinstance(key, str))
    elif hasattr(value, "DESCRIPTOR"):
        yield from ((each.name, getattr(value, each.name)) for each in value.DESCRIPTOR.fields)
    elif hasattr(value, "__dataclass_fields__"):
        yield from ((name, getattr(value, name)) for name in value.__dataclass_fields__ if not name.startswith("__"))
    elif hasattr(value, "__len__") and hasattr(value, "__getitem__"):
        yield from ((index, value[index]) for index in range(min(len(value), _MOST_ENTRIES)))


def _is_number(value: object) -> bool:
    return isinstance(value, (bool, int, float, np.number, np.bool_))


def _is_time(value: object) -> bool:
    return _time_parts(value) is not None


def _time_parts(value: Any) -> tuple[int, int] | None:  # noqa: ANN401
    for parts in _TIMES:
        if isinstance(value, dict):
            whole, rest = value.get(parts[0]), value.get(parts[1])
        else:
            whole, rest = getattr(value, parts[0], None), getattr(value, parts[1], None)
        if isinstance(whole, (int, np.integer)) and isinstance(rest, (int, np.integer)):
            return int(whole), int(rest)
    return None


def _number(value: Any) -> int | float | None:  # noqa: ANN401
    """Return a number, of a time its nanoseconds; None for anything else."""
    if isinstance(value, (bool, int)):
        return int(value)
    if isinstance(value, (float, np.number, np.bool_)):
        return int(value) if isinstance(value, np.integer) else float(value)
    parts = None if value is None or isinstance(value, str) else _time_parts(value)
    return None if parts is None else parts[0] * 1_000_000_000 + parts[1]


def _getter(steps: Steps, example: object) -> Getter:
    """Return what takes a number out of a message like the example, None where there is none."""
    plain = not isinstance(example, Mapping) and all(isinstance(step, str) for step in steps)
    get = attrgetter(".".join(map(str, steps))) if plain and steps else _walk(steps)

    def number(message: object) -> Any:  # noqa: ANN401
        try:
            value = get(message)
        except (KeyError, IndexError, AttributeError, TypeError):
            return None
        return value if type(value) is float else _number(value)

    return number


def _walk(steps: Steps) -> Getter:
    def get(message: Any) -> Any:  # noqa: ANN401
        for step in steps:
            message = message[step] if isinstance(step, int) or isinstance(message, dict) else getattr(message, step)
        return message

    return get


def _column(values: tuple[Any, ...]) -> Numbers:
    """Return values as numbers, integers kept where all are; NaN where there is none."""
    if all(type(value) is float for value in values):
        return np.array(values)
    if all(type(value) is int and -_INT64 <= value < _INT64 for value in values):
        return np.array(values, dtype=np.int64)
    return np.array([nan if value is None else float(value) for value in values])


def _path(steps: Steps) -> str:
    return "".join(f"[{step}]" if isinstance(step, int) else f".{step}" for step in steps).removeprefix(".")


def _steps(path: str) -> Steps:
    parts = re.findall(r"\[(\d+)\]|([^.\[\]]+)", path)
    return tuple(int(index) if index else name for index, name in parts)
