"""Motors that hold their torque from one sample of the telemetry to the next, so that momenta go along chords.

Where the gyro is faster than the actuators' telemetry, it shows what they did between its samples; where it is no
faster, it does so if it is late, as it then reads the rate of an instant between. Of a healthy platform nothing but
the gyro's samples there has to be left out (`testbed.diagnosis.actuator_telemetry`). By splines one that was 20 or
40 ms late had a low bandwidth, with P = 1.

Where commands were recorded under a gyro that is no faster, these tell it. A controller that feeds its noise back
turns the platform after each sample against the noise of that sample: by splines, whose slope is half of what follows,
that is a gyro late by 3 ms.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from testbed.arrays import Theta
from testbed.diagnosis.actuator_telemetry import shows_between
from testbed.diagnosis.data import Runs, chosen, runs_of
from testbed.diagnosis.errors_in_variables import power_of_noise
from testbed.diagnosis.fitting import fitted
from testbed.diagnosis.model import Fit, Hypothesis
from testbed.diagnosis.settings import SETTINGS
from testbed.dynamics.inertia import inertia_of
from testbed.effects.registry import EFFECTS
from testbed.estimation.telemetry import Telemetry, has_momentum
from testbed.prediction.command_phase import holds_between_samples

_SURELY = 9.0
"""By which twice the log-likelihood of the gyro's samples has to rise: three standard errors of one number.

Source: chosen, as for the noise of tachometers (`testbed.diagnosis.tachometers`)."""


def along_chords(telemetry: Sequence[Telemetry], theta: Theta) -> list[Telemetry]:
    """Return runs with the momenta of their wheels along chords, where commands or the gyro show these.

    Args:
        telemetry: of one platform's runs.
        theta: nominal inertia parameters, shape (6,), kg·m².
    """
    if any(run.gimbals is not None or not has_momentum(run) for run in telemetry):
        return list(telemetry)
    inertia = inertia_of(theta)
    between = any(map(shows_between, telemetry))
    if not between and holds_between_samples(telemetry):
        return [run.with_held_momentum(inertia) for run in telemetry]
    smooth = _fit(telemetry, theta)
    if not between and not _is_late(smooth):
        return list(telemetry)
    held = [run.with_held_momentum(inertia) for run in telemetry]
    bent = _fit(held, theta)
    explained = between or not _misfits(bent)
    return held if explained and _misfit(smooth) - _misfit(bent) > _SURELY else list(telemetry)


def _fit(telemetry: Sequence[Telemetry], theta: Theta) -> tuple[Runs, Fit]:
    """Return runs, and the fit of another clock of their telemetry.

    A path that is looked at from the wrong instants suits nothing.
    """
    names = [str(number) for number, _ in enumerate(telemetry)]
    runs = chosen(runs_of(names, telemetry), range(len(names)))
    late = Hypothesis(effect=EFFECTS["telemetry_skew"], component="actuators")
    return runs, fitted(runs, [late], theta, [np.zeros(1)])


def _is_late(found: tuple[Runs, Fit]) -> bool:
    """Return whether the telemetry's clock is surely another one than the gyro's."""
    _, fit = found
    return float(fit.effect_values[0] ** 2) > _SURELY * float(fit.covariance[6, 6])


def _misfits(found: tuple[Runs, Fit]) -> bool:
    """Return whether more than another clock is missing, such as a slow wheel: what suits that better says nothing."""
    _, fit = found
    return fit.chi_square > SETTINGS.misfitting * fit.freedom


def _misfit(found: tuple[Runs, Fit]) -> float:
    """Return minus twice the log-likelihood of the gyro's samples by a scale of their noise, but for a constant.

    Of a path between samples a chord takes more of the telemetry's noise out than a spline; that counts for neither.
    """
    runs, fit = found
    return len(fit.residual) * float(np.log(fit.chi_square - power_of_noise(runs, fit)))
