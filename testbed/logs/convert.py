"""From a log and its map to records, with a list of what was converted and what was left out."""

from __future__ import annotations

import difflib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from testbed.arrays import Array, Series
from testbed.errors import InputError
from testbed.files import FileStamp
from testbed.logs.cutting import Span, flagged_spans, spans_of
from testbed.logs.map import Channel, FlagRuns, LogMap
from testbed.logs.pauses import pauses
from testbed.logs.samples import Samples, Ticks, origin_of, samples_of, ticks_of
from testbed.logs.streams import TABLE, Content, Log, Topic, doubles
from testbed.records.checks import MINIMUM_SAMPLES, sampled_rows
from testbed.records.details import stated_details
from testbed.records.reading import record_of
from testbed.records.record import Record
from testbed.signals import SIGNALS

MOST_CELLS = 30_000_000
"""Rows times columns of a record, 0.24 GB: three times what is read of a log, as topics with other times add rows."""
_MOST_NAMED = 5
"""Names that are proposed for one that the log does not hold."""


@dataclass(frozen=True, kw_only=True)
class ImportedChannel:
    """How a channel came about.

    Attributes:
        topic: it was taken from; empty of a table.
        fields: of the topic.
        clock: that its times are from.
        converted: what was done to the numbers.
        samples: how many there are, over all runs and between them.
        rate_hz: median rate of the samples, Hz; None of fewer than two.
    """

    topic: str
    fields: tuple[str, ...]
    clock: str
    converted: tuple[str, ...]
    samples: int
    rate_hz: float | None


@dataclass(frozen=True, kw_only=True)
class Imported:
    """Records from a log, and how they came about.

    Attributes:
        records: the runs.
        format: of the log.
        inputs: the log's files, by hash.
        channels: by name.
        dropped: what was left out, in sentences.
        unused: topics, or columns, that the map does not name.
        pauses: where samples are missing within runs, and pauses of the gyro that may be two flights, in sentences.
    """

    records: tuple[Record, ...]
    format: str
    inputs: tuple[FileStamp, ...]
    channels: Mapping[str, ImportedChannel]
    dropped: tuple[str, ...]
    unused: tuple[str, ...]
    pauses: tuple[str, ...]

    @property
    def content(self) -> dict[str, Any]:
        """What provenance.json says of the import."""
        return {
            "format": self.format,
            "channels": {
                name: {
                    "topic": channel.topic,
                    "fields": list(channel.fields),
                    "clock": channel.clock,
                    "converted": list(channel.converted),
                    "samples": channel.samples,
                    "rate_hz": channel.rate_hz,
                }
                for name, channel in self.channels.items()
            },
            "runs": {
                record.details.name: {
                    "from_s": float(record.time[0]),
                    "to_s": float(record.time[-1]),
                    "rows": len(record.time),
                    "channels": list(record.channels),
                }
                for record in self.records
            },
            "dropped": list(self.dropped),
            "unused": list(self.unused),
            "pauses": list(self.pauses),
        }


def imported(log: Log, log_map: LogMap, inputs: tuple[FileStamp, ...], name: str) -> Imported:
    """Return a log as records.

    Args:
        log: to read.
        log_map: which of its fields are which channels.
        inputs: stamps of the log and of the map, for the records.
        name: of the run; of several in a log, numbered.

    Raises:
        InputError: the log cannot be read, does not hold what the map names, or gives no run.
    """
    content = log.read(log_map.wanted)
    _require_held(log, log_map, content)
    samples, channels, origin = _samples(log.path, log_map, content)
    spans = _spans(log.path, log_map, content, samples, origin)
    dropped = [*content.damage, *(each for channel in samples.values() for each in channel.dropped)]
    records = _records(log, log_map, samples, spans, dropped, inputs, name)
    return Imported(
        records=records,
        format=log.format,
        inputs=inputs,
        channels=channels,
        dropped=tuple(dropped),
        unused=content.unused,
        pauses=tuple(pauses(records)),
    )


def _require_held(log: Log, log_map: LogMap, content: Content) -> None:
    """Refuse a map that names what the log does not hold, with the nearest names.

    Raises:
        InputError: it does; every such name is in the message.
    """
    missing = {
        topic: sorted(fields - content.streams[topic].fields.keys() if topic in content.streams else fields)
        for topic, fields in log_map.wanted.items()
    }
    if not any(missing.values()):
        return
    survey = log.survey()
    problems = [
        problem
        for topic, fields in missing.items()
        if fields
        for problem in (
            _topic_problems(topic, survey) if topic not in survey else _field_problems(topic, fields, survey)
        )
    ]
    lines = "\n  ".join([*content.damage, *problems])  # the reason first
    raise InputError(f"{log.path}: does not hold what the map names\n  {lines}")


