"""A log map proposed from the names and units of a log: a draft for a person to check."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain

from testbed.errors import InputError
from testbed.logs.field_names import NAMED_BY_UNIT, SUFFIXES, about, in_order, is_time, parts_of, without_unit
from testbed.logs.map import ABOUT_AXES
from testbed.logs.streams import TABLE, Log, Topic
from testbed.logs.units import is_unit_of
from testbed.signals import AXES, QUATERNION, SIGNALS, TURNED_BY, unit_numbers

_WHEEL = r"((?<!fly)wheel|(?<![a-z])(rw|whl)s?(?![a-z]))"
_COMMAND = r"(cmd|command|set|ref)"
_TORQUE = r"(torque|(?<![a-z])tr?q(?![a-z]))"
_NO_SPEED = r"(?!.*(current|volt|temp|power|(?<![a-z])amps?(?![a-z])))"
_NAMES: Mapping[str, tuple[tuple[str, int], ...]] = {
    "body_rate": (
        (r"vehicle_angular_velocity(?! *\[)", 12),
        (r"angular_?(vel(ocity)?|rates?)|body_?rates?|ang_?vel", 10),
        (r"gyro(scope)?(meter)?|(?<![a-z])gyr(?![a-z])", 9),
        (r"omega|(?<![a-z])(w|rates?|pqr|imu)(?![a-z])", 7),
        (r"(?<![a-z])g(?![a-z])", 4),
    ),
    "gimbal_angle": ((r"gimbal.*(angle|pos|enc)|(angle|pos|enc).*gimbal", 10), (r"(?<![a-z])gim(bal)?s?$", 5)),
    "gimbal_rate_command": (
        (rf"gimbal.*rate.*{_COMMAND}|{_COMMAND}.*gimbal.*rate", 11),
        (rf"(?<![a-z])gim(bal)?s?_?{_COMMAND}", 9),
    ),
    "gimbal_torque": ((r"gimbal.*torque|torque.*gimbal", 11),),
    "rotor_speed": (
        (r"(rotor|flywheel).*(speed|rate|rpm|omega)|(speed|rpm).*(rotor|flywheel)", 10),
        (r"(?<![a-z])(rotor|flywheel)s?$", 3),
    ),
    "wheel_speed": (
        (rf"{_WHEEL}.*(speed|rate|rpm|omega)|(speed|rpm).*{_WHEEL}", 10),
        (rf"(?<![a-z])(rw|whl)s?(?![a-z]){_NO_SPEED}(?!.*{_TORQUE})", 8),
        (r"(?<![a-z])wheels?$", 4),
    ),
    "wheel_torque_command": (
        (rf"{_WHEEL}.*{_TORQUE}.*{_COMMAND}|{_COMMAND}.*{_WHEEL}.*{_TORQUE}", 12),
        (rf"motor.*{_TORQUE}.*{_COMMAND}|{_COMMAND}.*motor.*{_TORQUE}", 9),
        (rf"(?<![a-z])(wheel|rw|whl)s?_?{_COMMAND}{_NO_SPEED}(?!.*(speed|rate|rpm|omega))", 10),
    ),
    "wheel_torque": (
        (rf"{_WHEEL}.*{_TORQUE}|{_TORQUE}.*{_WHEEL}", 11),
        (rf"(?<![a-z])rws?(?![a-z]){_NO_SPEED}(?!.*(speed|rate|rpm|omega|{_COMMAND}))", 8),
    ),
    "motor_thrust": ((r"thrust", 8),),
    "cluster_momentum": ((r"(cluster|cmg|wheel).*momentum|momentum", 8), (r"(?<![a-z])h(?![a-z])", 4)),
    "applied_torque": (
        (rf"{_TORQUE}|wrench", 8),
        (r"(?<![a-z])(tau|moments?)(?![a-z])", 7),
        (r"(?<![a-z])m(?![a-z])", 4),
    ),
    "attitude": ((r"quat(ernion)?|orientation|attitude", 8), (r"(?<![a-z])q(?![a-z])", 6)),
    "acceleration": ((r"linear_?acc|accel|(?<![a-z])acc(?![a-z])", 8), (r"(?<![a-z])a(?![a-z])", 4)),
}
"""What topics and fields are called that hold a channel, with how much each name says."""
_OTHERS = re.compile(
    r"cov|bias|offset|var(iance)?(?![a-z])|std|(?<![a-z])(sp|ref|cmd|des)(?![a-z])|set_?point|desired|target|reference"
    r"|(?<![a-z])(force|position|pos|linear_velocity)(?![a-z])|command|error|temp|(?<![a-z])raw(?![a-z])|delta|integral|vibration|status|deriv|groundtruth|true_"
)
"""Names of what belongs to a channel and is not its measurement."""
_FLAG = re.compile(r"armed|(?<![a-z])(flag|active|enabled?|in_?flight|free_?fall|released?)(?![a-z])")
"""Names of a flag that may say when a run lasts."""
_SINCE_1970 = {"s": 1e9, "ms": 1e12, "us": 1e15, "ns": 1e18}
"""A clock since 1970 in each unit has shown more than this since 2001, and less than four times this until 2096."""
_NORMALIZED = {"vehicle_torque_setpoint": "PX4 normalizes it to -1 ... 1"}
"""Topics without a unit."""
_SI = {"ULog": "PX4 logs SI", "ROS bag": "ROS messages are SI (REP 103)"}
_UNCHECKED = "# CHECK"
"""What stands behind a proposed value that the log does not state, until a person has taken it away."""
_LEAST_SCORE = 5
_LONE = 3
"""What a single number says less than one of several: a name is often that of another thing."""
_FEWER_AXES = (("x", "y"), ("x", "z"), ("y", "z"), ("z",), ("x",), ("y",))
"""Body axes of rigs, the usual first: a single number whose name says no axis is about z."""
_MOST_LISTED = 20
"""Topics that no channel takes, and fields of one, that are listed."""


@dataclass(frozen=True, kw_only=True)
class _Candidate:
    """Fields that may be a channel.

    Attributes:
        channel: name of it.
        topic: of the fields.
        fields: in the order of its components.
        unit: of the fields; empty where none is known.
        why: what this is taken from.
        score: how much the names say.
        by_unit: whether no name says so, but the unit and the number of fields.
    """

    channel: str
    topic: str
    fields: tuple[str, ...]
    unit: str
    why: str
    score: int
    by_unit: bool = False


def guessed_map(log: Log) -> str:
    """Return the text of a map for a log, with what each line was taken from.

    Raises:
        InputError: the log cannot be read, or nothing in it has the name of a body rate; the message lists what it has.
    """
    survey = log.survey()
    axes, best = next(
        ((axes, best) for axes in (AXES, *_FEWER_AXES) if "body_rate" in (best := _best(log, survey, axes))), (AXES, {})
    )
    if not best:
        raise InputError(
            f"{log.path}: nothing in it is called a gyro or a body rate; write a map that names three fields under "
            f"[channels.body_rate]; the log holds\n  {_inventory(survey)}"
        )
    blocks = [_head(log) + _turning(axes, best["body_rate"][0], survey), _clock(survey) if TABLE in survey else ""]
    # A ULog's own time is of the clock that its samples' stamps are of.
    stamped = log.format != "ULog" and any(_own_clock(survey[best[name][0].topic]) for name in SIGNALS if name in best)
    blocks += [_channel(name, best[name], survey, stamped=stamped) for name in SIGNALS if name in best]
    blocks += [_missing(best, survey), _runs(survey), _left_out(best, survey)]
    return "\n".join(block for block in blocks if block)


def unchecked_lines(text: str) -> tuple[str, ...]:
    """Return lines of a map, with their numbers, that were proposed without a statement of the log and stayed so."""
    lines = enumerate(text.splitlines(), start=1)
    return tuple(f"line {number}: {line.strip()}" for number, line in lines if _UNCHECKED in line)


def _best(log: Log, survey: Mapping[str, Topic], axes: Sequence[str]) -> dict[str, list[_Candidate]]:
    """Return what may be each channel, the best first, of a platform that turns about some body axes."""
    best: dict[str, list[_Candidate]] = {}
    for candidate in sorted(_candidates(log, survey, axes), key=lambda each: -each.score):
        best.setdefault(candidate.channel, []).append(candidate)
    return best


def _candidates(log: Log, survey: Mapping[str, Topic], axes: Sequence[str]) -> Iterator[_Candidate]:
    for name, topic in survey.items():
        groups: dict[tuple[str, str], dict[str, str]] = {}
        for field in topic.fields:
            for part in parts_of(field, topic.units.get(field, "")):
                groups.setdefault((part.stem, part.unit), {}).setdefault(part.component, part.field)
        for (stem, unit), fields in groups.items():
            yield from _matches(log, name, topic, stem, unit, fields, axes)


def _matches(
    log: Log, name: str, topic: Topic, stem: str, unit: str, fields: Mapping[str, str], axes: Sequence[str]
) -> Iterator[_Candidate]:
    """Yield the channels that a group of fields may be, by its names and their number."""
    said = {channel: _said_within(patterns, name, stem) for channel, patterns in _NAMES.items()}
    whole = re.split(r"[./]", stem.lower())[-1]
    unit = unit or (SUFFIXES[whole] if whole in NAMED_BY_UNIT else "")
    if unit and not any(said.values()):
        yield from _by_unit(name, unit, fields, others=bool(_OTHERS.search(f"{name} {stem}".lower())))
    for channel, patterns in _NAMES.items():
        ordered = in_order(SIGNALS[channel].sized(len(fields)).components, fields)
        if ordered is None and channel in ABOUT_AXES and len(axes) < len(AXES):
            ordered = about(axes, fields)
        if ordered is None or (unit and not is_unit_of(unit, SIGNALS[channel].unit)):
            continue
        own, above = said[channel], _said(patterns, name)
        if own < max(said.values()):
            continue  # the fields' own name is that of another channel
        measured = channel.endswith("_command") or name.partition("[")[0] in _NORMALIZED
        others = not measured and _OTHERS.search(f"{name} {stem}".lower())
        score = max(own + 1 if own else 0, above) - (6 if others else 0) - (_LONE if "" in fields else 0)
        if score < _LEAST_SCORE and not (own and unit):
            continue
        convention = _SI.get(log.format, "") or ("ROS messages are SI (REP 103)" if "/msg/" in topic.kind else "")
        why = f"the name {stem or name!r}" if own or not above else f"the name of the topic, {name!r}"
        yield _Candidate(
            channel=channel,
            topic=name,
            fields=ordered,
            unit=unit or (SIGNALS[channel].unit.replace("·", "*").replace("²", "^2") if convention else ""),
            why=f"{why}; unit: {'stated' if unit else convention or 'NOT STATED'}",
            score=score,
        )


def _by_unit(topic: str, unit: str, fields: Mapping[str, str], *, others: bool) -> Iterator[_Candidate]:
    """Yield what fields may be whose names say nothing, but their unit: what turns is numbered, or has three axes.

    Args:
        topic: of the fields.
        unit: of the fields.
        fields: by component.
        others: whether a name is that of what belongs to a channel; of torques, a command is a channel itself.
    """
    numbered = all(component.isdigit() for component in fields)
    of_wheels = () if others else ("wheel_speed",)
    for channel in (*of_wheels, "wheel_torque_command") if numbered else () if others else ("body_rate",):
        components = unit_numbers(len(fields)) if numbered else AXES
        ordered = in_order(components, fields)
        if ordered is not None and len(fields) == len(components) and is_unit_of(unit, SIGNALS[channel].unit):
            why = f"the unit {unit} of {len(fields)} fields"
            yield _Candidate(channel=channel, topic=topic, fields=ordered, unit=unit, why=why, score=0, by_unit=True)


def _said(patterns: Sequence[tuple[str, int]], name: str) -> int:
    """Return how much a name says for a channel; 0 where it says nothing."""
    return max((score for pattern, score in patterns if re.search(pattern, name.lower())), default=0)


def _said_within(patterns: Sequence[tuple[str, int]], topic: str, name: str) -> int:
    """Return how much a field's name says, by itself or with that of its topic: `wheels` and `torque`."""
    together = _said(patterns, f"{topic} {name}")
    return max(_said(patterns, name), together if together > _said(patterns, topic) else 0)


