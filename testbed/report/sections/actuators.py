"""The actuators: what gimbals, rotors, wheels and all of them together did, against what they may do."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from testbed.arrays import Array
from testbed.experiment.experiment import Experiment
from testbed.experiment.flying import flight_limits
from testbed.report.frame.blocks import Figure, Section
from testbed.report.frame.chart import Level, Span, line_chart, raised
from testbed.report.frame.series import component_lines, signal_lines
from testbed.report.sections.limits_table import limits_table
from testbed.report.wording import capitalized
from testbed.signals import AXES, SIGNALS, unit_numbers


def actuators_section(experiment: Experiment) -> Section:
    """Return the section of gimbals, rotors and cluster; stretches of saturation are shaded."""
    limits = flight_limits(experiment.scenario)
    figures = (
        *(_gimbal_figures(experiment) if experiment.truth.units else ()),
        _signal_figure(experiment, "true_cluster_momentum", _axis_levels(limits["cluster_momentum"])),
        _signal_figure(experiment, "true_cluster_torque", _axis_levels(limits["cluster_torque"])),
        *(_rotor_figures(experiment) if experiment.truth.units else ()),
        *(_wheel_figures(experiment) if len(experiment.truth.wheels.spin_inertia) else ()),
    )
    return Section(title="Actuators", blocks=(limits_table(experiment.flown.summary, limits), *figures))


def _gimbal_figures(experiment: Experiment) -> Iterator[Figure]:
    limits = flight_limits(experiment.scenario)
    rate, torque = _both_ways(limits["gimbal_rate"]), _both_ways(limits["gimbal_torque"])
    yield _signal_figure(experiment, "true_gimbal_rate", rate, flag="gimbal_rate_saturated")
    yield _signal_figure(experiment, "true_gimbal_torque", torque, flag="gimbal_torque_saturated")


def _rotor_figures(experiment: Experiment) -> Iterator[Figure]:
    yield _rotor_figure(experiment)
    yield _signal_figure(experiment, "singularity_measure", ())


def _wheel_figures(experiment: Experiment) -> Iterator[Figure]:
    limits = flight_limits(experiment.scenario)
    speed, torque = _both_ways(limits["wheel_speed"]), _both_ways(limits["wheel_torque"])
    yield _signal_figure(experiment, "true_wheel_speed", speed, flag="wheel_momentum_clamped")
    yield _signal_figure(experiment, "true_wheel_torque", torque, flag="wheel_torque_saturated")


def _signal_figure(experiment: Experiment, name: str, levels: Iterable[Level], flag: str | None = None) -> Figure:
    record, signal = experiment.flown.record, SIGNALS[name]
    lines = signal_lines(name, record.time, record.channels[name])
    quantity, _, remark = signal.label.removesuffix(", true").partition(", ")
    y_title = f"{quantity}, {signal.unit}" if signal.unit else quantity
    shaded = () if flag is None else _at_limit(experiment, flag)
    title = ", ".join(filter(None, [capitalized(quantity), remark, "body axes" if signal.frame == "B" else ""]))
    return Figure(
        title=title,
        chart=line_chart(lines, y_title=y_title, levels=levels, shaded=shaded),
        note=_shading_note(shaded),
        shares_time=True,
    )


def _rotor_figure(experiment: Experiment) -> Figure:
    record, shaded = experiment.flown.record, _at_limit(experiment, "rotor_momentum_clamped")
    momentum = experiment.truth.cluster.rotor_spin_inertia * record.channels["true_rotor_speed"]
    limit = Level(name="limit", values=tuple(dict.fromkeys(experiment.scenario.gyros.rotor_momentum_limit.tolist())))
    lines = component_lines(unit_numbers(momentum.shape[1]), record.time, np.asarray(momentum))
    return Figure(
        title="Rotor momentum",
        chart=line_chart(lines, y_title="rotor momentum, N·m·s", levels=[limit], shaded=shaded),
        note=_shading_note(shaded),
        shares_time=True,
    )


def _at_limit(experiment: Experiment, flag: str) -> tuple[Span, ...]:
    record = experiment.flown.record
    any_unit = np.asarray((record.channels[flag] > 0.5).any(axis=1))
    return raised(record.time, any_unit, experiment.flown.period)


def _shading_note(shaded: tuple[Span, ...]) -> str:
    return "Shaded: a unit is at this limit." if shaded else ""


def _both_ways(limits: float | Array) -> tuple[Level, ...]:
    """Return a level for each limit that some actuators share."""
    each = sorted(set(np.atleast_1d(limits).tolist()))
    return tuple(Level(name="limit", values=(limit, -limit)) for limit in each)


def _axis_levels(limits: float | Array) -> tuple[Level, ...]:
    """Return one level for all axes that share a limit."""
    limit = np.atleast_1d(limits)
    sharing = {float(value): [axis for axis, own in zip(AXES, limit, strict=True) if own == value] for value in limit}
    return tuple(Level(name=f"limit {', '.join(axes)}", values=(value, -value)) for value, axes in sharing.items())
