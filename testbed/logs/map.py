"""MAP.toml: which topics and fields of a log become which channels of records, and how."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any, Literal, TypeAlias

import numpy as np
from pydantic import AfterValidator, Field, Strict, ValidationError, create_model, model_validator

from testbed.errors import InputError
from testbed.files import TextFile, parsed_toml, read_text
from testbed.logs.extra import library
from testbed.logs.streams import TABLE
from testbed.logs.units import factor_to
from testbed.quantities import RateNoise
from testbed.records.details import stated_details
from testbed.scenario.reader import problem_listing
from testbed.scenario.section import Conflict, Section, refuse
from testbed.scenario.values import Pair, Three
from testbed.signals import AXES, MOST_UNITS, QUATERNION, SIGNALS

LARGEST_MAP = 200_000
"""Bytes of MAP.toml; all channels there are take 5,000."""

MOST_RUNS = 1000
"""Of one log; a diagnosis takes five to twenty."""

Name: TypeAlias = Annotated[str, Field(min_length=1, max_length=500)]
Unit: TypeAlias = Annotated[str, Field(min_length=1, max_length=60)]


def _of_time(unit: str) -> str:
    """Refuse a unit that is none of time, as `factor_to` does."""
    try:
        factor_to(unit, "s")
    except InputError as error:
        raise ValueError(str(error)) from None
    return unit


TimeUnit: TypeAlias = Annotated[Unit, AfterValidator(_of_time)]
Axis: TypeAlias = Literal["x", "y", "z", "+x", "+y", "+z", "-x", "-y", "-z"]
Factor: TypeAlias = Annotated[float, Field(ge=-1e12, le=1e12)]
Seconds: TypeAlias = Annotated[float, Field(ge=-1e10, le=1e10)]
Span: TypeAlias = Pair[Seconds]


class Clock(Section):
    """Where the time of samples comes from."""

    field: Name | None = None
    """Field, or column, that holds the time; omitted: the time at which the log received the message."""
    unit: TimeUnit | None = None
    """Unit of that field, such as `us`; required where the format does not state it."""
    origin: Literal["first", "clock"] = "first"
    """Time 0 of the records: the first sample of all channels, or the zero of the clock."""


class Channel(Section):
    """Where a channel comes from."""

    topic: Name = TABLE
    """Topic of its samples; left out for CSV and Parquet, which have none."""
    fields: Annotated[tuple[Name, ...], Strict(False), Field(min_length=1, max_length=MOST_UNITS)]
    """Fields, or columns, in the order of the channel's components; where `axes` is given, of the sensor's x, y,
    z. Where the map itself has `axes`, those about these alone may be named."""
    unit: Unit | None = None
    """Unit of the fields, such as `deg/s`; required where the channel has a unit."""
    axes: Three[Axis] | None = None
    """The sensor's axis along body x, y and z, such as ["-y", "x", "z"]; omitted: the same axes."""
    left_handed: bool = False
    """Whether the sensor's axes are known to be left-handed, so that `axes` may mirror."""
    scale: Annotated[tuple[Factor, ...], Strict(False), Field(min_length=1, max_length=MOST_UNITS)] | None = None
    """What each field is multiplied by as well, such as a sign, or the torque at a set point of 1; omitted: 1."""
    time_field: Name | None = None
    """Field with the time of these samples; omitted: as in [clock]."""
    time_unit: TimeUnit | None = None
    """Unit of that field."""
    offset_s: Annotated[float, Field(ge=-1e6, le=1e6)] = 0.0
    """Added to the times of these samples, such as minus a known latency."""


class WholeRun(Section):
    """The whole log is one run."""

    kind: Literal["whole"]


class FlagRuns(Section):
    """A run lasts as long as a field is above a value."""

    kind: Literal["flag"]
    topic: Name = TABLE
    """Topic of the flag; left out for CSV and Parquet."""
    field: Name
    """Field that is the flag; it holds from its sample to the next one."""
    above: Factor = 0.5
    """Value above which a run lasts."""
    time_field: Name | None = None
    """Field with the time of the flag; omitted: as in [clock]."""
    time_unit: TimeUnit | None = None
    """Unit of that field."""


class GapRuns(Section):
    """A run ends where the body rate pauses."""

    kind: Literal["gaps"]
    longer_than_s: Annotated[float, Field(ge=1e-3, le=1e6)]
    """Pause of the body rate's samples that separates two runs."""


