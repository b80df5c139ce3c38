"""What the motors of reaction wheels were asked to give between samples, and what the wheels' own motion took.

Of one wheel, with a its axis: Jw (Ω̇ + a·ω̇) = τ - c Ω - τ_c sign Ω. From one sample to the next nothing has to be
differentiated: Jw (ΔΩ + a·Δω) + ∫ friction dt, from tachometer and gyro, is the impulse ∫ τ dt.

The tachometer's noise stands in two impulses, with opposite signs; what turns a wheel beside all that is predicted adds
an impulse of its own to each. Impulses are compared without the correlation that this makes: what is constant in time
then counts by its integral over the record, as it should. Every wheel is compared by itself: where one turns round, or
is at a limit, the impulses of the others are as good as ever.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import lru_cache
from math import prod
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from testbed.arrays import Array, Flags, Units, UnitSeries
from testbed.estimation.recursions import accumulated, pivots
from testbed.estimation.telemetry import Telemetry, WheelTelemetry
from testbed.prediction.compared import SETTLING, incomplete
from testbed.prediction.smooth import decay
from testbed.prediction.smoothed import body_motion
from testbed.prediction.wheel_commands import Motors, torques_between

_REMEMBERED = 64
"""Runs whose impulses are kept, as many as in `motor_torques`; a miss costs time only."""
_AT_LIMIT = 0.98
"""Share of a wheel's limits from which on it may have been held at one: a tachometer's noise is less than the rest."""
_STICKING = 0.5
"""rad/s. A bearing that turns more slowly, or turns round, may stick, and then takes any torque within its dry
friction: ten times a good tachometer's noise, and a thousandth of what wheels turn at."""


class Impulses(NamedTuple):
    """W wheels in the L intervals between a run's samples.

    Attributes:
        interval: shape (L,), s.
        torque: mean that the motors were asked for, or gave, shape (L, W), N·m.
        last: the same at the interval's end, which differs over lost samples, shape (L, W), N·m.
        gained: Jw (ΔΩ + a·Δω), shape (L, W), N·m·s.
        carried: Jw a·Δω of it, which the body turns with the wheel, shape (L, W), N·m·s.
        friction: ∫ of the friction that is known, shape (L, W), N·m·s.
        turned: ∫ Ω dt, shape (L, W), rad.
        directed: ∫ sign Ω dt, shape (L, W), s.
        viscous: friction over speed that is known, shape (W,), N·m·s/rad.
        unseen: variance of what was asked for over lost samples, shape (L, W), (N·m·s)²; zero where none is lost,
            infinite where it is not known, as where a torque jumps in between.
        between: share of the control periods whose torques are not sampled.
        kept: of each wheel the intervals that are compared, shape (K,), K of its own.
        first: which of these do not follow on the one before, likewise.
    """

    interval: Array
    torque: UnitSeries
    last: UnitSeries
    gained: UnitSeries
    carried: UnitSeries
    friction: UnitSeries
    turned: UnitSeries
    directed: UnitSeries
    viscous: Units
    unseen: Array
    between: float
    kept: tuple[NDArray[np.intp], ...]
    first: tuple[NDArray[np.bool_], ...]

    @property
    def asked(self) -> UnitSeries:
        """Impulses that the motors were asked for, or gave, shape (L, W), N·m·s."""
        return np.asarray(self.torque * self.interval[:, None])

    @property
    def unknown(self) -> Flags:
        """Intervals in which nobody knows what the motor of some wheel was asked for, shape (L,)."""
        return _unknown(self.unseen)

    @property
    def complete(self) -> Impulses:
        """The impulses, of which those over lost samples are not compared."""
        kept = tuple(rows[self.unseen[rows, wheel] == 0.0] for wheel, rows in enumerate(self.kept))
        return self._replace(kept=kept, first=_first_of(kept))

    @property
    def needed(self) -> UnitSeries:
        """Impulses that the wheels' motion took of the motors, shape (L, W), N·m·s."""
        return self.gained + self.friction


class ImpulseNoise(NamedTuple):
    """In what noise impulses are compared, and which.

    Attributes:
        commanded: whether those that are commanded, and not those that were measured, are held against the motion.
        wheels: indices of the C wheels that are compared.
        tachometer: standard deviation s of a sample of their Jw Ω, shape (C,), N·m·s.
        torque: density ρ of the torques beside all that is predicted, shape (C,), N²·m²·s.
        interval: the usual one between samples, s.
    """

    commanded: bool
    wheels: tuple[int, ...]
    tachometer: Units
    torque: Units
    interval: float

    def compares_as(self, other: ImpulseNoise) -> bool:
        """Return whether the same wheels are compared by the same channel."""
        return (self.commanded, self.wheels) == (other.commanded, other.wheels)

    @property
    def sigma(self) -> Units:
        """Standard deviation of what `without_correlation` leaves, shape (C,), N·m·s.

        F = 2 s² + ρ Δt - s⁴ / F of an impulse behind many.
        """
        half = self.tachometer**2 + 0.5 * self.torque * self.interval
        return np.asarray(np.sqrt(half + np.sqrt(np.maximum(half**2 - self.tachometer**4, 0.0))))