def _topic_problems(topic: str, survey: Mapping[str, Topic]) -> list[str]:
    if topic == TABLE:
        there = f"a channel names no topic; give one of {_listed(list(survey))}"
        return [there if survey else "it holds no messages: it is empty, or was cut short"]
    if TABLE in survey:
        return [f"topic {topic}: a table has no topics; leave topic out"]
    said = _nearest(topic, list(survey))
    return [f"topic {topic}: {f'{said}; there are {_listed(list(survey))}' if said == _NOT_THERE else said}"]


def _field_problems(topic: str, fields: list[str], survey: Mapping[str, Topic]) -> list[str]:
    if topic and not survey[topic].fields:
        return [f"topic {topic}: holds no message with a number"]
    where = f"topic {topic}, field" if topic else "column"
    said = {field: _field_problem(field, survey[topic]) for field in fields}
    problems = [f"{where} {field}: {problem}" for field, problem in said.items()]
    if _NOT_THERE in said.values():
        problems.append(f"{f'topic {topic}' if topic else 'the table'} has {_listed(list(survey[topic].fields))}")
    return problems


def _field_problem(field: str, topic: Topic) -> str:
    if field in topic.empty:
        return "has no values: none of its cells holds a number; take it out of the map, or name another one"
    if field in topic.fields:
        return "holds no number that could be read"
    return _nearest(field, list(topic.fields))


_NOT_THERE = "is not there"


def _nearest(name: str, names: list[str]) -> str:
    folded = {each.lower(): each for each in names}
    near = difflib.get_close_matches(name.lower(), folded, n=_MOST_NAMED, cutoff=0.5)
    return f"{_NOT_THERE}; did you mean {', '.join(folded[each] for each in near)}?" if near else _NOT_THERE


def _listed(names: list[str]) -> str:
    if not names:
        return "none"
    more = f" and {len(names) - 4 * _MOST_NAMED} more" if len(names) > 4 * _MOST_NAMED else ""
    return ", ".join(names[: 4 * _MOST_NAMED]) + more


def _samples(
    path: Path, log_map: LogMap, content: Content
) -> tuple[dict[str, Samples], dict[str, ImportedChannel], int | float]:
    """Return the channels at their own times, how they came about, and where time begins."""
    ticks: dict[str, Ticks] = {}
    samples: dict[str, Samples] = {}
    channels: dict[str, ImportedChannel] = {}
    for name, channel in log_map.given.items():
        with _naming(path, name):
            ticks[name] = ticks_of(content.streams[channel.topic], channel, log_map.clock)
    origin = origin_of(ticks, log_map.clock)
    for name, channel in log_map.given.items():
        with _naming(path, name):
            stream = content.streams[channel.topic]
            samples[name] = samples_of(name, channel, stream, ticks[name].since(origin), log_map.axes)
            _require_possible_rate(samples[name], ticks[name].clock)
        channels[name] = _imported_channel(channel, ticks[name], samples[name])
    _require_common_time(path, samples)
    return samples, channels, origin


def _require_common_time(path: Path, samples: Mapping[str, Samples]) -> None:
    """Refuse channels of which none has a sample while the gyro has: their clocks, or the units of these, differ."""
    gyro = samples["body_rate"].time
    others = {name: each.time for name, each in samples.items() if name != "body_rate" and each.time.size}
    if not gyro.size or not others:
        return
    apart = [name for name, time in others.items() if time.max() < gyro.min() or time.min() > gyro.max()]
    if len(apart) == len(others):
        name = apart[0]
        raise InputError(
            f"{path}: {name} has samples from {others[name].min():.6g} to {others[name].max():.6g} s, body_rate from "
            f"{gyro.min():.6g} to {gyro.max():.6g} s: their clocks differ; correct time_unit, time_field or offset_s"
        )


@contextmanager
def _naming(path: Path, name: str) -> Iterator[None]:
    """Put the log and the part of the map before what is wrong with them."""
    try:
        yield
    except InputError as error:
        raise InputError(f"{path}: {name}: {error}") from None