class TimedRuns(Section):
    """Runs at given times."""

    kind: Literal["times"]
    spans_s: Annotated[tuple[Span, ...], Strict(False), Field(min_length=1, max_length=MOST_RUNS)]
    """First and last time of each run, as in the records."""

    @model_validator(mode="after")
    def _ordered(self) -> TimedRuns:
        refuse(self._conflicts())
        return self

    def _conflicts(self) -> Iterator[Conflict]:
        for number, (start, end) in enumerate(self.spans_s, start=1):
            if start >= end:
                yield Conflict(key="spans_s", text=f"span {number} ends at {end:g} s, before it begins ({start:g} s)")
        for number, (before, after) in enumerate(pairwise(self.spans_s), start=1):
            if after[0] <= before[1]:
                yield Conflict(key="spans_s", text=f"span {number + 1} begins before span {number} has ended")


Runs: TypeAlias = Annotated[WholeRun | FlagRuns | GapRuns | TimedRuns, Field(discriminator="kind")]

_CHANNELS: dict[str, Any] = {
    name: (Channel | None, Field(default=None, description=f"{signal.label[0].upper()}{signal.label[1:]}."))
    for name, signal in SIGNALS.items()
}


class _Channels(Section):
    """Channels of the records, by name."""

    @model_validator(mode="after")
    def _complete(self) -> _Channels:
        refuse(self._conflicts())
        return self

    def _conflicts(self) -> Iterator[Conflict]:
        if "body_rate" not in self.given:
            yield Conflict(key="body_rate", text="is missing; no record is of use without it: say where the gyro is")
        for name, channel in self.given.items():
            for conflict in _conflicts(name, channel):
                yield Conflict(key=f"{name}.{conflict.key}", text=conflict.text)

    @property
    def given(self) -> dict[str, Channel]:
        """The channels that the map names, in the order of the table of signals."""
        found = ((name, getattr(self, name)) for name in SIGNALS)
        return {name: channel for name, channel in found if channel is not None}


Channels = create_model("Channels", __base__=_Channels, __doc__=_Channels.__doc__, **_CHANNELS)


ABOUT_AXES = ("body_rate", "applied_torque", "cluster_momentum")
"""Channels of which a rig that turns about some body axes may log what is about these alone."""
_DETAILS = {"source", "gyro_noise_rad_s", "usable_from_s", "usable_to_s", "role", "axes"}


class LogMap(Section):
    """How a log becomes records."""

    schema_version: Annotated[Literal[1], Field(alias="schema")]
    """Version of this file format."""
    name: Annotated[str, Field(min_length=1, max_length=100, pattern=r"^[A-Za-z0-9_-]+$")] | None = None
    """Name of the runs; omitted: the log's. Of several logs that are imported together it stands before theirs."""
    source: Literal["measured", "simulated"] = "measured"
    """What sent the log."""
    gyro_noise_rad_s: RateNoise | None = None
    """Standard deviation of a sample of the gyro; omitted: estimated from the samples."""
    usable_from_s: Seconds | None = None
    """First usable time of a run, as in the records; omitted: its first sample."""
    usable_to_s: Seconds | None = None
    """Last usable time of a run; omitted: its last sample."""
    role: Literal["fit", "heldout"] | None = None
    """Whether a diagnosis may fit the runs or holds them out; omitted: it deals them itself."""
    axes: Annotated[tuple[Literal["x", "y", "z"], ...], Strict(False), Field(min_length=1)] | None = None
    """Body axes about which the platform can turn in the runs; omitted: those that the scenario has. A channel in body
    axes may then name the fields about these alone, in this order."""
    clock: Clock = Clock()
    """The time of samples."""
    channels: Channels
    """The channels."""
    runs: Runs = WholeRun(kind="whole")
    """How the log is cut into runs."""

    @model_validator(mode="after")
    def _about_its_axes(self) -> LogMap:
        refuse(self._conflicts())
        return self

    def _conflicts(self) -> Iterator[Conflict]:
        if self.axes is not None and len(set(self.axes)) < len(self.axes):
            yield Conflict(key="axes", text=f"is {', '.join(self.axes)}, which names an axis twice; name each once")
        for name, channel in self.given.items():
            count = len(channel.fields)
            if name not in ABOUT_AXES or count == len(AXES) or count == len(self.axes or ()):
                continue
            yield Conflict(key=f"channels.{name}.fields", text=_few_fields(name, count, self.axes))

    @property
    def details(self) -> dict[str, Any]:
        """Its keys that are those of a run's NAME.toml as well."""
        return self.model_dump(include=_DETAILS, exclude_none=True)

    @property
    def given(self) -> dict[str, Channel]:
        """Its channels by name."""
        given: dict[str, Channel] = self.channels.given
        return given

    @property
    def wanted(self) -> dict[str, set[str]]:
        """The fields that are needed of each topic."""
        fields: dict[str, set[str]] = {}
        sources: list[Channel | FlagRuns] = [*self.given.values()]
        sources += [self.runs] if isinstance(self.runs, FlagRuns) else []
        for source in sources:
            named = source.fields if isinstance(source, Channel) else (source.field,)
            clock = source.time_field or self.clock.field
            fields.setdefault(source.topic, set()).update(named, () if clock is None else (clock,))
        return fields


