"""Wheel speeds without commands, less their tachometers' noise: smoothed as suits the gyro's fast changes best.

Left in, the noise stands in the predicted body rate, and a model in which the body does not follow its wheels' fast
motion would suit the samples better than the true one: platforms of which nothing was hidden had a flexible appendage
or a loose mass, with P = 1.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from testbed.arrays import Array
from testbed.diagnosis.data import Runs
from testbed.diagnosis.fitting import fitted_initial_rates
from testbed.diagnosis.model import Fit
from testbed.diagnosis.signatures import Untestable
from testbed.effects.noise_effect import NoiseEffect
from testbed.estimation.telemetry import Telemetry
from testbed.prediction.tachometer import smoothed

_SURELY = 9.0
"""By which twice the log-likelihood of the gyro's fast changes has to rise: three standard errors of one number.

Source: chosen, as for the noise itself (prediction/tachometer.py)."""


def least_scattered(
    runs: Runs, baseline: Fit, telemetry: Sequence[Telemetry], runs_of: Callable[[Sequence[Telemetry]], Runs]
) -> list[Telemetry] | None:
    """Return telemetry with its wheels' momenta smoothed; None where the gyro shows nothing that speaks for it.

    Args:
        runs: all of them, as they were sent.
        baseline: the platform without effects, fitted to them.
        telemetry: of them.
        runs_of: puts telemetry side by side.
    """
    tried = [(_scatter(runs_of(each), baseline), each) for each in smoothed(telemetry)]
    if not tried:
        return None
    least, best = min(tried, key=lambda pair: pair[0])
    return best if least < _scatter(runs, baseline) - _SURELY else None


def tachometer_noise(runs: Runs) -> Array | None:
    """Return the noise of the wheels' tachometers where they were smoothed so, shape (W,), rad/s."""
    wheels = runs.grid.runs[0].wheels
    if wheels is None or wheels.smoothed is None or wheels.smoothed.noise is None:
        return None
    return wheels.smoothed.noise / wheels.wheels.spin_inertia


def distinct_from_tachometers(
    runs: Runs, effects: Mapping[str, NoiseEffect]
) -> tuple[dict[str, NoiseEffect], list[Untestable]]:
    """Return the effects on the gyro's noise that these runs can show, and those that tachometers' noise looks like."""
    alike = (
        {} if tachometer_noise(runs) is None else {key: each for key, each in effects.items() if each.like_tachometers}
    )
    hidden = [Untestable(effect=each.id, needs=_NEEDS, look_alikes=each.look_alikes) for each in alike.values()]
    return {key: each for key, each in effects.items() if key not in alike}, hidden


_NEEDS = "wheel_torque_command or wheel_torque, which tell the noise of the tachometers"


def _scatter(runs: Runs, baseline: Fit) -> float:
    """Return minus twice the log-likelihood of how much the gyro's residual changes from sample to sample.

    What misfits slowly, as most effects do, counts for nothing.
    """
    residual = runs.gyro_residual(fitted_initial_rates(runs, baseline).residual)
    changes = np.concatenate([np.diff(each, axis=0) for each in residual])
    variance = np.mean(changes**2, axis=0)[np.any(runs.live, axis=0)]
    return len(changes) * float(np.log(variance).sum())
