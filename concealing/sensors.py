"""What the sensors show of the true motion, with the errors of the craft and noise drawn up front."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from concealing.craft import Array, Encoders, GyroErrors


@dataclass(frozen=True, kw_only=True)
class SensorNumbers:
    """Nominal standard deviations per sample, and steps of the encoders.

    Attributes:
        gyro_noise: rad/s.
        encoder_noise: rad.
        encoder_step: rad; 0 for none.
        tachometer_noise: rad/s.
        torque_noise: N·m.
    """

    gyro_noise: float
    encoder_noise: float
    encoder_step: float
    tachometer_noise: float
    torque_noise: float

    def quiet(self) -> SensorNumbers:
        """Return the same sensors without noise or steps."""
        return SensorNumbers(
            gyro_noise=0.0, encoder_noise=0.0, encoder_step=0.0, tachometer_noise=0.0, torque_noise=0.0
        )


class Noise(NamedTuple):
    """Standard normal numbers of one data set, one row per control tick.

    Attributes:
        gyro: (K, B, 3).
        extra: of a gyro noisier than nominal, (K, B, 3).
        walk: a random walk that starts at zero and gains variance 1 per second, (K, B, 3).
        encoder, tachometer, torque: (K, B, M).
    """

    gyro: Array
    extra: Array
    walk: Array
    encoder: Array
    tachometer: Array
    torque: Array


def draw_noise(seed: np.random.SeedSequence, rows: int, runs: int, units: int, period: float) -> Noise:
    """Draw the noise of a data set; each source has its own generator.

    Args:
        seed: of the data set's noise.
        rows: control ticks.
        runs: B.
        units: M.
        period: between ticks, s.
    """
    gyro, extra, walk, encoder, tachometer, torque = (np.random.default_rng(child) for child in seed.spawn(6))
    steps = np.sqrt(period) * walk.standard_normal((rows, runs, 3))
    steps[0] = 0.0
    return Noise(
        gyro=gyro.standard_normal((rows, runs, 3)),
        extra=extra.standard_normal((rows, runs, 3)),
        walk=np.cumsum(steps, axis=0),
        encoder=encoder.standard_normal((rows, runs, units)),
        tachometer=tachometer.standard_normal((rows, runs, units)),
        torque=torque.standard_normal((rows, runs, units)),
    )


def gyro_reading(gyro: GyroErrors, seen: Array, time: float, noise: Array, walk: Array) -> Array:
    """Return a reading, (B, 3), rad/s.

    Args:
        gyro: its errors.
        seen: delayed, low-passed true rate, (B, 3), rad/s.
        time: since release, s.
        noise: of this sample, (B, 3), rad/s.
        walk: the drift's random walk, (B, 3), √s.
    """
    rate = seen @ gyro.response.T + gyro.bias + gyro.drift * time + gyro.random_walk * walk + noise
    return rounded(np.clip(rate, -gyro.saturation, gyro.saturation), gyro.quantization)


def encoder_reading(encoders: Encoders, angle: Array, lead: Array, noise: Array, step: float) -> Array:
    """Return readings, (B, M), rad.

    Args:
        encoders: their errors.
        angle: of the axes, (B, M), rad.
        lead: +1 where the motor last pushed forward, -1 where backward, 0 before it moved, (B, M).
        noise: (B, M), rad.
        step: rad.
    """
    return rounded(angle + encoders.zero + 0.5 * encoders.backlash * lead + noise, step)


def rounded(value: Array, step: float) -> Array:
    """Return the nearest multiple of a step; the value itself where the step is 0."""
    return step * np.rint(value / step) if step > 0.0 else value
