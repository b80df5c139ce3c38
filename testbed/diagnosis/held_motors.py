"""Motors that hold their torque from one sample of the telemetry to the next, so that momenta go along chords.

Where the gyro is faster than the actuators' telemetry, it shows what they did between its samples. Of a healthy
platform nothing but its samples there has to be left out (`testbed.diagnosis.actuator_telemetry`); a gyro that is late
reads the rate of an instant between at any time. By splines a gyro that was 20 ms late had a low bandwidth, with P = 1.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from testbed.arrays import Theta
from testbed.diagnosis.actuator_telemetry import shows_between
from testbed.diagnosis.data import chosen, runs_of
from testbed.diagnosis.errors_in_variables import power_of_noise
from testbed.diagnosis.fitting import fitted
from testbed.diagnosis.model import Hypothesis
from testbed.dynamics.inertia import inertia_of
from testbed.effects.registry import EFFECTS
from testbed.estimation.telemetry import Telemetry

_SURELY = 9.0
"""By which twice the log-likelihood of the gyro's samples has to rise: three standard errors of one number.

Source: chosen, as for the noise of tachometers (`testbed.diagnosis.tachometers`)."""


def along_chords(telemetry: Sequence[Telemetry], theta: Theta) -> list[Telemetry]:
    """Return runs with the momenta of their wheels along chords, where these suit the gyro better than splines.

    Args:
        telemetry: of one platform's runs.
        theta: nominal inertia parameters, shape (6,), kg·m².
    """
    inertia = inertia_of(theta)
    held = [run.with_held_momentum(inertia) if run.gimbals is None and shows_between(run) else run for run in telemetry]
    if not any(run.momentum_held for run in held):
        return list(telemetry)
    smooth, bent = (_misfit(each, theta) for each in (telemetry, held))
    return held if smooth - bent > _SURELY else list(telemetry)


def _misfit(telemetry: Sequence[Telemetry], theta: Theta) -> float:
    """Return minus twice the log-likelihood of the gyro's samples by a scale of their noise, but for a constant.

    Of a path between samples a chord takes more of the telemetry's noise out than a spline; that counts for neither.
    """
    names = [str(number) for number, _ in enumerate(telemetry)]
    runs = chosen(runs_of(names, telemetry), range(len(names)))
    # A path that is looked at from the wrong instants suits nothing.
    late = Hypothesis(effect=EFFECTS["telemetry_skew"], component="actuators")
    fit = fitted(runs, [late], theta, [np.zeros(1)])
    return len(fit.residual) * float(np.log(fit.chi_square - power_of_noise(runs, fit)))
