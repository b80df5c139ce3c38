"""Notices on the measurements of a data set: which are not taken as they were sent, and which cannot be."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from testbed.diagnosis.channels import unfollowed
from testbed.diagnosis.data import Runs
from testbed.diagnosis.tachometers import encoder_noise, rotor_tachometer_noise, tachometer_noise
from testbed.dynamics.inertia import PARAMETER_NAMES
from testbed.prediction.command_phase import command_phase, torque_phase
from testbed.prediction.command_scatter import found_changing
from testbed.signals import AXES

_MOSTLY = 0.5
"""Share of the commands; a command in another unit is beyond the limit nearly always, one that saturates at times.

Source: chosen."""


def notices_of(runs: Runs) -> Iterator[str]:
    """Yield a sentence on whatever of the measurements is not taken as it was sent, or cannot be.

    Args:
        runs: all of them side by side.
    """
    yield from _phase_notice(runs)
    yield from _torque_notice(runs)
    yield from _smoothed_notice(runs)
    yield from _unfollowed_notice(runs)
    yield from _limit_notice(runs)
    yield from _undetermined(runs)


def _phase_notice(runs: Runs) -> Iterator[str]:
    if found_changing(runs.grid.runs):
        yield (
            "wheel_torque_command changes several times between its samples, as the wheels' speeds show, and does not "
            "hold from one to the next: compared so; diagnosis.control_rate_hz states the controller's rate"
        )
    elif phase := command_phase(runs.grid.runs):
        yield (
            f"the wheels' telemetry is sampled {1e3 * phase:.1f} ms after their commands change, as the wheels' speeds "
            "show: impulses are compared so"
        )


def _torque_notice(runs: Runs) -> Iterator[str]:
    if phase := torque_phase(runs.grid.runs):
        yield (
            f"what wheel_torque shows goes on for {1e3 * phase:.1f} ms when it is sampled, as the wheels' speeds show: "
            "impulses are compared so"
        )


def _smoothed_notice(runs: Runs) -> Iterator[str]:
    noise = tachometer_noise(runs)
    if noise is not None:
        yield (
            f"the wheels' tachometers have noise of about {noise.max():.2g} rad/s, and no torque of the wheels is "
            "recorded that would tell it from their motion: speeds are smoothed as suits the gyro's fast changes best; "
            "record wheel_torque_command to see more"
        )
    if of_rotors := rotor_tachometer_noise(runs):
        yield (
            f"the rotors' tachometers have noise of about {of_rotors:.2g} rad/s: speeds are smoothed as suits the "
            "gyro's fast changes best"
        )
    if of_encoders := encoder_noise(runs):
        yield (
            f"the gimbals' encoders have noise of about {of_encoders:.2g} rad: angles are smoothed as suits the gyro's "
            "fast changes best"
        )


def _unfollowed_notice(runs: Runs) -> Iterator[str]:
    for channel, factors in unfollowed(runs.grid).items():
        times = ", ".join(f"{factor:.2g}" for factor in factors)
        yield (
            f"{channel} is not compared: the wheels' speeds gain {times} times what it says; check its sign, "
            "its unit and the order of its columns"
        )


def _limit_notice(runs: Runs) -> Iterator[str]:
    wheels = [run.wheels for run in runs.grid.runs if run.wheels is not None]
    sent = [(each.torque_command, each.wheels.torque_limit) for each in wheels if each.torque_command is not None]
    if sent and np.mean([np.mean(np.abs(command) > limit) for command, limit in sent]) > _MOSTLY:
        yield (
            "wheel_torque_command asks mostly for more than torque_limit_N_m of the wheels, where it is not compared: "
            "check its unit, and the limit"
        )


def _undetermined(runs: Runs) -> Iterator[str]:
    """Yield what of the inertia no run can show, as bearings hold the platform."""
    shown = runs.inertia_shown
    if not shown.all():
        left_out = ", ".join(name for name, yes in zip(PARAMETER_NAMES, shown, strict=True) if not yes)
        about = ", ".join(axis for axis, yes in zip(AXES, np.any(runs.live, axis=0).tolist(), strict=True) if yes)
        yield (
            f"the runs turn about {about} only: {left_out} of the inertia are not determined, and left out of tables "
            "and files; effects on the other axes are not tested for"
        )
