"""The gyro's readings come in steps."""

from __future__ import annotations

from collections.abc import Sequence
from typing import final

import numpy as np
from typing_extensions import override

from testbed.arrays import Array
from testbed.effects.contract import Extension, Parameter
from testbed.effects.noise_effect import Finding, NoiseEffect, Readings
from testbed.scenario.scenario import Scenario

SMALLEST_STEP = 0.1
"""In sigma. A finer step adds less than 0.1 % to the noise's variance; it may be how a file writes its numbers."""
_OFF_LEVEL = 0.01
"""Share of a step by which a reading may miss its level: numbers in files have digits enough for that."""
_FEWEST = 5
"""Different levels that tell a step from chance: of numbers without one, each lies on a level with 2 % probability."""


@final
class GyroQuantization(NoiseEffect):
    """ω̄ = q round(ω / q): all readings lie on levels q apart, which adds q²/12 to the variance."""

    id = "gyro_quantization"
    components = ("gyro",)
    parameters = (Parameter(name="step_rad_s", unit="rad/s", typical=2e-3, lower=0.0),)
    sentence = "The gyro's readings come in steps."
    look_alikes = ("gyro_noise",)
    confirm = "Look at the differences between readings: they are whole multiples of one number."

    @override
    def found(self, component: str, readings: Readings) -> Finding | None:
        sigma = float(np.sqrt(np.mean(readings.sigma**2)))
        found = level_step(readings.measured, SMALLEST_STEP * sigma)
        if found is None:
            return None
        step, levels = found
        log_p_value = levels * np.log(2.0 * _OFF_LEVEL)
        return Finding(
            values=np.array([step]),
            std=np.array([step * _OFF_LEVEL / levels]),
            chi_square_reduction=-2.0 * log_p_value,
            freedom=1,
            p_value=float(np.exp(log_p_value)),
            variance=np.full(3, step**2 / 12.0),
        )

    @override
    def extension(self, component: str, values: Array, scenario: Scenario) -> Extension:
        return Extension(scenario={"gyro": {"quantization_rad_s": max(float(values[0]), _present(scenario))}})


def level_step(measured: Sequence[Array], smallest: float) -> tuple[float, int] | None:
    """Return the distance of the levels on which all readings lie, and how many differences say so; None without.

    Args:
        measured: readings of each run, shape (N, 3), rad/s.
        smallest: step that counts, rad/s.
    """
    axes = np.concatenate(measured).T
    between = np.concatenate([np.diff(np.unique(axis)) for axis in axes])
    between = between[between > _OFF_LEVEL * smallest]
    if len(between) < _FEWEST or between.min() < smallest:
        return None
    count = np.round(between / between.min())
    step = float(between.sum() / count.sum())
    on_level = bool((np.abs(between / step - np.round(between / step)) < _OFF_LEVEL).all())
    return (step, len(between)) if on_level else None


def _present(scenario: Scenario) -> float:
    return scenario.gyro.quantization_rad_s