def impulses_of(run: Telemetry, *, commanded: bool) -> Impulses | None:
    """Return the impulses of a run's wheels; None where the channel, or what is known of the motors, is missing.

    Args:
        run: its wheels.
        commanded: by the torques that were commanded, or else by those that were measured.
    """
    wheels = run.wheels
    if wheels is None or wheels.motors is None:
        return None
    torque = wheels.torque_command if commanded else wheels.torque
    return None if torque is None else _impulses(run, commanded)


def lagged(impulses: Impulses, lag: Array) -> Array:
    """Return the impulses that motors give which follow their commands with a first-order lag, shape (P, L, W), N·m·s.

    T τ̇ = u - τ: ∫ τ dt = ∫ u dt + T (τ_0 - τ_1), with τ_1 = u + (τ_0 - u) e^(-Δt/T) of the u held at the end.

    Args:
        impulses: of the commands.
        lag: T, shape (P, W), s.
    """
    asked = np.broadcast_to(impulses.asked, (len(lag), *impulses.asked.shape))
    if not np.any(lag):
        return asked
    torque, left = impulses.last, decay(impulses.interval[:, None], lag[:, None])
    steps = np.concatenate([np.zeros_like(torque[:1]), torque[:-1] - torque[1:]])
    behind = accumulated(np.roll(left, 1, axis=1), steps[None])  # τ_0 - u of every interval
    return np.asarray(asked + behind * lag[:, None] * (1.0 - left))


def delayed(impulses: Impulses, given: Array, delay: Array) -> Array:
    """Return the impulses of motors that give everything so much later, shape (P, L, W), N·m·s.

    What had been given until t, C(t), is taken at t - T. Between samples C is a line, as exactly where a command holds
    from one to the next; where several control periods pass, a parabola by how impulses change from interval to
    interval. Before the record, motors gave what they give first. A delay of more than a usual interval moves what is
    not known of lost samples into intervals that are compared.

    Args:
        impulses: in which intervals, and how much of their torques is not sampled.
        given: without the delay, shape (P or 1, L, W), N·m·s.
        delay: T, shape (P or 1, W), s.
    """
    if not np.any(delay):
        return given
    time = np.concatenate([[0.0], np.cumsum(impulses.interval)])
    late = time[:, None] - delay[:, None]
    inside = np.clip(np.searchsorted(time, late.real, side="left") - 1, 0, len(time) - 2)
    since, width = late - time[inside], impulses.interval[inside]
    mean = given / impulses.interval[:, None]
    bend = impulses.between * (2.0 - impulses.between) * np.gradient(mean, axis=1) / impulses.interval[:, None]
    until = np.concatenate([np.zeros_like(given[:, :1]), np.cumsum(given, axis=1)], axis=1)
    base, slope, curve = (_at(each, inside) for each in (until, mean, bend))
    total = base + slope * since - np.where(since.real < 0.0, 0.0, 0.5 * curve * since * (width - since))
    return np.asarray(np.diff(total, axis=1))


def _at(values: Array, rows: NDArray[np.intp]) -> Array:
    """Return values of shape (P or 1, N, W) at rows of shape (P or 1, K, W), of each wheel its own."""
    sets = max(len(values), len(rows))
    return np.take_along_axis(
        np.broadcast_to(values, (sets, *values.shape[1:])), np.broadcast_to(rows, (sets, *rows.shape[1:])), axis=1
    )


def without_correlation(impulses: Impulses, noise: ImpulseNoise, values: Array) -> list[Array]:
    """Return the part of compared impulses that those before do not foretell, of each wheel, shape (..., K), N·m·s.

    With the covariance 2 s² + ρ Δt_k + u_k of each, u_k over lost samples, and -s² of neighbours, by its Cholesky
    factor; scaled so that their noise is `ImpulseNoise.sigma` everywhere.

    Args:
        impulses: of the run.
        noise: s and ρ, and which C wheels are compared.
        values: in all intervals, shape (..., L, W), N·m·s.
    """
    parts = zip(noise.wheels, noise.sigma, _factors(impulses, noise), strict=True)
    return [
        _uncorrelated(values[..., impulses.kept[wheel], wheel], coupled, pivot) * (sigma / np.sqrt(pivot))
        for wheel, sigma, (coupled, pivot) in parts
    ]


def impulse_scale(impulses: Impulses, noise: ImpulseNoise) -> list[Array]:
    """Return what `without_correlation` scales the compared impulses of each wheel by, shape (K,)."""
    return [sigma / np.sqrt(pivot) for sigma, (_, pivot) in zip(noise.sigma, _factors(impulses, noise), strict=True)]


def _factors(impulses: Impulses, noise: ImpulseNoise) -> Iterator[tuple[Array, Array]]:
    """Yield of each wheel s² where an impulse follows on another, and the covariance's pivots, both of shape (K,)."""
    for wheel, tachometer, torque in zip(noise.wheels, noise.tachometer, noise.torque, strict=True):
        coupled = np.where(impulses.first[wheel], 0.0, tachometer**2)
        kept = impulses.kept[wheel]
        own = 2.0 * tachometer**2 + torque * impulses.interval[kept] + impulses.unseen[kept, wheel]
        yield coupled, pivots(own[:, None], coupled[:, None])[:, 0]


