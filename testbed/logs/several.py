"""Several logs of one vehicle, read by one map, as one data set."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from testbed.errors import InputError, made_of_each
from testbed.files import FileStamp, readable
from testbed.logs.convert import Imported, ImportedChannel, imported
from testbed.logs.map import LogMap
from testbed.logs.streams import Log


def imported_together(logs: Sequence[Log], log_map: LogMap, map_stamp: FileStamp) -> Imported:
    """Return logs as one data set: the runs of each are called by its name, after that of the map where it has one.

    Args:
        logs: to read, one or more.
        log_map: which of their fields are which channels; each log has all of them.
        map_stamp: of the map, for the records.

    Raises:
        InputError: a log is given twice, or some cannot be imported; all of these are named.
    """
    stamps = [log.stamps() for log in logs]
    _refuse_repeated(logs, stamps)
    each = zip(logs, stamps, _names(logs, log_map.name), strict=True)
    made = made_of_each(lambda one: imported(one[0], log_map, (*one[1], map_stamp), one[2]), each)
    return made[0] if len(made) == 1 else _together(logs, made, map_stamp)


def _refuse_repeated(logs: Sequence[Log], stamps: Sequence[Sequence[FileStamp]]) -> None:
    """Refuse a flight that would count twice.

    Raises:
        InputError: two logs have the same bytes.
    """
    known: dict[tuple[str, ...], Log] = {}
    for log, own in zip(logs, stamps, strict=True):
        first = known.setdefault(tuple(stamp.sha256 for stamp in own), log)
        if first is not log:
            raise InputError(f"{log.path}: is the same log as {first.path}, byte by byte; give each once")


def _names(logs: Sequence[Log], common: str | None) -> list[str]:
    """Return what the runs of each log are called; logs of one name, in several folders, are numbered."""
    if len(logs) == 1 and common is not None:
        return [common]
    stems = [readable(log.path.stem).lstrip(".") or "run" for log in logs]
    names: list[str] = []
    for stem in stems if common is None else [f"{common}_{stem}" for stem in stems]:
        counted = (f"{stem}_{number}" for number in range(2, len(logs) + 2))
        names.append(stem if stem not in names else next(each for each in counted if each not in {*names, *stems}))
    return names


def _together(logs: Sequence[Log], made: Sequence[Imported], map_stamp: FileStamp) -> Imported:
    records = tuple(record for each in made for record in each.records)
    repeated = [name for name, count in Counter(record.details.name for record in records).items() if count > 1]
    if repeated:
        raise InputError(f"two runs would be called {repeated[0]}: rename the logs")
    own = (stamp for each in made for stamp in each.inputs if stamp != map_stamp)
    return Imported(
        records=records,
        format=", ".join(dict.fromkeys(each.format for each in made)),
        inputs=(*own, map_stamp),
        channels={name: _channel([each.channels[name] for each in made]) for name in made[0].channels},
        dropped=tuple(
            f"{log.path.name}: {text}" for log, each in zip(logs, made, strict=True) for text in each.dropped
        ),
        unused=_distinct(each.unused for each in made),
        pauses=tuple(text for each in made for text in each.pauses),
    )


def _channel(each: Sequence[ImportedChannel]) -> ImportedChannel:
    """Return how a channel came about in all logs: all its samples, and the median of their rates."""
    rates = [channel.rate_hz for channel in each if channel.rate_hz is not None]
    return replace(
        each[0],
        clock=" or ".join(_distinct([channel.clock] for channel in each)),
        converted=_distinct(channel.converted for channel in each),
        samples=sum(channel.samples for channel in each),
        rate_hz=float(np.median(rates)) if rates else None,
    )


def _distinct(texts: Iterable[Iterable[str]]) -> tuple[str, ...]:
    return tuple(dict.fromkeys(text for each in texts for text in each))