_FASTEST_HZ = 50_000.0
"""Mean rate beyond which a clock's unit is wrong: gyros of vehicles give up to 32,000 samples a second, encoders fewer;
100 samples a second become 100,000 where ms are taken for us. The mean, for a log may receive many at once."""


def _require_possible_rate(samples: Samples, clock: str) -> None:
    """Refuse samples that come faster than any sensor's.

    Raises:
        InputError: they do; the message says what of the clock to look at.
    """
    count, span = len(samples.time), float(np.ptp(samples.time)) if len(samples.time) else 0.0
    if count > _FASTEST_HZ * span > 0.0:
        raise InputError(
            f"{count} samples within {span:.3g} s by the clock ({clock}): no sensor is that fast; correct its unit in "
            "[clock], or name another clock"
        )


def _imported_channel(channel: Channel, ticks: Ticks, samples: Samples) -> ImportedChannel:
    steps = np.diff(samples.time)
    return ImportedChannel(
        topic=channel.topic,
        fields=channel.fields,
        clock=ticks.clock,
        converted=samples.converted,
        samples=len(samples.time),
        rate_hz=float(1.0 / np.median(steps)) if len(steps) else None,
    )


def _spans(
    path: Path, log_map: LogMap, content: Content, samples: Mapping[str, Samples], origin: int | float
) -> list[Span]:
    runs = log_map.runs
    if not isinstance(runs, FlagRuns):
        return spans_of(runs, samples["body_rate"])
    stream = content.streams[runs.topic]
    with _naming(path, "[runs]"):
        time = ticks_of(stream, runs, log_map.clock).since(origin)
    order = np.argsort(time, kind="stable")
    spans = flagged_spans(time[order], doubles(stream.fields[runs.field])[order], runs.above)
    if not spans:
        raise InputError(
            f"{path}: {runs.field} is never above {runs.above:g}: no run begins; choose another flag or value"
        )
    return spans


def _records(
    log: Log,
    log_map: LogMap,
    samples: Mapping[str, Samples],
    spans: list[Span],
    dropped: list[str],
    inputs: tuple[FileStamp, ...],
    stem: str,
) -> tuple[Record, ...]:
    """Return a record for each span that holds enough; `dropped` takes up what is not in them."""
    digits = len(str(len(spans)))
    records, longest = [], 0
    for number, span in enumerate(spans, start=1):
        name = stem if len(spans) == 1 else f"{stem}_{number:0{digits}}"
        parts = {channel: _part(each, span) for channel, each in samples.items()}
        count = int(sampled_rows(parts["body_rate"][1]).sum())
        longest = max(longest, count)
        if count < MINIMUM_SAMPLES:
            dropped.append(f"{name}: {count} samples of the body rate, at least {MINIMUM_SAMPLES} are needed: left out")
            continue
        dropped += [f"{name}: {channel} has no sample in it" for channel, (time, _) in parts.items() if not time.size]
        details = replace(stated_details(log.path, log_map.details), name=name)
        record = record_of(_columns(log.path, parts), details, {})
        records.append(Record(time=record.time, channels=record.channels, details=details, files=inputs))
    if not records:
        raise InputError(
            f"{log.path}: no run holds {MINIMUM_SAMPLES} samples of the body rate, which are needed; the longest holds "
            f"{longest}: take another log, or cut this one otherwise in [runs]"
        )
    return tuple(records)


def _part(samples: Samples, span: Span) -> tuple[Series, Array]:
    rows = span.rows(samples.time)
    return samples.time[rows], samples.values[rows]


def _columns(path: Path, parts: Mapping[str, tuple[Series, Array]]) -> dict[str, Series]:
    """Return channels as columns on all their times; NaN where a channel was not sampled.

    Raises:
        InputError: there are too many times and columns together.
    """
    held = {name: part for name, part in parts.items() if part[0].size}
    time = np.unique(np.concatenate([np.zeros(0), *(times for times, _ in held.values())]))
    width = sum(values.shape[1] for _, values in held.values())
    if len(time) * (width + 1) > MOST_CELLS:
        raise InputError(
            f"{path}: its topics have {len(time):,} times in all, too many for a record of {width} columns "
            f"({MOST_CELLS:,} values): cut the log into several runs in [runs]"
        )
    columns = {"time_s": time}
    for name, (times, values) in held.items():
        rows = np.searchsorted(time, times)
        for column, series in zip(SIGNALS[name].sized(values.shape[1]).columns, values.T, strict=True):
            full = np.full(len(time), np.nan)
            full[rows] = series
            columns[column] = full
    return columns
