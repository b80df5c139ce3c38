"""A rig of one axis with a wheel on it: its bearing, its wheel, its gyro and what they hide, as one equation of motion.

The state is the momentum about the axis, y = J ω + h, which only the bearing and the air change:

    ẏ = -c ω - τ tanh(ω / w),   T ḣ = (1 + g) h_asked(t - d) - h,   |ḣ| at most the wheel's greatest torque.

What is recorded as `cluster_momentum` is the momentum that was asked for, on a clock that may be late against that of
the gyro.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from concealing.craft import SIGN_WIDTH, Array
from testbed.records.record import Record, RunDetails

_STEP = 1e-3
"""s; the fastest that is integrated is a dry friction's change of sign, of some 100 1/s."""
_AXES = ("x", "y", "z")
_TONES = 4


@dataclass(frozen=True, kw_only=True)
class Rig:
    """Everything that is true of the rig.

    Attributes:
        axis: of the body, about which it turns.
        inertia: about it, kg·m².
        viscous: of the bearing, N·m·s/rad.
        dry: of the bearing, N·m.
        gain_error: of the wheel, true over asked momentum less 1.
        lag: of the wheel, s.
        delay: of the wheel, s.
        greatest_torque: of the wheel, N·m.
        late: of the recorded momentum against the gyro, s; negative where it is early.
        averaging: over which the gyro averages, s; 0 where it samples.
        bias: of the gyro, rad/s.
        noise: of the gyro, rad/s.
        correlation: of the noise from sample to sample.
        held: what the gyro shows of the axes that the bearing holds: nothing, zeros, or its noise.
    """

    axis: str = "z"
    inertia: float = 0.05
    viscous: float = 0.0
    dry: float = 0.0
    gain_error: float = 0.0
    lag: float = 0.0
    delay: float = 0.0
    greatest_torque: float = np.inf
    late: float = 0.0
    averaging: float = 0.0
    bias: float = 0.0
    noise: float = 1e-3
    correlation: float = 0.0
    held: str = "empty"


def rig_record(
    rig: Rig,
    name: str,
    seed: int,
    *,
    seconds: float = 10.0,
    rate: float = 50.0,
    momentum: float = 0.02,
    fastest: float = 1.5,
    role: str | None = None,
) -> Record:
    """Return what the rig records while its wheel follows four sines, turning from the start.

    Args:
        rig: as it is.
        name: of the run.
        seed: of the asked momentum, the initial rate and the noise.
        seconds: of the record.
        rate: Hz, of gyro and wheel.
        momentum: largest of a sine, N·m·s.
        fastest: sine, Hz.
        role: of the run.
    """
    rng = np.random.default_rng(seed)
    asked = _asked(rng, momentum, fastest)
    time = np.arange(round(seconds * rate) + 1) / rate
    body_rate = _shown(rig, asked, float(rng.normal(0.0, 0.2)), time)
    readings = np.full((len(time), 3), {"empty": np.nan}.get(rig.held, 0.0))
    if rig.held == "noise":
        readings += rng.normal(0.0, rig.noise, readings.shape)
    own = _AXES.index(rig.axis)
    readings[:, own] = body_rate + rig.bias + rig.noise * _coloured(rng, len(time), rig.correlation)
    recorded = np.zeros((len(time), 3))
    recorded[:, own] = [asked(at - rig.late) for at in time]
    return Record(
        time=time,
        channels={"body_rate": readings, "cluster_momentum": recorded},
        details=RunDetails(name=name, gyro_noise=rig.noise, role=role),  # type: ignore[arg-type] - one of its words
    )


def _asked(rng: np.random.Generator, momentum: float, fastest: float) -> Callable[[float], float]:
    frequency = 2.0 * np.pi * rng.uniform(0.1, fastest, _TONES)
    phase = rng.uniform(0.0, 2.0 * np.pi, _TONES)
    size = momentum * rng.uniform(0.3, 1.0, _TONES)
    return lambda time: float((size * np.sin(frequency * time + phase)).sum())


def _shown(rig: Rig, asked: Callable[[float], float], released: float, time: Array) -> Array:
    """Return what a gyro without bias and noise shows at its samples, rad/s."""
    grid = np.arange(0.0, time[-1] + _STEP, _STEP)
    wheel = _wheel(rig, asked, grid)
    total, rates = rig.inertia * released + wheel[0], []
    for index in range(len(grid)):
        rates.append((total - wheel[index]) / rig.inertia)
        if index + 1 < len(grid):
            total += _gained(rig, total, wheel[index], wheel[index + 1])
    turned = np.concatenate([[0.0], np.cumsum(0.5 * _STEP * (np.array(rates[1:]) + np.array(rates[:-1])))])
    if rig.averaging == 0.0:
        return np.interp(time, grid, rates)
    before = np.interp(time - rig.averaging, grid, turned) + np.minimum(time - rig.averaging, 0.0) * rates[0]
    return (np.interp(time, grid, turned) - before) / rig.averaging


def _gained(rig: Rig, total: float, before: float, after: float) -> float:
    """Return the momentum that bearing and air add over one step, by the midpoint rule."""

    def torque(momentum: float, wheel: float) -> float:
        rate = (momentum - wheel) / rig.inertia
        return -rig.viscous * rate - rig.dry * float(np.tanh(rate / SIGN_WIDTH))

    half = total + 0.5 * _STEP * torque(total, before)
    return _STEP * torque(half, 0.5 * (before + after))


def _wheel(rig: Rig, asked: Callable[[float], float], grid: Array) -> Array:
    """Return the momentum that the wheel holds, N·m·s: settled on what is asked at the start."""
    wanted = (1.0 + rig.gain_error) * np.array([asked(at - rig.delay) for at in grid])
    if rig.lag == 0.0 and not np.isfinite(rig.greatest_torque):
        return wanted
    kept = float(np.exp(-_STEP / rig.lag)) if rig.lag > 0.0 else 0.0
    most = rig.greatest_torque * _STEP
    held = [wanted[0]]
    for before, after in pairwise(wanted):  # exact for what is asked along a straight line
        behind = rig.lag * (after - before) / _STEP
        reached = after - behind + kept * (held[-1] - before + behind)
        held.append(held[-1] + float(np.clip(reached - held[-1], -most, most)))
    return np.array(held)


def _coloured(rng: np.random.Generator, count: int, correlation: float) -> Array:
    """Return noise of unit variance whose neighbours correlate (AR(1)), shape (N,)."""
    white = rng.standard_normal(count)
    if correlation == 0.0:
        return white
    noise = [white[0]]
    for each in white[1:]:
        noise.append(correlation * noise[-1] + np.sqrt(1.0 - correlation**2) * each)
    return np.array(noise)
