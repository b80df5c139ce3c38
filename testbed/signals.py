"""The one table of signals: names, units, frames and widths.

File columns, recording paths, plot labels and the table of docs/reference/records.md all come from here.
"""

from __future__ import annotations

from collections.abc import Container, Iterator
from dataclasses import dataclass, replace
from functools import partial
from typing import Literal, TypeAlias

AXES = ("x", "y", "z")
MOST_UNITS = 24
"""Of a cluster. The largest that has flown is of six; an optimiser's time grows with the square of the number."""
QUATERNION = ("w", "x", "y", "z")

_COLUMN_SUFFIX = {
    "rad": "rad",
    "rad/s": "rad_s",
    "N·m": "N_m",
    "N·m·s": "N_m_s",
    "m": "m",
    "m/s²": "m_s2",
    "N": "N",
    "": "",
}


def unit_numbers(units: int) -> tuple[str, ...]:
    """Return the names of a number of units, which count from 1."""
    return tuple(str(number) for number in range(1, units + 1))


Kind: TypeAlias = Literal["unit", "wheel", "motor"]
"""Control moment gyro, reaction wheel, or motor with a propeller or jet."""


@dataclass(frozen=True, kw_only=True)
class KindOfActuator:
    """Actuators of one kind; a platform numbers those that it has from 1.

    Attributes:
        prefix: of a single one's name, as in `cmg3`: of components of effects, elements of models, lanes and lines.
        called: what a sentence calls one of a number.
        usual: numbers that documents list; a signal of another platform is `sized`.
        plots: quantities of each that a recording plots.
    """

    prefix: str
    called: str
    usual: tuple[str, ...]
    plots: tuple[str, ...] = ()


KINDS: dict[Kind, KindOfActuator] = {
    "unit": KindOfActuator(
        prefix="cmg",
        called="CMG",
        usual=unit_numbers(6),
        plots=("gimbal_angle", "gimbal_rate", "gimbal_torque", "rotor_speed"),
    ),
    "wheel": KindOfActuator(
        prefix="wheel",
        called="Wheel",
        usual=unit_numbers(4),
        plots=("wheel_speed", "wheel_torque"),
    ),
    "motor": KindOfActuator(prefix="motor", called="Motor", usual=unit_numbers(4)),
}
"""Every kind of actuator that signals are of."""


@dataclass(frozen=True, kw_only=True)
class Signal:
    """One signal of a run.

    Attributes:
        name: the channel's key in a record.
        unit: SI unit as printed; empty for a pure number.
        frame: the frame of its components (N, B), or empty.
        components: what its components are called; empty for a single number.
        label: what a plot calls it.
        telemetry: whether a flown platform can send it (the columns of docs/reference/records.md), or only a
            simulation knows it.
        per: the kind of actuator for each of which it has a component; empty for none.
        reached: of a flag, the limit that is reached while it is up; empty for what is none.
        held: what an actuator then is, in a sentence.
        of_momentum: whether it is a limit of momentum, which a motor does not push beyond.
    """

    name: str
    unit: str
    frame: str = ""
    components: tuple[str, ...] = ()
    label: str
    telemetry: bool = False
    per: Literal["", "unit", "wheel", "motor"] = ""
    reached: str = ""
    held: str = ""
    of_momentum: bool = False

    @property
    def columns(self) -> tuple[str, ...]:
        """File column of each component, such as `body_rate_x_rad_s`."""
        suffix = _COLUMN_SUFFIX[self.unit]
        middles = self.components or ("",)
        return tuple("_".join(part for part in (self.name, middle, suffix) if part) for middle in middles)

    @property
    def per_unit(self) -> bool:
        """Whether it has a component for each unit of the cluster, each wheel or each motor."""
        return bool(self.per)

    def sized(self, units: int) -> Signal:
        """Return the signal of so many units, wheels or motors; itself where it has no component for each."""
        return replace(self, components=unit_numbers(units)) if self.per_unit else self

    @property
    def width(self) -> int:
        """Number of components; 1 for a single number."""
        return max(1, len(self.components))


def _signal(name: str, unit: str, components: tuple[str, ...], label: str, frame: str = "") -> Signal:
    return Signal(name=name, unit=unit, frame=frame, components=components, label=label)


def _of_each(kind: Kind, name: str, unit: str, label: str) -> Signal:
    return Signal(name=name, unit=unit, components=KINDS[kind].usual, label=label, per=kind)


_per_unit, _per_wheel, _per_motor = partial(_of_each, "unit"), partial(_of_each, "wheel"), partial(_of_each, "motor")


def _flag(of: Signal, reached: str, held: str, *, of_momentum: bool = False) -> Signal:
    return replace(of, reached=reached, held=held, of_momentum=of_momentum)


