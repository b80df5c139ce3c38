"""Sensors with one channel per CMG unit: gimbal encoders, rotor tachometers, gimbal motor currents."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from testbed.arrays import Units, UnitSeries
from testbed.sensors.sampling import generators, quantized


@dataclass(frozen=True, kw_only=True)
class UnitSensor:
    """One sensor per CMG unit: reading = q((1 + scale) true + zero + noise), in the unit of what it measures.

    A gimbal encoder has noise, zero and quantization (rad), a tachometer noise and scale (rad/s), a motor current
    read as gimbal torque has noise (N·m). Each is one number for all units, or shape (M,).

    Attributes:
        white_noise: standard deviation per sample.
        zero_offset: reading where the truth is zero.
        scale_factor_error: relative.
        quantization: step of the reading; positive for all units, or zero for none.
    """

    white_noise: Units | float = 0.0
    zero_offset: Units | float = 0.0
    scale_factor_error: Units | float = 0.0
    quantization: Units | float = 0.0


def unit_errors(sensor: UnitSensor, samples: int, units: int, seed: np.random.SeedSequence) -> UnitSeries:
    """Draw zero and noise of one flight, shape (samples, units).

    A batch stacks the errors of its flights on axis 1.

    Args:
        sensor: the sensor.
        samples: number of readings of the flight.
        units: M, number of CMG units.
        seed: of this sensor in this flight; the same seed gives the same errors.
    """
    errors = np.zeros((samples, units)) + sensor.zero_offset
    if np.any(sensor.white_noise):
        (white,) = generators(seed, 1)
        errors += sensor.white_noise * white.standard_normal((samples, units))
    return errors


def encoder_side(angle: UnitSeries, rate: UnitSeries, dead_zone: Units) -> UnitSeries:
    """Return d + (b/2) sign(ḋ), the angle of a play's side that an encoder sees. Broadcasts over leading axes.

    The motor, with the encoder, drags the axis along and leads it by half the play.

    Args:
        angle: d of the axis, shape (..., 6), rad.
        rate: ḋ of the axis, shape (..., 6), rad/s.
        dead_zone: b, shape (6,), rad.
    """
    return np.asarray(angle + 0.5 * dead_zone * np.sign(rate))


def read_units(sensor: UnitSensor, true_value: UnitSeries, errors: UnitSeries) -> UnitSeries:
    """Return what the sensor reads. Broadcasts over leading axes: a tick, a series or a batch.

    Args:
        sensor: the sensor.
        true_value: shape (..., M).
        errors: of the same samples, from `unit_errors`, shape (..., M).
    """
    return quantized(true_value * (1.0 + np.asarray(sensor.scale_factor_error)) + errors, sensor.quantization)