def map_file(source: str | Path | Mapping[str, Any]) -> TextFile:
    """Return a map's file: read, or made of the keys that a program holds.

    Raises:
        InputError: it cannot be read.
    """
    if not isinstance(source, Mapping):
        return read_text(Path(source), "a map of a log", LARGEST_MAP)
    import tomli_w  # noqa: PLC0415 - only for a program's own keys

    text = tomli_w.dumps(dict(source))
    return TextFile(path=Path("map.toml"), content=text.encode("utf-8"), text=text)


def map_of(file: TextFile) -> LogMap:
    """Check a map.

    Raises:
        InputError: it is not TOML, or no map: all problems with their places.
    """
    library("pint", "converting units")
    tree = parsed_toml(file)
    try:
        log_map = LogMap.model_validate(tree)
    except ValidationError as error:
        raise InputError(problem_listing(file, error, tree, LogMap)) from None
    stated_details(file.path, log_map.details)  # refuses what no run can be, such as a span that ends before it begins
    return log_map


def _conflicts(name: str, channel: Channel) -> Iterator[Conflict]:
    count = len(channel.fields)
    signal = SIGNALS[name].sized(min(count, MOST_UNITS))
    if count != signal.width and (name not in ABOUT_AXES or count > signal.width):
        components = f" ({', '.join(signal.components)})" if signal.components else ""
        yield Conflict(
            key="fields", text=f"names {count}, but {name} has {signal.width}{components}; name one for each"
        )
    if len(set(channel.fields)) < count:
        yield Conflict(key="fields", text="names a field twice")
    if channel.scale is not None and not any(channel.scale):
        yield Conflict(key="scale", text="is zero throughout: nothing stays of the channel; leave it out")
    if channel.scale is not None and len(channel.scale) != count:
        yield Conflict(key="scale", text=f"has {len(channel.scale)} numbers for {count} fields; give one for each")
    yield from _unit_conflicts(name, channel)
    yield from _axis_conflicts(name, channel)


def _few_fields(name: str, count: int, axes: tuple[str, ...] | None) -> str:
    """Return what to say of a channel in body axes that names fewer than three fields, nor one for each axis."""
    about = f"the map's axes are {', '.join(axes)}" if axes else 'of a rig that turns about z only, say axes = ["z"]'
    return f"names {count}, but {name} has 3 (x, y, z); name one for each; {about}"


def _unit_conflicts(name: str, channel: Channel) -> Iterator[Conflict]:
    unit = SIGNALS[name].unit
    if channel.unit is None:
        if unit:
            yield Conflict(key="unit", text=f"is missing; say what the fields are in, such as {unit.replace('·', '*')}")
        return
    try:
        factor_to(channel.unit, unit)
    except InputError as error:
        yield Conflict(key="unit", text=str(error))


def _axis_conflicts(name: str, channel: Channel) -> Iterator[Conflict]:
    if channel.axes is None:
        return
    if SIGNALS[name].components not in (AXES, QUATERNION):
        yield Conflict(key="axes", text=f"is of no use: {name} has no axes; order its fields, and give signs as scale")
        return
    if len(channel.fields) < len(channel.axes):
        text = "needs three fields; order those about the map's own axes by these, and give signs as scale"
        yield Conflict(key="axes", text=text)
        return
    if len({axis[-1] for axis in channel.axes}) < 3:
        yield Conflict(key="axes", text=f"{list(channel.axes)} names an axis twice; each of x, y and z stands once")
    elif np.linalg.det(axes_matrix(channel.axes)) < 0.0 and not channel.left_handed:
        yield Conflict(
            key="axes",
            text=f"{list(channel.axes)} mirrors (determinant -1), which no mounting of a right-handed sensor does: "
            "turn one sign, or set left_handed = true if the sensor's axes are left-handed",
        )


def axes_matrix(axes: tuple[str, str, str]) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Return what takes the sensor's components to body axes, shape (3, 3): entries 0, 1 and -1."""
    matrix = np.zeros((3, 3))
    for row, axis in enumerate(axes):
        matrix[row, AXES.index(axis[-1])] = -1.0 if axis.startswith("-") else 1.0
    return matrix
