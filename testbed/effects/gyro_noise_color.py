"""The gyro's noise has a colour: neighbouring samples are correlated."""

from __future__ import annotations

from typing import final

import numpy as np
import scipy
from typing_extensions import override

from testbed.arrays import Array
from testbed.dynamics.inertia import theta_of
from testbed.effects.contract import Extension, Parameter
from testbed.effects.noise_effect import Finding, NoiseEffect, Readings
from testbed.estimation.telemetry_noise import common_to_neighbours, predicted_rate_variance
from testbed.scenario.scenario import Scenario


@final
class GyroNoiseColor(NoiseEffect):
    """Noise of which neighbouring samples have the correlation ρ, its variance as it was.

    ρ is the mean of the axes, estimated from the residual's fast part (`estimation/noise_spectrum.py`), together with
    how it falls from one sample to the next; every test is on samples that are whitened by both. The extended model has
    an autoregression, z_k = ρ z_(k-1) + e_k.
    """

    id = "gyro_noise_color"
    components = ("gyro",)
    parameters = (Parameter(name="correlation", unit="1", typical=0.3, lower=-0.9, upper=0.9),)
    sentence = "Neighbouring samples of the noise of {component} are correlated."
    look_alikes = ("gyro_noise", "gyro_bandwidth")
    like_tachometers = True
    confirm = "A record of the platform held still: its autocorrelation at one sample is the parameter."

    @override
    def found(self, component: str, readings: Readings) -> Finding | None:
        spectrum = readings.spectrum
        if spectrum is None:
            return None
        own = spectrum.correlation - np.clip(spectrum.correlation, 0.0, _made_by_telemetry(readings))
        square = (own / spectrum.correlation_std) ** 2
        return Finding(
            values=np.array([own]),
            std=np.array([spectrum.correlation_std]),
            chi_square_reduction=float(square),
            freedom=1,
            p_value=float(scipy.stats.chi2.sf(square, 1)),
            variance=np.zeros(3),
            noise_freedom=spectrum.freedom,
        )

    @override
    def extension(self, component: str, values: Array, scenario: Scenario) -> Extension:
        return Extension(scenario={"gyro": {"noise_correlation": float(values[0])}})


def _made_by_telemetry(readings: Readings) -> float:
    """Return the correlation of neighbouring samples that is the actuators' telemetry's, and none of the gyro's noise.

    The error of an encoder stands in the prediction of all gyro samples near it.
    """
    theta = theta_of(readings.inertia)
    shares = [
        common_to_neighbours(run) * predicted_rate_variance(run, theta)[live] / sigma[live] ** 2
        for run, sigma, live in zip(readings.runs, readings.sigma, readings.live, strict=False)
    ]
    return float(np.concatenate(shares).mean())
