"""Every run against the model without and with the effects: rates, gimbals' channels, residuals in sigma."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import groupby

import numpy as np

from testbed.arrays import Array, Series, UnitSeries, Vectors3
from testbed.diagnosis.data import Runs
from testbed.diagnosis.fitting import fitted_initial_rates
from testbed.diagnosis.model import Fit, evaluated
from testbed.diagnosis.state import Diagnosis
from testbed.estimation.telemetry import Telemetry
from testbed.prediction.compared import torques_compared
from testbed.prediction.grid import unit_count
from testbed.prediction.servo_response import by_units, followed
from testbed.prediction.wheel_response import compared_wheels, impulse_times
from testbed.signals import unit_numbers


@dataclass(frozen=True, kw_only=True, eq=False)
class UnitResiduals:
    """One actuator in a channel.

    Attributes:
        name: what it is called, e.g. `CMG 3`.
        time: of its samples that are compared, shape (K,), s.
        measured: shape (K,).
        nominal: what the nominal model predicts, inertia and initial rates re-estimated, shape (K,).
        extended: what the model with all effects predicts, shape (K,).
    """

    name: str
    time: Series
    measured: Series
    nominal: Series
    extended: Series


@dataclass(frozen=True, kw_only=True, eq=False)
class GimbalResiduals:
    """What the gimbals' or the wheels' own channels add to a run's residual, without and with the effects in the model.

    Attributes:
        name: of the channel.
        unit: of its values.
        actuators: those that are compared, each at its own times.
    """

    name: str
    unit: str
    actuators: tuple[UnitResiduals, ...]


@dataclass(frozen=True, kw_only=True, eq=False)
class RunResiduals:
    """A run against the model without and with the effects.

    Attributes:
        name: of the run.
        held_out: whether it was not fitted.
        time: of the gyro's samples, shape (N,), s.
        measured: ω, shape (N, 3), rad/s.
        nominal: what the nominal model predicts of it, inertia and initial rates re-estimated, rad/s.
        extended: what the model with all effects predicts, rad/s.
        before: (measured - nominal) / σ, with the noise that is stated.
        after: (measured - extended) / σ, with the noise as the model has it.
        gimbal_angle: at the gyro's samples, shape (N, 6), rad; None where it is not measured.
        gimbals: the gimbals' and wheels' own channels that are compared with a prediction.
    """

    name: str
    held_out: bool
    time: Series
    measured: Vectors3
    nominal: Vectors3
    extended: Vectors3
    before: Array
    after: Array
    gimbal_angle: UnitSeries | None = None
    gimbals: tuple[GimbalResiduals, ...] = ()


def residuals_of(diagnosis: Diagnosis) -> tuple[RunResiduals, ...]:
    """Return every run, put together from its windows, against both models, held-out ones last."""
    runs, model, heldout, baseline = diagnosis.runs, diagnosis.model, diagnosis.heldout, diagnosis.baseline
    if runs.torque_noise is not None:  # which is estimated anew with every model
        baseline = evaluated(runs.as_stated(), baseline.placed, baseline.values)
    if not diagnosis.added:  # the two models differ by their noise alone
        runs, model = runs.as_stated(), baseline
        heldout = None if heldout is None else heldout.as_stated()
    shown = list(_residuals(runs, (baseline, model), held_out=False))
    if heldout is not None:
        before = fitted_initial_rates(heldout.as_stated(), baseline)
        after = fitted_initial_rates(heldout, model)
        shown += _residuals(heldout, (before, after), held_out=True)
    if not diagnosis.runs.windowed:
        return tuple(shown)
    return tuple(_together(list(windows)) for _, windows in groupby(shown, lambda run: run.name))


def _together(windows: Sequence[RunResiduals]) -> RunResiduals:
    def joined(series: Callable[[RunResiduals], Array]) -> Array:
        return np.concatenate([series(window) for window in windows])

    angles = [window.gimbal_angle for window in windows if window.gimbal_angle is not None]
    return replace(
        windows[0],
        time=joined(lambda window: window.time),
        measured=joined(lambda window: window.measured),
        nominal=joined(lambda window: window.nominal),
        extended=joined(lambda window: window.extended),
        before=joined(lambda window: window.before),
        after=joined(lambda window: window.after),
        gimbal_angle=np.concatenate(angles) if angles else None,
        gimbals=tuple(_channel_together(windows) for windows in zip(*(each.gimbals for each in windows), strict=True)),
    )


def _channel_together(windows: Sequence[GimbalResiduals]) -> GimbalResiduals:
    by_actuator = zip(*(window.actuators for window in windows), strict=True)
    return replace(windows[0], actuators=tuple(map(_actuator_together, by_actuator)))


def _actuator_together(windows: Sequence[UnitResiduals]) -> UnitResiduals:
    return replace(
        windows[0],
        time=np.concatenate([window.time for window in windows]),
        measured=np.concatenate([window.measured for window in windows]),
        nominal=np.concatenate([window.nominal for window in windows]),
        extended=np.concatenate([window.extended for window in windows]),
    )


def _residuals(runs: Runs, fits: tuple[Fit, Fit], *, held_out: bool) -> Iterator[RunResiduals]:
    before, after = (runs.by_run(fit.residual) for fit in fits)
    nominal, extended = runs.as_stated().gyro_residual(fits[0].residual), runs.gyro_residual(fits[1].residual)
    names = runs.windowed or runs.names
    for index, (name, run) in enumerate(zip(names, runs.grid.runs, strict=True)):
        yield RunResiduals(
            name=name,
            held_out=held_out,
            time=run.gyro_time,
            measured=run.body_rate,
            nominal=run.body_rate - nominal[index],
            extended=run.body_rate - extended[index],
            before=before[index],
            after=after[index],
            gimbal_angle=_angle_at_gyro(run),
            gimbals=tuple(_gimbals(runs, fits, index)),
        )


def _angle_at_gyro(run: Telemetry) -> UnitSeries | None:
    if run.gimbals is None:
        return None
    angle = np.unwrap(run.gimbals.angle, axis=0)
    return np.column_stack([np.interp(run.gyro_time, run.actuator_time, unit) for unit in angle.T])


def _gimbals(runs: Runs, fits: tuple[Fit, Fit], index: int) -> Iterator[GimbalResiduals]:
    """Yield motor torques, servo response and wheels' impulses of one run, of those that are in the residual."""
    run, count, wheels = runs.grid.runs[index], len(runs.names), compared_wheels(runs.grid)
    parts = [runs.gimbals_by_run(fit.residual)[index] for fit in fits]
    own = zip(runs.inner[index::count], runs.inner_noise[index::count], *parts, strict=True)
    series = [
        (measured, *(measured - noise.of_white(white) for white in (before, after)))
        for measured, noise, before, after in own
    ]
    of_gimbals = len(series) - len(wheels)
    for each in series[:of_gimbals]:
        if each[0].shape[1] == unit_count(runs.grid):
            yield _channel("motor torques", "N·m", run.actuator_time[torques_compared(run)], each)
        else:
            commanded = runs.grid.commanded_runs[index]
            by_unit = tuple(by_units(commanded, values) for values in each)
            name = "fast changes of the gimbal angles, in directions that hold no load"
            yield _channel(name, "rad", run.actuator_time[followed(commanded)], by_unit)
    if wheels:
        yield GimbalResiduals(
            name="impulses of the wheels' motors",
            unit="N·m·s",
            actuators=tuple(
                _actuator(
                    f"wheel {wheel + 1}", impulse_times(runs.grid, wheel)[index], [values[:, 0] for values in each]
                )
                for wheel, each in zip(wheels, series[of_gimbals:], strict=True)
            ),
        )


def _channel(name: str, unit: str, time: Series, series: Sequence[UnitSeries]) -> GimbalResiduals:
    """Return a channel of all units, each shape of `series` (K, M), at the same times."""
    names = unit_numbers(series[0].shape[1])
    actuators = [
        _actuator(f"CMG {names[unit]}", time, [each[:, unit] for each in series]) for unit in range(len(names))
    ]
    return GimbalResiduals(name=name, unit=unit, actuators=tuple(actuators))


def _actuator(name: str, time: Series, series: Sequence[Series]) -> UnitResiduals:
    measured, nominal, extended = series
    return UnitResiduals(name=name, time=time, measured=measured, nominal=nominal, extended=extended)
