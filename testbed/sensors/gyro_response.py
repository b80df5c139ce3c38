"""The gyro in the loop: what it reads at a control tick, of the true body rate at this tick and before.

All functions broadcast over leading axes of the body rate, so that one platform or a batch goes through the same code.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import exp, inf, isinf, pi
from typing import NamedTuple

import numpy as np
from scipy.interpolate import KroghInterpolator
from scipy.special import factorial, gammainc

from testbed.arrays import Array, Matrix3, Vector3
from testbed.sensors.gyro import GyroParameters
from testbed.sensors.sampling import quantized, ticks_per_sample


@dataclass(frozen=True, kw_only=True)
class Gyro:
    """A gyro on the grid of the control clock.

    Attributes:
        ticks_per_sample: control ticks from one reading to the next.
        pole: of the low-pass over one tick; zero for none.
        taps: weights of the rate at this tick and the K - 1 before in the low-passed, delayed rate, shape (K,).
        response: I + diag(s) + E, shape (3, 3), or (..., 3, 3) where the gyros of a batch differ.
        saturation: rad/s.
        quantization: rad/s.
    """

    ticks_per_sample: int
    pole: float
    taps: Array
    response: Matrix3
    saturation: float
    quantization: float

    @property
    def instant(self) -> bool:
        """Whether readings show the present rate alone, with neither low-pass nor latency."""
        return self.taps.size == 1


class GyroState(NamedTuple):
    """What the gyro remembers from one control tick to the next.

    Attributes:
        history: true rate at the last K ticks, newest first, shape (..., K, 3), rad/s.
        filtered: low-passed, delayed rate, shape (..., 3), rad/s.
    """

    history: Array
    filtered: Vector3


def gyro_on_clock(parameters: GyroParameters, control_rate: float) -> Gyro:
    """Put a gyro on the grid of the control clock.

    Args:
        parameters: the gyro.
        control_rate: Hz.

    Raises:
        InputError: the gyro's sample rate does not divide the control rate.
    """
    decay = 2.0 * pi * parameters.bandwidth / control_rate
    return Gyro(
        ticks_per_sample=ticks_per_sample(control_rate, parameters.sample_rate, "gyro"),
        pole=exp(-decay),
        taps=np.convolve(_low_pass_taps(decay), _latency_taps(parameters.latency * control_rate)),
        response=np.eye(3) + np.diag(parameters.scale_factor_error) + parameters.misalignment,
        saturation=parameters.saturation,
        quantization=parameters.quantization,
    )


def gyro_at_start(gyro: Gyro, true_body_rate: Vector3) -> GyroState:
    """Return the steady state of a gyro at a constant body rate.

    Args:
        gyro: the gyro.
        true_body_rate: shape (..., 3), rad/s, body axes.
    """
    rate = np.array(true_body_rate)
    return GyroState(np.repeat(rate[..., None, :], gyro.taps.size, axis=-2), rate)


def sample_gyro(
    gyro: Gyro, state: GyroState, true_body_rate: Vector3, tick: int, errors: Array
) -> tuple[GyroState, Vector3 | None]:
    """Advance the gyro to a control tick and read it there if it has a sample due.

    Args:
        gyro: the gyro.
        state: at the tick before, or at the start.
        true_body_rate: at this tick, shape (..., 3), rad/s, body axes.
        tick: number of the control tick, from 0; the first reading is at tick 0.
        errors: additive errors of the whole flight, shape (samples, ..., 3), rad/s.

    Returns:
        The state at this tick, and the reading, shape (..., 3), rad/s; None between samples.
    """
    if not gyro.instant:
        state = _advanced(gyro, state, true_body_rate)
    if tick % gyro.ticks_per_sample:
        return state, None
    seen = true_body_rate if gyro.instant else state.filtered
    # The response comes last, once per sample: it commutes with a low-pass and a delay that are the same on each axis.
    return state, _digitized(gyro, np.matvec(gyro.response, seen) + errors[tick // gyro.ticks_per_sample])


def _advanced(gyro: Gyro, state: GyroState, true_body_rate: Vector3) -> GyroState:
    history = np.concatenate((true_body_rate[..., None, :], state.history[..., :-1, :]), axis=-2)
    return GyroState(history, gyro.pole * state.filtered + gyro.taps @ history)


def _digitized(gyro: Gyro, reading: Vector3) -> Vector3:
    if gyro.saturation < inf:
        reading = np.minimum(np.maximum(reading, -gyro.saturation), gyro.saturation)
    return quantized(reading, gyro.quantization)


def _low_pass_taps(decay: float) -> Array:
    """Return what the rates at this tick and the three before add to the low-pass in one tick.

    ∫ a exp(-a v) u(v) dv over the age 0 <= v <= 1 tick, exact where the rate u is a cubic in time: the taps that give
    the moments ∫ a exp(-a v) vʲ dv = j! P(j + 1, a) / aʲ, j = 0 ... 3, with P the regularized incomplete gamma
    function. A line between ticks would flatten a 1 Hz motion on an 80 Hz grid by 5e-4, as much as one standard
    deviation of a flight's inertia.

    Args:
        decay: a = 2π bandwidth / control rate.
    """
    if isinf(decay):
        return np.ones(1)
    order = np.arange(4)
    moments = factorial(order) * gammainc(order + 1, decay) / decay**order
    powers_of_age = np.vander(np.arange(4.0), increasing=True).T  # row j: each tick's age to the power j
    return np.asarray(np.linalg.solve(powers_of_age, moments))


def _latency_taps(ticks: float) -> Array:
    """Return the weights that interpolate `ticks` ticks back with a cubic through the four nearest ticks."""
    if ticks == 0.0:
        return np.ones(1)
    first = max(0, int(ticks) - 1)
    weights = KroghInterpolator(np.arange(first, first + 4), np.eye(4))(ticks)
    return np.concatenate((np.zeros(first), weights))
