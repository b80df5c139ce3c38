"""What instruments do that no model of them says: noise with a colour or heavy tails, clocks apart, errors of encoders.

The noise is made of the numbers that were drawn for white noise, so that the gyro's feedback sees it as well. What a
gyro shows of the motion, and when samples are of, is worked out from the flight afterwards; nobody on board notices.
"""

from __future__ import annotations

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.linalg import cholesky, toeplitz
from scipy.signal import butter, lfilter, lfilter_zi
from scipy.stats import norm, t

from concealing.case import Case, Instruments
from concealing.craft import Array
from concealing.flight import FlightLog
from concealing.mechanics import Mechanics
from concealing.sensors import Noise

_NOISE, _JITTER, _PHASES = range(3)
_KEY = 100
"""Apart from the purposes of the other numbers of a case."""
_FINER = 32
"""Points a period on which the anti-alias filter is worked out."""
_SETTLED = 20
"""Periods at rest before release, in which that filter settles."""


def gyro_noise(case: Case, noise: Noise, gyro_ticks: int, correlation: float = 0.0) -> Noise:
    """Return the noise with the colour, the tails and the levels that a case's gyro has.

    Args:
        case: its instruments.
        noise: white and normal.
        gyro_ticks: control ticks between two samples.
        correlation: of neighbouring samples, by a hidden effect.
    """
    instruments, gyro = case.instruments, noise.gyro.copy()
    samples = gyro[::gyro_ticks]
    lags = _correlation(instruments, correlation or instruments.noise_correlation, len(samples))
    if lags is not None:
        samples = np.einsum("ij,jbk->ibk", cholesky(toeplitz(lags), lower=True), samples)
    if instruments.tail_freedom is not None:
        spread = np.sqrt(instruments.tail_freedom / (instruments.tail_freedom - 2.0))
        samples = t.ppf(norm.cdf(samples), instruments.tail_freedom) / spread
    if instruments.noise_by_run > 0.0:
        share = _generator(case, _NOISE).uniform(-1.0, 1.0, samples.shape[1]) * instruments.noise_by_run
        samples = samples * (1.0 + share)[:, None]
    gyro[::gyro_ticks] = samples
    return noise._replace(gyro=gyro)


def _correlation(instruments: Instruments, neighbours: float, count: int) -> Array | None:
    """Return the autocorrelation of the gyro's noise at so many lags; None where it is white."""
    lags = np.arange(count)
    if neighbours:
        return (1.0 - instruments.noise_white) * neighbours**lags + instruments.noise_white * (lags == 0)
    if instruments.anti_alias is not None:  # of white noise behind a second-order Butterworth filter
        angle = np.sqrt(2.0) * np.pi * instruments.anti_alias * lags
        return np.exp(-angle) * (np.cos(angle) + np.sin(angle))
    return None


def gyro_error(case: Case, log: FlightLog, mechanics: Mechanics, run: int, ticks: Array) -> Array:
    """Return what the gyro shows of the motion less the body rate at the ticks that its samples are stamped with.

    Args:
        case: its instruments.
        log: of the flight.
        mechanics: that flew it.
        run: which of its runs.
        ticks: of the gyro's samples.

    Returns:
        Shape (ticks, 3), rad/s.
    """
    instruments, period, drift = case.instruments, 1.0 / case.telemetry.gyro_rate, mechanics.craft.gyro.clock_drift
    if not (drift or instruments.jitter or instruments.clock_skew or instruments.averaging or instruments.anti_alias):
        return np.zeros((len(ticks), 3))
    states = zip(log.fine_time, log.fine_state, strict=True)
    rates = np.array([mechanics.velocities(time, state).body_rate[run] for time, state in states])
    _, first = np.unique(log.fine_time, return_index=True)
    motion = CubicSpline(log.fine_time[first], rates[first])
    stamps = log.time[ticks]
    if instruments.averaging:
        return _mean(motion, stamps, period) - motion(stamps)
    if instruments.anti_alias is not None:
        return _filtered(motion, stamps, period, instruments.anti_alias) - motion(stamps)
    jitter = instruments.jitter * _generator(case, _JITTER, run).standard_normal(len(stamps))
    taken = (1.0 - drift) * stamps + jitter + instruments.clock_skew * stamps / stamps[-1]
    return motion(np.clip(taken, 0.0, log.fine_time[-1])) - motion(stamps)


def _mean(motion: CubicSpline, stamps: Array, period: float) -> Array:
    """Return the means over the period before every stamp; the craft turned at its first rate before release."""
    turned = motion.antiderivative()
    early = np.minimum(stamps - period, 0.0)
    before = turned(np.maximum(stamps - period, 0.0)) + motion(0.0) * early[:, None]
    return (turned(stamps) - before) / period


def _filtered(motion: CubicSpline, stamps: Array, period: float, corner: float) -> Array:
    """Return what a second-order filter shows at the stamps, its corner in shares of the sample rate."""
    last = round(stamps[-1] / period)
    fine = np.arange(-_SETTLED * _FINER, last * _FINER + 1) * period / _FINER
    forward, back = butter(2, corner, fs=_FINER)
    values = motion(np.maximum(fine, 0.0))
    at_rest = lfilter_zi(forward, back)[:, None] * values[0]
    shown, _ = lfilter(forward, back, values, axis=0, zi=at_rest)
    return shown[np.rint(stamps / period).astype(int) * _FINER + _SETTLED * _FINER]


def encoder_error(case: Case, log: FlightLog, mechanics: Mechanics, run: int) -> Array:
    """Return what late and eccentric encoders show beside what they should at all ticks, shape (K, M), rad."""
    late, eccentricity = case.instruments.encoder_delay / case.telemetry.gyro_rate, case.instruments.eccentricity
    angles, stamps = log.fine_state[:, run, mechanics.slices["angle"]], log.time
    if not (late or eccentricity):
        return np.zeros((len(stamps), angles.shape[-1]))
    _, first = np.unique(log.fine_time, return_index=True)
    motion = CubicSpline(log.fine_time[first], angles[first])
    angle = motion(np.clip(stamps - late, 0.0, log.fine_time[-1]))
    phase = _generator(case, _PHASES).uniform(0.0, 2.0 * np.pi, angles.shape[-1])
    return angle - motion(stamps) + eccentricity * (np.sin(angle + phase) - np.sin(phase))


def _generator(case: Case, *purpose: int) -> np.random.Generator:
    return np.random.default_rng([case.seed, _KEY, *purpose])
