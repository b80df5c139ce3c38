"""What all sensors share: dividing the clock, rounding the reading, and one random generator per noise source."""

from __future__ import annotations

import math

import numpy as np

from testbed.arrays import Array, Units
from testbed.errors import InputError


def ticks_per_sample(clock_rate: float, sample_rate: float, sensor: str) -> int:
    """Return how many ticks of a clock lie between two samples of a sensor.

    Args:
        clock_rate: Hz.
        sample_rate: Hz; the clock rate over an integer.
        sensor: what the message calls the sensor.

    Raises:
        InputError: the sample rate does not divide the clock rate; the message names the nearest rates that do.
    """
    ratio = clock_rate / sample_rate
    ticks = round(ratio)
    if ticks < 1 or not math.isclose(ratio, ticks, rel_tol=1e-9):
        faster, slower = clock_rate / max(1, math.floor(ratio)), clock_rate / math.ceil(ratio)
        nearest = " or ".join(f"{rate:g}" for rate in sorted({faster, slower}))
        raise InputError(
            f"{sensor}: a sample rate of {sample_rate:g} Hz does not divide the clock of {clock_rate:g} Hz; "
            f"use {nearest} Hz, or another clock"
        )
    return ticks


def quantized(value: Array, step: Units | float) -> Array:
    """Round to the nearest multiple of the step.

    Args:
        value: any shape.
        step: in the value's unit, broadcast against it; positive, or zero for no quantization.
    """
    return np.asarray(step * np.rint(value / step)) if np.any(step) else value


def generators(seed: np.random.SeedSequence, count: int) -> list[np.random.Generator]:
    """Return one independent generator per noise source.

    The seed itself stays as it was (its own `spawn` counts its children), so that the same seed gives the same
    numbers however often it is used.

    Args:
        seed: of one sensor in one flight.
        count: number of noise sources.
    """
    fresh = np.random.SeedSequence(entropy=seed.entropy, spawn_key=seed.spawn_key, pool_size=seed.pool_size)
    return [np.random.default_rng(child) for child in fresh.spawn(count)]
