"""ULog, the format of PX4's logger: docs.px4.io, "ULog File Format". The topic of instance 1 is called NAME[1]."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import redirect_stdout
from dataclasses import dataclass
from io import StringIO
from typing import Any, ClassVar

import numpy as np
from typing_extensions import override

from testbed.errors import InputError
from testbed.files import open_regular
from testbed.logs.extra import library
from testbed.logs.streams import Content, Log, Room, Stream, Topic, Wanted, WholeReads, parsing

MAGIC = b"ULog\x01\x12\x35"
LARGEST = 1_000_000_000
"""Bytes; the messages of a topic that is read stay in memory with all their fields."""
_SURVEYED = 50_000_000
"""Bytes from the beginning in which topics are looked for; every logger names its topics when it starts."""
_RECEIVED = "timestamp"
"""Field that the format itself makes the time of a message, us."""


class _Asked(frozenset[str]):
    """Names to be read, which remembers all the names that it was asked for: those that the log holds."""

    def __init__(self, _names: object = ()) -> None:
        self.names: set[str] = set()

    def __contains__(self, name: object) -> bool:
        self.names.add(str(name))
        return super().__contains__(name)


@dataclass(frozen=True)
class ULog(Log):
    """A ULog file."""

    format: ClassVar[str] = "ULog"

    @override
    def survey(self) -> Mapping[str, Topic]:
        """Return the topics of the log."""
        parsed, _ = self._parsed(None, _SURVEYED)
        return {
            _name(data): Topic(
                kind=data.name,
                fields={name: float(values[0]) for name, values in data.data.items() if _offered(name)},
                units={name: "us" for name in data.data if name.startswith(_RECEIVED)},
            )
            for data in parsed.data_list
        }

    @override
    def read(self, wanted: Wanted) -> Content:
        """Read fields of topics."""
        asked = _Asked({name.partition("[")[0] for name in wanted})
        parsed, cut = self._parsed(asked, None)
        room = Room(self.path)
        streams = {
            _name(data): _stream(data, wanted[_name(data)], room) for data in parsed.data_list if _name(data) in wanted
        }
        damage = []
        if cut:
            damage.append("the file ends in the middle of a message: the log was cut, what is whole was read")
        if parsed.file_corruption:
            damage.append("some messages are damaged: they were left out")
        lost = sum(dropout.duration for dropout in parsed.dropouts)
        if lost:
            damage.append(f"the logger lost messages {len(parsed.dropouts)} times, {lost / 1e3:.3g} s in all")
        return Content(streams=streams, unused=tuple(sorted(asked.names - asked)), damage=tuple(damage))

    def _parsed(self, asked: _Asked | None, most: int | None) -> tuple[Any, bool]:
        pyulog = library("pyulog", "reading ULog")
        with parsing(self.path, self.format):
            file = open_regular(self.path)
            with file:
                if (size := self.path.stat().st_size) > LARGEST:
                    raise InputError(f"{self.path}: is {size / 1e9:.3g} GB large, at most {LARGEST / 1e9:g} are read")
                reads = WholeReads(file, most)
                with redirect_stdout(StringIO()):  # where the library speaks of what `damage` says
                    return pyulog.ULog(reads, asked), reads.cut


def _stream(data: Any, wanted: object, room: Room) -> Stream:  # noqa: ANN401
    assert isinstance(wanted, (set, frozenset, tuple, list))
    held = [name for name in wanted if name in data.data]
    received = np.asarray(data.data[_RECEIVED]).astype(np.int64)
    room.take(len(received) * (len(held) + 1))
    return Stream(
        fields={name: np.array(data.data[name]) for name in held},
        units={name: "us" for name in held if name.startswith(_RECEIVED)},
        received=received,
        received_unit="us",
    )


def _name(data: Any) -> str:  # noqa: ANN401
    return str(data.name) if data.multi_id == 0 else f"{data.name}[{data.multi_id}]"


def _offered(name: str) -> bool:
    return "_padding" not in name