def _head(log: Log) -> str:
    return (
        f"# Map of {log.path.name} ({log.format}), proposed from names and units.\n"
        "# Check every line, above all units, axes and clock. Then:\n"
        "# testbed import LOG --map MAP.toml --out FOLDER\n"
        "schema = 1\n"
    )


def _turning(axes: Sequence[str], chosen: _Candidate, survey: Mapping[str, Topic]) -> str:
    """Return the line on the body axes about which a rig turns; empty where the gyro has all three."""
    if len(axes) == len(AXES):
        return ""
    named = any(part.component and part.field == chosen.fields[0] for part in parts_of(chosen.fields[0], ""))
    why = "of the gyro there is no more" if named else "CHECK: one field, and no name says about which axis"
    dead = [field for field in survey[chosen.topic].empty if any(part.component for part in parts_of(field, ""))]
    if named and dead:
        why = f"CHECK: {', '.join(dead)} {'holds' if len(dead) == 1 else 'hold'} no number"
    return f"axes = {json.dumps(list(axes))}  # {why}\n"


def _clock(survey: Mapping[str, Topic]) -> str:
    field = _clock_field(survey[TABLE])
    if not field:
        return '[clock]\nfield = "?"  # CHECK: no column is called time\nunit = "s"\n'
    unit, why = _unit_stated(field, survey[TABLE]), "unit: stated"
    if not unit:
        unit, why = _unit_of_clock(survey[TABLE].fields[field])
    doubt = "" if is_time(field) else "  # CHECK: no name says so, but its unit"
    return f"[clock]\nfield = {_text(field)}{doubt}\nunit = {_text(unit)}  # {why}\n"


