"""When wheels' commands change between the samples of their telemetry.

A command holds for a control period. Telemetry that is not sampled at the instant of the change shows a command that
will end before the next sample: the impulse in between is (1 - p) of this command's and p of the next one's, where p is
the share of the period that had passed at the sample. Taken for p = 0, the wheels seem to run ahead of their commands,
and friction that nobody has is named for it. A measured torque is what the motor gave until its sample, or, of another
recorder, what it gives at that instant and goes on to give: the same holds of it, the other way round.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from testbed.arrays import Array
from testbed.estimation.telemetry import Telemetry, WheelMotors
from testbed.prediction.command_bends import Place, with_bent_commands
from testbed.prediction.command_scatter import believed_held, in_phase, with_command_scatter
from testbed.prediction.impulse_noise import SURELY, Coefficients, explained_by_wheel
from testbed.prediction.wheel_impulses import Impulses, impulses_of


def with_command_phase(runs: Sequence[Telemetry]) -> list[Telemetry]:
    """Return runs whose wheels' commands are known to change between samples, where impulses show that they do.

    Commands of several control periods between samples are compared with what they scatter by apart. Those that are
    believed to hold from sample to sample, and do not change with them, may do the same.

    Args:
        runs: of one platform; its telemetry is sampled at the same phase of the control period in all.
    """
    runs = _with_phase(runs, _phase(runs, commanded=False), commanded=False)
    if not believed_held(runs):
        runs = with_command_scatter(runs)
        return _with_phase(runs, _phase(runs, commanded=True), commanded=True)
    found = _phase(runs, commanded=True)
    if found is None:
        return list(runs)
    changing = with_command_scatter(runs)
    if believed_held(changing):
        changing = with_bent_commands(runs, found)
    if believed_held(changing):
        return _with_phase(runs, found, commanded=True)
    return _with_phase(changing, _phase(changing, commanded=True), commanded=True)


def _with_phase(runs: Sequence[Telemetry], found: Place | None, *, commanded: bool) -> list[Telemetry]:
    return list(runs) if found is None else [in_phase(run, found.share, commanded=commanded) for run in runs]


def holds_between_samples(runs: Sequence[Telemetry]) -> bool:
    """Return whether impulses show that wheels' commands hold from one sample of the telemetry to the next.

    Args:
        runs: of one platform, with the phase that their commands have.
    """
    if not believed_held(runs) or command_phase(runs) > 0.0:
        return False
    by_wheel = _phases(runs, commanded=True)
    return bool(by_wheel) and float(np.median([(_STEADY - phase) / error for phase, error in by_wheel])) > SURELY


_STEADY = 0.5
"""Phase of commands that change steadily from sample to sample: the impulse in between is then the mean of theirs.

Source: formula: of a torque on a line between two samples."""


def _phase(runs: Sequence[Telemetry], *, commanded: bool) -> Place | None:
    """Return at which phase of the control period torques are sampled; None where impulses do not show it."""
    return _common(_phases(runs, commanded=commanded))


def _phases(runs: Sequence[Telemetry], *, commanded: bool) -> list[tuple[float, float]]:
    """Return the phase that each wheel has, and its standard error; none where impulses are not known of every run."""
    now, following = (
        [impulses for run in runs if (impulses := _at_phase(run, phase, commanded=commanded)) is not None]
        for phase in (0.0, 1.0)
    )
    if len(now) < len(runs):
        return []
    columns = [_columns(one, other) for one, other in zip(now, following, strict=True)]
    return [_of_wheel(each) for each in explained_by_wheel(now, columns, shown=1, commanded=commanded)]


def command_phase(runs: Sequence[Telemetry]) -> float:
    """Return how long the commands of runs have held when they are sampled, s."""
    motors = _motors_of(runs)
    return 0.0 if motors is None else motors.command_phase * motors.period


def torque_phase(runs: Sequence[Telemetry]) -> float:
    """Return how long the measured torques of runs go on when they are sampled, s."""
    motors = _motors_of(runs)
    return 0.0 if motors is None else motors.torque_phase * motors.period


def _motors_of(runs: Sequence[Telemetry]) -> WheelMotors | None:
    return next((run.wheels.motors for run in runs if run.wheels is not None and run.wheels.motors is not None), None)


def _common(by_wheel: Sequence[tuple[float, float]]) -> Place | None:
    """Return the phase that the median wheel has, and the median standard error; None where it shows none.

    Args:
        by_wheel: phase and its standard error.
    """
    if not by_wheel:
        return None
    phase, error = np.transpose(by_wheel)
    share = float(np.clip(np.median(phase), 0.0, 1.0))
    surely = share > 0.0 and np.median(phase / error) > SURELY
    return Place(share, float(np.median(error))) if surely else None


def _of_wheel(found: Coefficients) -> tuple[float, float]:
    """Return the phase of one wheel and its standard error."""
    factor, shifted = found.values[:2].tolist()
    error = float(np.sqrt(found.covariance[1, 1]))
    return shifted / factor, max(error / abs(factor), np.finfo(float).tiny)


def _columns(now: Impulses, following: Impulses) -> Array:
    """Return what the motion took, then what may explain it, shape (1 + 4, L, W), N·m·s.

    Of a wheel: its factor, the phase, viscous and dry friction. A lag of its motor is a phase below zero, of this wheel
    alone.
    """
    return np.stack([now.needed, now.asked, following.asked - now.asked, now.turned, now.directed])


def _at_phase(run: Telemetry, phase: float, *, commanded: bool) -> Impulses | None:
    return impulses_of(in_phase(run, phase, commanded=commanded), commanded=commanded)
