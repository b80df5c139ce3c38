"""The gyro's parameters under their IEEE 952 names, and its additive errors, drawn for a whole flight up front."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import inf, sqrt

import numpy as np

from testbed.arrays import Matrix3, Vector3, Vectors3
from testbed.sensors.noise import angle_quantization, autoregression, gauss_markov, random_walk, white_noise
from testbed.sensors.sampling import generators


@dataclass(frozen=True, kw_only=True)
class GyroParameters:
    """A three-axis rate gyro in body axes; every error is absent unless it is set.

    The reading is ω̄ = q(clip((I + diag(s) + E) F(ω) + b + noises)), F the delayed low-pass, q the rounding.

    Attributes:
        sample_rate: Hz; has to divide the control rate.
        white_noise: σ per sample, of all axes or shape (3,), rad/s. Source: paper eq. (4).
        noise_correlation: of neighbouring samples of it.
        bias: b at the start, shape (3,), rad/s.
        drift: ḃ, shape (3,), rad/s².
        bias_instability: stationary standard deviation of the first-order Gauss-Markov bias, rad/s.
        bias_correlation_time: of that bias, s; infinite for a constant bias drawn once per flight.
        rate_random_walk: K, (rad/s)/√s; starts at zero.
        angle_quantization: Q, rad: the angle step of a rate-integrating gyro over √12.
        scale_factor_error: s, shape (3,), of each axis.
        misalignment: E, shape (3, 3): row i says what axis i reads of the others, rad. Of a gyro that is turned it is
            the rotation less I, with a diagonal of second order; a symmetric part makes its axes oblique.
        bandwidth: of a first-order low-pass at -3 dB, Hz; infinite for none.
        latency: of its readings, s.
        saturation: largest reading, each axis, rad/s; infinite for none.
        quantization: step of the reading, rad/s.
    """

    sample_rate: float
    white_noise: Vector3 | float = 0.0
    noise_correlation: float = 0.0
    bias: Vector3 = field(default_factory=lambda: np.zeros(3))
    drift: Vector3 = field(default_factory=lambda: np.zeros(3))
    bias_instability: float = 0.0
    bias_correlation_time: float = inf
    rate_random_walk: float = 0.0
    angle_quantization: float = 0.0
    scale_factor_error: Vector3 = field(default_factory=lambda: np.zeros(3))
    misalignment: Matrix3 = field(default_factory=lambda: np.zeros((3, 3)))
    bandwidth: float = inf
    latency: float = 0.0
    saturation: float = inf
    quantization: float = 0.0

    @property
    def angle_random_walk(self) -> Vector3 | float:
        """N = σ/√sample_rate of the white noise, rad/√s."""
        return self.white_noise / sqrt(self.sample_rate)


def gyro_errors(parameters: GyroParameters, samples: int, seed: np.random.SeedSequence) -> Vectors3:
    """Draw all additive errors of one flight, shape (samples, 3), rad/s.

    Each noise has its own generator: to switch one on does not change the numbers of another. A batch stacks the
    errors of its flights on axis 1.

    Args:
        parameters: the gyro.
        samples: number of readings of the flight.
        seed: of this gyro in this flight; the same seed gives the same errors.
    """
    white, instability, walk, quantization = generators(seed, 4)
    dt, shape = 1.0 / parameters.sample_rate, (samples, 3)
    return np.asarray(
        parameters.bias
        + parameters.drift * (dt * np.arange(samples)[:, None])
        + autoregression(parameters.noise_correlation, white_noise(parameters.white_noise, shape, white))  # eq. (4)
        + gauss_markov(parameters.bias_instability, parameters.bias_correlation_time, dt, shape, instability)
        + random_walk(parameters.rate_random_walk, dt, shape, walk)
        + angle_quantization(parameters.angle_quantization, dt, shape, quantization)
    )
