"""Speeds of wheels without commands, of rotors, and gimbals' angles, less their noise: smoothed as suits the gyro best.

Left in, the noise stands in the predicted body rate, and a model in which the body does not follow its wheels' fast
motion would suit the samples better than the true one: platforms of which nothing was hidden had a flexible appendage
or a loose mass, with P = 1.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from testbed.arrays import Array, Theta
from testbed.diagnosis.data import Runs
from testbed.diagnosis.model import Fit
from testbed.diagnosis.testable import Untestable
from testbed.effects.contract import Effect
from testbed.effects.noise_effect import NoiseEffect
from testbed.estimation.telemetry import Telemetry
from testbed.estimation.telemetry_noise import predicted_rate_variance
from testbed.prediction.grid import grid_of
from testbed.prediction.prediction import predicted
from testbed.prediction.tachometer import smoothed_gimbals, smoothed_rotors, smoothed_wheels

_SURELY = 9.0
"""By which twice the log-likelihood of the gyro's fast changes has to rise: three standard errors of one number.

Source: chosen, as for the noise itself (prediction/tachometer.py)."""


def least_scattered(baseline: Fit, telemetry: Sequence[Telemetry]) -> list[Telemetry] | None:
    """Return telemetry with momenta and angles smoothed; None where the gyro does not speak for it.

    Args:
        baseline: the platform without effects, fitted to the telemetry.
        telemetry: of all runs, as it was sent.
    """
    best, least = None, _scatter(telemetry, baseline)
    for smoothed in (smoothed_wheels, smoothed_rotors, smoothed_gimbals):
        tried = [(_scatter(each, baseline), each) for each in smoothed(best or telemetry)]
        scatter, smoothest = min(tried, key=lambda pair: pair[0], default=(least, best))
        if scatter < least - _SURELY:
            best, least = smoothest, scatter
    return best


def tachometer_noise(runs: Runs) -> Array | None:
    """Return the noise of the wheels' tachometers where they were smoothed so, shape (W,), rad/s."""
    wheels = runs.grid.runs[0].wheels
    if wheels is None or wheels.smoothed is None or wheels.smoothed.noise is None:
        return None
    return wheels.smoothed.noise / wheels.wheels.spin_inertia


def rotor_tachometer_noise(runs: Runs) -> float:
    """Return the noise of the tachometers of the gyros' rotors where they were smoothed so, rad/s; 0 where not."""
    gimbals = runs.grid.runs[0].gimbals
    return 0.0 if gimbals is None else gimbals.rotor_speed_noise


def encoder_noise(runs: Runs) -> float:
    """Return the noise of the gimbals' encoders where their angles were smoothed so, rad; 0 where not."""
    gimbals = runs.grid.runs[0].gimbals
    return 0.0 if gimbals is None else gimbals.angle_noise


def distinct_from_tachometers(
    runs: Runs, effects: Mapping[str, NoiseEffect]
) -> tuple[dict[str, NoiseEffect], list[Untestable]]:
    """Return the effects on the gyro's noise that these runs can show, and those that tachometers' noise looks like."""
    alike = (
        {} if tachometer_noise(runs) is None else {key: each for key, each in effects.items() if each.like_tachometers}
    )
    hidden = [Untestable(effect=each.id, needs=_NEEDS, look_alikes=each.look_alikes) for each in alike.values()]
    return {key: each for key, each in effects.items() if key not in alike}, hidden


def shown_beside_tachometers(
    runs: Runs, effects: Mapping[str, Effect], theta: Theta
) -> tuple[Mapping[str, Effect], list[Untestable]]:
    """Return the effects that these runs can show, and the modes of the body that tachometers' noise looks like.

    Noise of wheels' tachometers stands in the predicted body rate. A mode that answers to fast changes of their momenta
    takes some of it away: it explains samples better, whether there is a mode or not.

    Args:
        runs: of one data set.
        effects: by id.
        theta: nominal inertia parameters, shape (6,), kg·m².
    """
    if _noise_of_wheels(runs, theta) < _AS_A_MODE:
        return effects, []
    modes = {key: each for key, each in effects.items() if each.scans_frequencies}
    hidden = [Untestable(effect=each.id, needs=_QUIETER, look_alikes=each.look_alikes) for each in modes.values()]
    return {key: each for key, each in effects.items() if key not in modes}, hidden


_AS_A_MODE = 20.0
"""χ² that tachometers' noise adds to the gyro's samples, from which on modes are not distinguished from it.

Source: measured on five flights of 300 s of the shipped CubeSat with nothing hidden, sampled at half the rate of its
controller: of 979 a loose mass took away 192. A fifth of 20 is less than what any name needs."""
_QUIETER = "tachometers with less noise, or wheel_torque_command as often as it changes"


def _noise_of_wheels(runs: Runs, theta: Theta) -> float:
    """Return how much noise of the tachometers of wheels adds to χ² of the gyro's samples; 0 beside gimbals."""
    added = [
        len(run.gyro_time) * float((predicted_rate_variance(run, theta) / run.gyro_noise**2).sum())
        for run in runs.grid.runs
        if run.wheels is not None and run.gimbals is None
    ]
    return sum(added)


_NEEDS = "wheel_torque_command or wheel_torque, which tell the noise of the tachometers"


def _scatter(telemetry: Sequence[Telemetry], baseline: Fit) -> float:
    """Return minus twice the log-likelihood of how much the gyro's residual changes from sample to sample.

    What misfits slowly counts for nothing: neither most effects do, nor the initial rates, which are left as they are.
    """
    grid = grid_of(telemetry)
    found = predicted(grid, [each.hooks for each in baseline.placed], baseline.values)
    changes = [np.diff(run.body_rate - own[0], axis=0) for run, own in zip(grid.runs, found, strict=True)]
    variance = np.mean(np.concatenate(changes) ** 2, axis=0)[np.any(grid.live, axis=0)]
    return sum(map(len, changes)) * float(np.log(variance).sum())
