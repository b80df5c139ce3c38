"""What commands of wheels scatter by that change oftener than they are sampled.

Telemetry that shows one command of several says of a smooth motion what the motors were asked for in between: it lies
on a spline. What feedback makes of the gyro's noise does not: it held for one control period of several, or until the
gyro was read again. Taken for smooth, half of it would count before its sample and half behind; the motors seem to
answer late, and a delay or lags that nobody has are named for it. So commands are separated into what changes smoothly
and what scatters, as the tachometers' samples are (tachometer.py), and how much of the latter acts behind a sample and
how much before one is estimated from the impulses of all wheels.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from testbed.arrays import Array, UnitSeries
from testbed.estimation.telemetry import CommandScatter, Telemetry
from testbed.prediction.impulse_noise import SURELY, Coefficients, explained_by_wheel
from testbed.prediction.jumps import jumps, restless
from testbed.prediction.tachometer import separated_noise
from testbed.prediction.wheel_commands import ROUNDING
from testbed.prediction.wheel_impulses import Impulses, impulses_of

_FOUND = 3
"""First columns that impulses are explained by: scatter behind its sample, before it, and which share of what is smooth
is the next sample's. Behind them stand a wheel's factor, viscous and dry friction."""
_HELD = 0.6
"""Share of the interval below which scatter does not act as that of commands that hold from sample to sample, 1. Noise
of tachometers that the controller answers to makes it seem less: 0.67 where nearly all scatter is that (the shipped
CubeSat), 0.37 where five control periods pass between samples, which would be 0.3 without it."""
_PERIODS = (2, 20)
"""Fewest and most control periods between samples, where commands surely change in between: of more, a spline is as
good."""


def with_command_scatter(runs: Sequence[Telemetry]) -> list[Telemetry]:
    """Return runs of which is known how what scatters in their wheels' commands acts, if their impulses show it.

    Where commands are believed to hold from sample to sample, only if they surely change in between.

    Args:
        runs: of one platform and one controller.
    """
    scatter = _scatter(runs) if runs else None
    if scatter is None:
        return list(runs)
    held = believed_held(runs)
    response = _response(
        [with_scatter(twice_a_sample(run), each, 0.0, 0.0) for run, each in zip(runs, scatter, strict=True)], scatter
    )
    if response is None or (held and not _passes(response)):
        return list(runs)
    behind, before, next_share = response.values.tolist()
    known = [with_scatter(run, each, behind, before) for run, each in zip(runs, scatter, strict=True)]
    return [changing_between(run, next_share) for run in known] if held else known


def _passes(response: Coefficients) -> bool:
    """Return whether scatter surely acts for less than the interval between samples."""
    share, error = response.values[:2].sum(), np.sqrt(response.covariance[:2, :2].sum())
    return bool(share + SURELY * error < _HELD)


def believed_held(runs: Sequence[Telemetry]) -> bool:
    """Return whether wheels' commands are believed to hold from sample to sample."""
    if not runs or runs[0].wheels is None or runs[0].wheels.motors is None:
        return False
    return runs[0].wheels.motors.period >= (1.0 - ROUNDING) * usual_interval(runs[0])


def in_phase(run: Telemetry, phase: float, *, commanded: bool) -> Telemetry:
    """Return a run whose commands, or measured torques, are sampled at a phase of the control period."""
    if commanded:
        return run.with_motors(lambda motors: replace(motors, command_phase=phase))
    return run.with_motors(lambda motors: replace(motors, torque_phase=phase))


def usual_interval(run: Telemetry) -> float:
    """Return the interval between samples of the actuators, s."""
    return float(np.median(np.diff(run.actuator_time)))


def found_changing(runs: Sequence[Telemetry]) -> bool:
    """Return whether commands that were believed to hold from sample to sample change in between."""
    known = None if runs[0].wheels is None else runs[0].wheels.scatter
    return known is not None and known.unbelieved


def with_scatter(run: Telemetry, scatter: UnitSeries, behind: float, before: float) -> Telemetry:
    """Return a run of whose commands so much scatters, shape (K, W), N·m, and acts as `CommandScatter` has it."""
    assert run.wheels is not None
    known = CommandScatter(samples=scatter, behind=behind, before=before)
    return replace(run, wheels=replace(run.wheels, scatter=known))