def _clock_field(table: Topic) -> str:
    """Return the column that is called a time, or else the first whose unit is one; empty where there is none."""
    units = {field: _unit_stated(field, table) for field in table.fields}
    in_time = [field for field, unit in units.items() if unit and is_unit_of(unit, "s")]
    called = (field for field, unit in units.items() if is_time(field) and (not unit or field in in_time))
    return next(chain(called, in_time), "")


def _unit_stated(field: str, topic: Topic) -> str:
    return topic.units.get(field, without_unit(field)[1])


def _unit_of_clock(first: float) -> tuple[str, str]:
    for unit, least in _SINCE_1970.items():
        if least <= first < 4 * least:
            return unit, f"its first value, {first:.10g}, is a time since 1970 in {unit}"
    return "s", "CHECK: the log does not state it"


def _channel(name: str, candidates: Sequence[_Candidate], survey: Mapping[str, Topic], *, stamped: bool) -> str:
    """Return the table of a channel.

    Args:
        name: of it.
        candidates: the best first.
        survey: of the log.
        stamped: whether another channel's messages say when they were sampled.
    """
    chosen, others = candidates[0], candidates[1:]
    lines = [f"# From {chosen.why}.", f"[channels.{name}]"]
    if chosen.topic != TABLE:
        lines.append(f"topic = {_text(chosen.topic)}")
    by_number = all(field.rstrip("])")[-1:].isdigit() for field in chosen.fields)
    doubt = "  # CHECK: taken for w, x, y, z" if SIGNALS[name].components == QUATERNION and by_number else ""
    if chosen.by_unit:
        doubt = "  # CHECK: no name says so"
    lines.append(f"fields = [{', '.join(map(_text, chosen.fields))}]{doubt}")
    normalized = _NORMALIZED.get(chosen.topic.partition("[")[0])
    if SIGNALS[name].unit:
        unit = chosen.unit or SIGNALS[name].unit.replace("·", "*").replace("²", "^2")
        lines.append(f"unit = {_text(unit)}" + ("" if chosen.unit else "  # CHECK: the log does not state it"))
    if clock := _own_clock(survey[chosen.topic]):
        lines += clock
    elif stamped and chosen.topic != TABLE:
        lines.append(f"{_UNCHECKED}: no time_field: its messages bear the log's time, others that of their sampling")
    if normalized:
        values = ", ".join(["1.0"] * len(chosen.fields))
        lines.append(f"scale = [{values}]  # {normalized}: give the torque at 1, N*m")
        lines = [line if line.startswith("#") else f"# {line}" for line in lines]
    lines += [
        f"# or {_text(other.topic) + ' ' if other.topic else ''}{', '.join(other.fields)}" for other in others[:3]
    ]
    return "\n".join(lines) + "\n"