_TELEMETRY = (
    _signal("body_rate", "rad/s", AXES, "body rate, gyro", "B"),
    _per_unit("gimbal_angle", "rad", "gimbal angle, encoder"),
    _signal("cluster_momentum", "N·m·s", AXES, "cluster momentum", "B"),
    _signal("applied_torque", "N·m", AXES, "applied torque", "B"),
    _per_motor("motor_thrust", "N", "thrust of each motor, commanded"),
    _per_unit("gimbal_rate_command", "rad/s", "gimbal rate, commanded"),
    _per_unit("gimbal_torque", "N·m", "gimbal motor torque"),
    _per_unit("rotor_speed", "rad/s", "rotor speed, tachometer"),
    _per_wheel("wheel_speed", "rad/s", "wheel speed, tachometer"),
    _per_wheel("wheel_torque_command", "N·m", "wheel torque, commanded"),
    _per_wheel("wheel_torque", "N·m", "wheel motor torque"),
    _signal("attitude", "", QUATERNION, "attitude quat_NB"),
    _signal("acceleration", "m/s²", AXES, "acceleration at the centre of mass", "B"),
)
_SIMULATION = (
    _signal("true_body_rate", "rad/s", AXES, "body rate, true", "B"),
    _per_unit("true_gimbal_angle", "rad", "gimbal angle, true"),
    _per_unit("true_gimbal_rate", "rad/s", "gimbal rate, true"),
    _per_unit("true_gimbal_torque", "N·m", "gimbal motor torque, true"),
    _per_unit("true_rotor_angle", "rad", "rotor angle, true"),
    _per_unit("true_rotor_speed", "rad/s", "rotor speed relative to the gimbal, true"),
    _per_wheel("true_wheel_angle", "rad", "wheel angle, true"),
    _per_wheel("true_wheel_speed", "rad/s", "wheel speed relative to the body, true"),
    _per_wheel("true_wheel_torque", "N·m", "wheel motor torque, true"),
    _signal("true_attitude", "", QUATERNION, "attitude quat_NB, true"),
    _signal("true_position", "m", AXES, "centre of mass, true", "N"),
    _signal("true_cluster_momentum", "N·m·s", AXES, "cluster momentum, true", "B"),
    _signal("true_total_momentum", "N·m·s", AXES, "total momentum, true", "N"),
    _signal("true_cluster_torque", "N·m", AXES, "cluster torque -dh/dt, true", "B"),
    _signal("reference_body_rate", "rad/s", AXES, "body rate, reference", "B"),
    _per_unit("reference_gimbal_angle", "rad", "gimbal angle, preferred"),
    _per_wheel("reference_wheel_speed", "rad/s", "wheel speed, preferred"),
    _signal("singularity_measure", "", (), "singularity measure, 1 at the best"),
    _flag(
        _per_unit("gimbal_rate_saturated", "", "gimbal rate at its limit"), "gimbal rate", "at the gimbal-rate limit"
    ),
    _flag(
        _per_unit("gimbal_torque_saturated", "", "gimbal torque at its limit"),
        "gimbal torque",
        "at the gimbal-torque limit",
    ),
    _flag(
        _per_unit("rotor_momentum_clamped", "", "rotor momentum at its limit"),
        "rotor momentum",
        "clamped at the rotor-momentum limit",
        of_momentum=True,
    ),
    _flag(
        _per_wheel("wheel_torque_saturated", "", "wheel torque at its limit"),
        "wheel torque",
        "at the wheel-torque limit",
    ),
    _flag(
        _per_wheel("wheel_momentum_clamped", "", "wheel momentum at its limit"),
        "wheel momentum",
        "held at the wheel-momentum limit",
        of_momentum=True,
    ),
)
SIGNALS: dict[str, Signal] = {
    signal.name: signal
    for signal in (
        *(Signal(**{**vars(signal), "telemetry": True}) for signal in _TELEMETRY),
        *_SIMULATION,
    )
}
"""Every signal by name: telemetry first, then what only a simulation knows."""


TURNED_BY = ("gimbal_angle", "wheel_speed", "cluster_momentum", "applied_torque", "motor_thrust")
"""Signals of which one says what turned the platform; the first that a record has counts. Thrusts do so with the
scenario's `[[thrusters]]`."""
FLAGS = tuple(signal for signal in SIGNALS.values() if signal.reached)
"""Signals that say which limit an actuator is at."""
LIMITS: dict[str, str] = {
    "gimbal_rate": "gimbal rate",
    "gimbal_torque": "gimbal motor torque",
    "cluster_momentum": "cluster momentum",
    "cluster_torque": "cluster torque",
    "wheel_torque": "wheel motor torque",
    "wheel_speed": "wheel speed",
}
"""Quantities that have a limit, by the name that a flight's summary gives them; `true_` before it is the signal."""


def present_signals(columns: Container[str]) -> Iterator[Signal]:
    """Yield the signals of which a table has columns, in order.

    One with a component for each unit has as many of them as there are columns, without a gap from the first one on.

    Args:
        columns: names of the table's columns.
    """
    for signal in SIGNALS.values():
        if not signal.per_unit and any(column in columns for column in signal.columns):
            yield signal
        elif signal.per_unit:
            units = sum(column in columns for column in signal.sized(MOST_UNITS).columns)
            if units:
                yield signal.sized(units)