def twice_a_sample(run: Telemetry) -> Telemetry:
    """Return a run whose commands change once more between samples at least: where they jump, nothing is compared."""
    half = 0.5 * usual_interval(run)
    return run.with_motors(lambda motors: replace(motors, period=min(motors.period, half)))


def share_of_next(periods: int) -> float:
    """Return the share of the next sample in the mean of commands that hold for an n-th of the interval."""
    return 0.5 - 0.5 / periods


def periods_of(next_share: float) -> int:
    """Return the number of control periods in an interval by the share of the next sample, `share_of_next`."""
    fewest, most = _PERIODS
    return int(np.clip(round(1.0 / max(1.0 - 2.0 * next_share, 1.0 / most)), fewest, most))


def changing_between(run: Telemetry, next_share: float) -> Telemetry:
    """Return a run whose commands change between samples.

    Args:
        run: in which they are believed to hold.
        next_share: of the next sample in the mean.
    """
    assert run.wheels is not None
    periods = periods_of(next_share)
    scatter = run.wheels.scatter and replace(run.wheels.scatter, unbelieved=True)
    known = replace(run, wheels=replace(run.wheels, scatter=scatter))
    return known.with_motors(lambda motors: replace(motors, period=usual_interval(run) / periods))


def _scatter(runs: Sequence[Telemetry]) -> list[UnitSeries] | None:
    """Return what of commands is no smooth motion in every run, shape (K, W), N·m; None where nothing surely is.

    Zero where commands change far more than they mostly do: beside a maneuver it is not to be seen.
    """
    commands = [None if run.wheels is None or run.wheels.motors is None else run.wheels.torque_command for run in runs]
    known = [each for each in commands if each is not None]
    if len(known) < len(runs):
        return None
    times = [run.actuator_time for run in runs]
    broken = [jumps(time, each) | restless(time, each).any(axis=1) for time, each in zip(times, known, strict=True)]
    by_wheel = [
        separated_noise(times, list(samples), broken) for samples in zip(*(each.T for each in known), strict=True)
    ]
    of_runs = [np.stack(of_run, axis=-1) for of_run in zip(*by_wheel, strict=True)]
    return of_runs if any(each.any() for each in of_runs) else None


def _response(smooth: Sequence[Telemetry], scatter: Sequence[UnitSeries]) -> Coefficients | None:
    """Return what impulses follow scattering commands by, as `_FOUND` has it, of all wheels together.

    Args:
        smooth: runs in whose impulses nothing of the scatter is.
        scatter: of every run.
    """
    impulses = [each for each in (impulses_of(run, commanded=True) for run in smooth) if each is not None]
    columns = [_columns(run, each, own) for run, each, own in zip(smooth, impulses, scatter, strict=True)]
    found = explained_by_wheel(impulses, columns, shown=_FOUND, commanded=True)
    if not found:
        return None
    pairs = [(each.values[:_FOUND], np.linalg.inv(each.covariance[:_FOUND, :_FOUND])) for each in found]
    covariance = np.linalg.inv(np.sum([information for _, information in pairs], axis=0))
    return Coefficients(covariance @ np.sum([own @ values for values, own in pairs], axis=0), covariance)


def asked_if_held(run: Telemetry) -> tuple[UnitSeries, UnitSeries]:
    """Return impulses by commands that hold from sample to sample, and by how much the next sample's are more.

    Args:
        run: whatever its commands are believed to do.

    Returns:
        Both of shape (L, W), N·m·s.
    """
    whole = usual_interval(run)
    held = run.with_motors(lambda motors: replace(motors, period=whole))
    now, following = (impulses_of(in_phase(held, phase, commanded=True), commanded=True) for phase in (0.0, 1.0))
    assert now is not None
    assert following is not None
    return now.asked, following.asked - now.asked


def _columns(smooth: Telemetry, impulses: Impulses, scatter: UnitSeries) -> Array:
    """Return what the motion took, then what may explain it, shape (1 + 6, L, W), N·m·s."""
    interval, (asked, more) = impulses.interval[:, None], asked_if_held(smooth)
    return np.stack(
        [
            impulses.needed,
            scatter[:-1] * interval,
            scatter[1:] * interval,
            more,
            asked,
            impulses.turned,
            impulses.directed,
        ]
    )