def _own_clock(topic: Topic) -> list[str]:
    """Return the lines on the time at which a message was sampled; none where only the log's own is there."""
    if not topic.received:
        return []
    stated = [field for field, unit in topic.units.items() if unit in ("ns", "us") and field != "timestamp"]
    if field := next((field for field in stated if re.search(r"stamp_sample$|stamp$", field)), ""):
        return [f"time_field = {_text(field)}"]
    named = (field for field in topic.fields if field not in topic.units and is_time(re.split(r"[./]", field)[-1]))
    if field := next(named, ""):
        unit, why = without_unit(field)[1], "from its name"
        if not (unit and is_unit_of(unit, "s")):
            unit, why = _unit_of_clock(topic.fields[field])
        return [f"time_field = {_text(field)}  # CHECK: by its name", f"time_unit = {_text(unit)}  # {why}"]
    return []


def _missing(best: Mapping[str, Sequence[_Candidate]], survey: Mapping[str, Topic]) -> str:
    """Return what a map still needs, as a comment; empty where it has a channel that says what turned the platform."""
    turning = [name for name in TURNED_BY if name in best]
    if any(best[name][0].topic.partition("[")[0] not in _NORMALIZED for name in turning):
        return ""
    topic = "" if TABLE in survey else '# topic = "that holds them"\n'
    others = "" if TABLE in survey else _other_topics(best, survey)
    return (
        f"# CHECK: no channel here says what turned the platform: add one of {', '.join(TURNED_BY)}, such as\n"
        f"# [channels.wheel_speed]\n{topic}"
        f'# fields = ["first wheel", "second wheel", "third wheel"]\n# unit = "rpm"\n{others}'
    )


