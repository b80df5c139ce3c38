"""The gyro is noisier than is stated."""

from __future__ import annotations

from typing import final

import numpy as np
import scipy
from typing_extensions import override

from testbed.arrays import Array, Flags
from testbed.effects.contract import AXES, Extension, Parameter
from testbed.effects.fast_changes import noise_ratio
from testbed.effects.noise_effect import Finding, NoiseEffect, Readings
from testbed.scenario.scenario import Scenario


@final
class GyroNoise(NoiseEffect):
    """White noise of the standard deviation σ_e beyond what is stated: σ² → σ² + σ_e², on one axis or all.

    Estimated from fourth differences, which no motion of the platform makes, and at the end from the whole residual:
    with the ratio ρ of the variance to the stated one and ν degrees of freedom, ν ρ is χ²(ν) where the stated noise is
    right.
    """

    id = "gyro_noise"
    components = ("gyro", *AXES)
    parameters = (Parameter(name="extra_noise_rad_s", unit="rad/s", typical=1e-3, lower=0.0),)
    sentence = "The readings of {component} scatter more than is stated, without any structure."
    look_alikes = ("gyro_quantization",)
    like_tachometers = True
    confirm = "A record of the platform held still: its standard deviation is the noise."

    @override
    def found(self, component: str, readings: Readings) -> Finding | None:
        axes = _axes(component)
        ratio, freedom = noise_ratio(readings, axes)
        if freedom <= 0.0 or not readings.stated:
            return None
        variance = np.mean(readings.sigma[:, axes] ** 2)
        extra = max(ratio - 1.0, 0.0)
        noise = float(np.sqrt(variance * extra))
        spread = variance * ratio * np.sqrt(2.0 / freedom)  # standard error of σ² + σ_e²
        return Finding(
            values=np.array([noise]),
            std=np.array([spread / (2.0 * noise) if noise > 0.0 else np.sqrt(spread)]),
            chi_square_reduction=freedom * (ratio - 1.0 - np.log(ratio)) if extra else 0.0,
            freedom=1,
            p_value=float(scipy.stats.chi2.sf(freedom * ratio, freedom)),
            variance=axes * variance * extra,
            noise_freedom=freedom,
        )

    @override
    def extension(self, component: str, values: Array, scenario: Scenario) -> Extension:
        extra = np.hypot(scenario.gyro.extra_noise_rad_s, _axes(component) * values[0])
        return Extension(scenario={"gyro": {"extra_noise_rad_s": extra.tolist()}})


def _axes(component: str) -> Flags:
    return np.array([component in ("gyro", axis) for axis in AXES])
