"""The one table of signals: names, units, frames and widths.

File columns, recording paths, plot labels and the table of docs/reference/records.md all come from here.
"""

from __future__ import annotations

from collections.abc import Container, Iterator
from dataclasses import dataclass, replace

AXES = ("x", "y", "z")
UNITS = ("1", "2", "3", "4", "5", "6")
"""Names of the shipped platform's units, which documents list; a signal of another cluster is `sized`."""
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
    """Return the names of so many units: they are numbered from 1."""
    return tuple(str(number) for number in range(1, units + 1))


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
    """

    name: str
    unit: str
    frame: str = ""
    components: tuple[str, ...] = ()
    label: str
    telemetry: bool = False

    @property
    def columns(self) -> tuple[str, ...]:
        """File column of each component, such as `body_rate_x_rad_s`."""
        suffix = _COLUMN_SUFFIX[self.unit]
        middles = self.components or ("",)
        return tuple("_".join(part for part in (self.name, middle, suffix) if part) for middle in middles)

    @property
    def per_unit(self) -> bool:
        """Whether it has a component for each unit of the cluster."""
        return self.components[:1] == UNITS[:1]

    def sized(self, units: int) -> Signal:
        """Return the signal of a cluster of so many units; itself where it has no component for each."""
        return replace(self, components=unit_numbers(units)) if self.per_unit else self

    @property
    def width(self) -> int:
        """Number of components; 1 for a single number."""
        return max(1, len(self.components))


def _signal(name: str, unit: str, components: tuple[str, ...], label: str, frame: str = "") -> Signal:
    return Signal(name=name, unit=unit, frame=frame, components=components, label=label)


_TELEMETRY = (
    _signal("body_rate", "rad/s", AXES, "body rate, gyro", "B"),
    _signal("gimbal_angle", "rad", UNITS, "gimbal angle, encoder"),
    _signal("cluster_momentum", "N·m·s", AXES, "cluster momentum", "B"),
    _signal("applied_torque", "N·m", AXES, "applied torque", "B"),
    _signal("motor_thrust", "N", UNITS, "thrust of each motor, commanded"),
    _signal("gimbal_rate_command", "rad/s", UNITS, "gimbal rate, commanded"),
    _signal("gimbal_torque", "N·m", UNITS, "gimbal motor torque"),
    _signal("rotor_speed", "rad/s", UNITS, "rotor speed, tachometer"),
    _signal("attitude", "", QUATERNION, "attitude quat_NB"),
    _signal("acceleration", "m/s²", AXES, "acceleration at the centre of mass", "B"),
)
_SIMULATION = (
    _signal("true_body_rate", "rad/s", AXES, "body rate, true", "B"),
    _signal("true_gimbal_angle", "rad", UNITS, "gimbal angle, true"),
    _signal("true_gimbal_rate", "rad/s", UNITS, "gimbal rate, true"),
    _signal("true_gimbal_torque", "N·m", UNITS, "gimbal motor torque, true"),
    _signal("true_rotor_angle", "rad", UNITS, "rotor angle, true"),
    _signal("true_rotor_speed", "rad/s", UNITS, "rotor speed relative to the gimbal, true"),
    _signal("true_attitude", "", QUATERNION, "attitude quat_NB, true"),
    _signal("true_position", "m", AXES, "centre of mass, true", "N"),
    _signal("true_cluster_momentum", "N·m·s", AXES, "cluster momentum, true", "B"),
    _signal("true_total_momentum", "N·m·s", AXES, "total momentum, true", "N"),
    _signal("true_cluster_torque", "N·m", AXES, "cluster torque -dh/dt, true", "B"),
    _signal("reference_body_rate", "rad/s", AXES, "body rate, reference", "B"),
    _signal("reference_gimbal_angle", "rad", UNITS, "gimbal angle, preferred"),
    _signal("singularity_measure", "", (), "singularity measure, 1 at the best"),
    _signal("gimbal_rate_saturated", "", UNITS, "gimbal rate at its limit"),
    _signal("gimbal_torque_saturated", "", UNITS, "gimbal torque at its limit"),
    _signal("rotor_momentum_clamped", "", UNITS, "rotor momentum at its limit"),
)
SIGNALS: dict[str, Signal] = {
    signal.name: signal
    for signal in (
        *(Signal(**{**vars(signal), "telemetry": True}) for signal in _TELEMETRY),
        *_SIMULATION,
    )
}
"""Every signal by name: telemetry first, then what only a simulation knows."""


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