def _other_topics(best: Mapping[str, Sequence[_Candidate]], survey: Mapping[str, Topic]) -> str:
    """Return the topics with numbers that no channel takes, as comments; the first of many."""
    taken = {each[0].topic for each in best.values()}
    others = {name: list(topic.fields) for name, topic in survey.items() if topic.fields and name not in taken}
    lines = [f"#   {_few(name, fields)}\n" for name, fields in list(others.items())[:_MOST_LISTED]]
    more = f"#   and {len(others) - _MOST_LISTED} more\n" if len(others) > _MOST_LISTED else ""
    return "".join(["# Topics without a channel:\n", *lines, more]) if others else ""


def _few(name: str, fields: Sequence[str]) -> str:
    more = f" and {len(fields) - _MOST_LISTED} more" if len(fields) > _MOST_LISTED else ""
    return f"{_text(name)}: {', '.join(map(_text, fields[:_MOST_LISTED]))}{more}"


def _left_out(best: Mapping[str, Sequence[_Candidate]], survey: Mapping[str, Topic]) -> str:
    """Return the columns of a table that no channel takes, as a comment; logs with topics hold too many others."""
    if TABLE not in survey:
        return ""
    taken = {_clock_field(survey[TABLE]), *(field for each in best.values() for field in each[0].fields)}
    others = [field for field in survey[TABLE].fields if field not in taken and not is_time(field)]
    said = f"# Columns without a channel: {', '.join(map(_text, others))}\n" if others else ""
    empty = survey[TABLE].empty
    return said + (f"# Columns without a number: {', '.join(map(_text, empty))}\n" if empty else "")


def _runs(survey: Mapping[str, Topic]) -> str:
    lines = ["# The whole log is one run. Otherwise, one of these:"]
    flags = [(name, field) for name, topic in survey.items() for field in topic.fields if _FLAG.search(field)]
    if flags:
        topic, field = flags[0]
        lines += ["# [runs]", '# kind = "flag"', *([f"# topic = {_text(topic)}"] if topic else [])]
        lines += [f"# field = {_text(field)}", "# above = 0.5"]
    lines += ["# [runs]", '# kind = "gaps"', "# longer_than_s = 1.0"]
    lines += ["# [runs]", '# kind = "times"', "# spans_s = [[0.0, 10.0], [20.0, 30.0]]"]
    return "\n".join(lines) + "\n"


def _inventory(survey: Mapping[str, Topic]) -> str:
    held = [
        f"{name + ': ' if name else ''}{', '.join(list(topic.fields)[:_MOST_LISTED])}"
        for name, topic in survey.items()
        if topic.fields
    ]
    return "\n  ".join(held or ["no column of numbers"])


def _text(text: str) -> str:
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")  # JSON leaves DEL, TOML refuses it