def _uncorrelated(values: Array, coupled: Array, pivot: Array) -> Array:
    """Return a wheel's impulses, shape (..., K), less what those before foretell of them."""
    kept = np.concatenate([np.zeros_like(pivot[:1]), coupled[1:] / pivot[:-1]])
    flat = values.reshape(prod(values.shape[:-1]), values.shape[-1], 1)
    return np.asarray(accumulated(kept[None, :, None], flat).reshape(values.shape))


@lru_cache(maxsize=_REMEMBERED)
def _impulses(run: Telemetry, commanded: bool) -> Impulses:
    wheels, time = run.wheels, run.actuator_time
    assert wheels is not None
    assert wheels.motors is not None
    motors, interval = wheels.motors, np.diff(time)
    speed = wheels.momentum / wheels.wheels.spin_inertia
    body_rate = body_motion(run)(np.clip(time, run.gyro_time[0], run.gyro_time[-1]))
    before, after, inertia = speed[:-1], speed[1:], wheels.wheels.spin_inertia
    carried = inertia * np.diff(body_rate @ wheels.wheels.axis_B.T, axis=0)
    turned, directed = 0.5 * (before + after) * interval[:, None], _direction(before, after) * interval[:, None]
    torque, last, unseen = torques_between(run, wheels, Motors(wheels.wheels.torque_limit, motors, commanded))
    behind = np.concatenate([[False], _unknown(unseen)[:-1]])  # where a lag carries on what was commanded in between
    unseen = _carried_on(unseen, incomplete(run))
    known = np.isfinite(unseen) & ~behind[:, None] & _is_compared(run, wheels, speed)
    kept = tuple(np.flatnonzero(of_wheel) for of_wheel in known.T)
    return Impulses(
        interval=interval,
        torque=torque,
        last=last,
        gained=inertia * np.diff(speed, axis=0) + carried,
        carried=carried,
        friction=motors.viscous_friction * turned + motors.coulomb_friction * directed,
        turned=turned,
        directed=directed,
        viscous=motors.viscous_friction,
        unseen=unseen,
        between=1.0 - min(motors.period / float(np.median(interval)), 1.0),
        kept=kept,
        first=_first_of(kept),
    )


def _carried_on(unseen: Array, gap: Flags) -> Array:
    """Return variances of what was asked for, those of intervals behind a gap at least as large as the gap's.

    What a lag carries on into them is known no better. They are compared all the same: without them the sum of
    impulses over a run begins anew behind each gap, and a small constant torque shows in that sum alone.
    """
    before = np.concatenate([np.zeros_like(unseen[:1]), np.where(gap[:, None], unseen, 0.0)[:-1]])
    return np.asarray(np.maximum(unseen, before))


def _unknown(unseen: Array) -> Flags:
    """Return in which intervals what some motor was asked for has no variance that anybody knows, shape (L,)."""
    return np.asarray(~np.isfinite(unseen).all(axis=1))


def _first_of(kept: Sequence[NDArray[np.intp]]) -> tuple[NDArray[np.bool_], ...]:
    """Return which of each wheel's intervals do not follow on the one before."""
    return tuple(np.diff(of_wheel, prepend=-2) > 1 for of_wheel in kept)


def _direction(before: UnitSeries, after: UnitSeries) -> UnitSeries:
    """Return the mean sign of speeds that change along a line, shape (L, W)."""
    change = after - before
    turning = (np.abs(after) - np.abs(before)) / np.where(change == 0.0, 1.0, change)
    return np.where(before * after > 0.0, np.sign(before), turning)


def _has_rate(run: Telemetry) -> Flags:
    """Return at which actuator samples the body rate is known, shape (K,): within a usual interval of a gyro sample."""
    time, gyro = run.actuator_time, run.gyro_time
    after = np.clip(np.searchsorted(gyro, time), 1, len(gyro) - 1)
    nearest = np.minimum(np.abs(time - gyro[after - 1]), np.abs(time - gyro[after]))
    inside = (time >= gyro[0] + SETTLING) & (time <= gyro[-1])
    return np.asarray(inside & (nearest <= np.median(np.diff(gyro))))


def _is_compared(run: Telemetry, wheels: WheelTelemetry, speed: UnitSeries) -> NDArray[np.bool_]:
    """Return between which samples each wheel may be compared, shape (L, W): not at a limit, nor where it may stick."""
    limits = wheels.wheels
    known = _has_rate(run)[:, None] & (np.abs(wheels.momentum) < _AT_LIMIT * limits.momentum_limit)
    known &= np.abs(speed) > _STICKING
    if wheels.torque_command is not None:
        known &= np.abs(wheels.torque_command) < _AT_LIMIT * limits.torque_limit
    return np.asarray(known[1:] & known[:-1] & (speed[1:] * speed[:-1] > 0.0))
