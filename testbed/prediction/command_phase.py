"""When wheels' commands change between the samples of their telemetry.

A command holds for a control period. Telemetry that is not sampled at the instant of the change shows a command that
will end before the next sample: the impulse in between is (1 - p) of this command's and p of the next one's, where p is
the share of the period that had passed at the sample. Taken for p = 0, the wheels seem to run ahead of their commands,
and friction that nobody has is named for it. A measured torque is what the motor gave until its sample, or, of another
recorder, what it gives at that instant and goes on to give: the same holds of it, the other way round.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from testbed.arrays import Array
from testbed.estimation.telemetry import Telemetry
from testbed.prediction.command_scatter import believed_held, with_command_scatter
from testbed.prediction.impulse_noise import impulse_fit, wheels_with
from testbed.prediction.wheel_impulses import Impulses, impulses_of, without_correlation

_UNKNOWNS = 4
"""Of a wheel: its factor, the phase, viscous and dry friction. A lag of its motor is a phase below zero, of this wheel
alone."""
_FEWEST = 20
"""Impulses for each unknown from which a phase is looked for."""
_SURELY = 5.0
"""Standard errors of the median wheel by which a phase has to differ from none: by chance in three of ten million."""


def with_command_phase(runs: Sequence[Telemetry]) -> list[Telemetry]:
    """Return runs whose wheels' commands are known to change between samples, where impulses show that they do.

    Commands of several control periods between samples are compared with what they scatter by apart. Those that are
    believed to hold from sample to sample, and do not change with them, may do the same.

    Args:
        runs: of one platform; its telemetry is sampled at the same phase of the control period in all.
    """
    runs = _with_phase(runs, commanded=False)
    if not believed_held(runs):
        return _with_phase(with_command_scatter(runs), commanded=True)
    held = _with_phase(runs, commanded=True)
    changing = with_command_scatter(runs) if command_phase(held) else list(runs)
    return held if believed_held(changing) else _with_phase(changing, commanded=True)


def _with_phase(runs: Sequence[Telemetry], *, commanded: bool) -> list[Telemetry]:
    now, following = (
        [impulses for run in runs if (impulses := _at_phase(run, phase, commanded=commanded)) is not None]
        for phase in (0.0, 1.0)
    )
    wheels = wheels_with(now, _FEWEST * _UNKNOWNS)
    if len(now) < len(runs) or not wheels:
        return list(runs)
    noise = impulse_fit(now, wheels, commanded=commanded).noise
    pairs = zip(now, following, strict=True)
    columns = zip(*(without_correlation(one, noise, _columns(one, other)) for one, other in pairs), strict=True)
    by_wheel = [np.concatenate(of_runs, axis=-1) for of_runs in columns]
    asked = [_of_wheel(each) for each in by_wheel if each[1].any()]  # a wheel that coasts shows no phase
    phase = _common(np.array(asked)) if asked else 0.0
    return [_in_phase(run, phase, commanded=commanded) for run in runs] if phase else list(runs)


def command_phase(runs: Sequence[Telemetry]) -> float:
    """Return how long the commands of runs have held when they are sampled, s."""
    motors = [run.wheels.motors for run in runs if run.wheels is not None and run.wheels.motors is not None]
    return motors[0].command_phase * motors[0].period if motors else 0.0


def torque_phase(runs: Sequence[Telemetry]) -> float:
    """Return how long the measured torques of runs go on when they are sampled, s."""
    motors = [run.wheels.motors for run in runs if run.wheels is not None and run.wheels.motors is not None]
    return motors[0].torque_phase * motors[0].period if motors else 0.0


def _common(by_wheel: Array) -> float:
    """Return the phase that the median wheel has; 0 where it shows none.

    Args:
        by_wheel: phase and its standard error, shape (C, 2).
    """
    phase, error = by_wheel.T
    surely = np.median(phase / error) > _SURELY
    return float(np.clip(np.median(phase), 0.0, 1.0)) if surely else 0.0


def _of_wheel(columns: Array) -> tuple[float, float]:
    """Return the phase of one wheel and its standard error, by weighted least squares.

    Args:
        columns: what its motion took, then what may explain it, without correlation, shape (1 + 4, K), N·m·s.
    """
    length = np.maximum(np.linalg.norm(columns, axis=1), np.finfo(float).tiny)
    needed, others = columns[0], (columns[1:] / length[1:, None]).T
    inverse = np.linalg.pinv(others)
    values = inverse @ needed
    variance = float(np.square(needed - others @ values).sum()) / (len(needed) - _UNKNOWNS)
    covariance = variance * (inverse @ inverse.T)
    factor = values[0] / length[1]
    error = float(np.sqrt(covariance[1, 1])) / length[2]
    return float(values[1] / length[2] / factor), max(error / abs(factor), np.finfo(float).tiny)


def _columns(now: Impulses, following: Impulses) -> Array:
    """Return what the motion took, then what may explain it, shape (1 + 4, L, W), N·m·s."""
    return np.stack([now.needed, now.asked, following.asked - now.asked, now.turned, now.directed])


def _at_phase(run: Telemetry, phase: float, *, commanded: bool) -> Impulses | None:
    return impulses_of(_in_phase(run, phase, commanded=commanded), commanded=commanded)


def _in_phase(run: Telemetry, phase: float, *, commanded: bool) -> Telemetry:
    if run.wheels is None or run.wheels.motors is None:
        return run
    motors = run.wheels.motors
    known = replace(motors, command_phase=phase) if commanded else replace(motors, torque_phase=phase)
    return replace(run, wheels=replace(run.wheels, motors=known))
