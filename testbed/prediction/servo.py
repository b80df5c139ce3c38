"""The angles to which the gimbals' servo brings them: a control loop on its own clock, its motor ideal or late.

Of one gimbal, over each control period from a tick on, with u the demand over the inertia that the motor turns:

    u = ω_b ḋ_s + Δḋ_c / T - load(ω at the period's middle, d at its start),   ḋ_s = ḋ_c + ω_n² / ω_b (d_c - d)
    T_m l̇ = u - l,   d̈ = l - ω_b ḋ + load - friction

The set point ḋ_s stays within the rate limit, and d_c within a bound around d: the law of `cmg.servo_law`, as flown.

What the servo fed forward is the load at the rate that was planned, which nobody sends; what it misses by that is
left out of the comparison (`servo_response.shown`).

A run begins with gimbals at rest and motors without torque, as behind a release; the first demand asks for the whole
rate immediately. An ideal motor is then where one that was moving at that rate would be.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
import scipy
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from testbed.arrays import Array, Series, UnitSeries
from testbed.estimation.telemetry import CommandedRun, GimbalRun, Servo
from testbed.prediction import kernels
from testbed.prediction.compared import long_gaps
from testbed.prediction.smooth import decay
from testbed.prediction.smoothed import body_motion, gimbal_motion
from testbed.prediction.unit_axes import rate_across

_REMEMBERED = 64
"""Runs of which ticks, set points and nominal response are kept, as in `motor_torques`; a miss costs time only."""
_RESONANT = 1e-6
"""Share of the tachometer loop's time constant from which a motor's lag is kept: the formula is 0/0 there."""


class Ticks(NamedTuple):
    """A run on its control clock, N ticks.

    Attributes:
        time: shape (N,), s.
        samples: which ticks were sampled, shape (K,).
        gimbal_rate: as measured, shape (N, M) of M units, rad/s.
        command: ḋ_c, shape (N, M), rad/s.
        fed_forward: u but for the set point, shape (N, M), rad/s².
        load: in the middle of each period, over the inertia, shape (N, M), rad/s².
        load_slope: its rate of change, shape (N, M), rad/s³.
        first_angle: shape (M,), rad.
    """

    time: Series
    samples: Array
    gimbal_rate: UnitSeries
    command: UnitSeries
    fed_forward: UnitSeries
    load: UnitSeries
    load_slope: UnitSeries
    first_angle: Array


@lru_cache(maxsize=_REMEMBERED)
def ticks_of(run: CommandedRun) -> Ticks:
    """Return a run on its control clock."""
    servo, cluster = run.gimbals.servo, run.gimbals.cluster
    start, period = run.actuator_time[0], servo.period
    samples = np.rint((run.actuator_time - start) / period).astype(np.intp)
    time = start + period * np.arange(samples[-1] + 1)
    command = run.through(run.gimbals.rate_command)(time).clip(-servo.rate_limit, servo.rate_limit)
    angle, rate = gimbal_motion(run)(shown_at(run, time)), gimbal_motion(run)(shown_at(run, time), 1)
    change = np.diff(command, axis=0, prepend=np.zeros((1, command.shape[1]))) / period
    middle = shown_at(run, time + 0.5 * period)
    spinning, share, by_turning, by_body = _load_shares(run, middle, angle + 0.5 * period * rate, rate)
    own = cluster.rotor_spin_inertia - cluster.rotor_transverse_inertia
    held, nominal = _rotor_momentum(run, middle) + own * spinning, cluster.rotor_momentum
    load = nominal * (share - 0.5 * period * by_turning) / cluster.gimbal_axis_inertia
    return Ticks(
        time=time,
        samples=samples,
        gimbal_rate=rate,
        command=command,
        fed_forward=change - load,
        load=held * share / cluster.gimbal_axis_inertia,
        load_slope=held * (by_turning + by_body) / cluster.gimbal_axis_inertia,
        first_angle=angle[0],
    )


@lru_cache(maxsize=_REMEMBERED)
def set_point(run: CommandedRun) -> UnitSeries:
    """Return the set point of every tachometer loop at a run's ticks before its limit, shape (N, M), rad/s.

    Behind a long gap in the telemetry the gimbals count as where they were commanded to be. Angles count as recorded,
    however late: what is compared depends on set points, and has to be the same in every model.
    """
    ticks, servo = ticks_of(run), run.gimbals.servo
    angles = gimbal_motion(run)(ticks.time)
    last = np.searchsorted(ticks.samples, np.arange(len(ticks.time)), side="right") - 1
    within_gap = np.concatenate([long_gaps(run), [False]])[last]
    law = (servo.stiffness / servo.bandwidth, servo.angle_error_bound, servo.period)
    return kernels.set_points(ticks.command, angles, within_gap, law)


@lru_cache(maxsize=_REMEMBERED)
def nominal_response(run: CommandedRun) -> UnitSeries:
    """Return the angles of a run's samples with motors as they should be, shape (K, M), rad."""
    units = np.arange(len(ticks_of(run).first_angle))
    return np.asarray(_response(run, units, np.zeros(len(units)), np.zeros_like(ticks_of(run).load)).T)


def shown_at(run: CommandedRun, time: Series) -> Series:
    """Return when a run's angles show the gimbals of given instants, shape (N,), s: later where encoders are late."""
    return np.clip(time + run.gimbals.angles_late, *run.actuator_time[[0, -1]])


def response(run: CommandedRun, lag: Array, friction: Array) -> Array:
    """Return the angles of a run's samples, shape (P, K, M), rad.

    Args:
        run: its commands and its servo.
        lag: T_m, shape (P, M), s.
        friction: and whatever else is in the way, over the inertia, at every tick, shape (P, N, M), rad/s².
    """
    nominal = nominal_response(run)
    late = lag != 0.0
    angles: Any = np.tile(nominal.astype(np.result_type(lag, friction)), (len(lag), 1, 1))
    sets, units = np.nonzero(late)
    if len(sets):
        angles[sets, :, units] = _response(run, units, lag[sets, units], friction[sets, :, units].T)
    sets, units = np.nonzero(~late & np.any(friction != 0.0, axis=1))
    if len(sets):
        angles[sets, :, units] += _pushed(run, -friction[sets, :, units])
    return np.asarray(angles)


def _load_shares(run: GimbalRun, time: Series, angle: Array, rate: Array) -> tuple[Array, ...]:
    """Return ω·s, ω·t, and how the gimbal's and the body's motion change the latter, each of shape (N, M)."""
    cluster = run.gimbals.cluster
    at = np.clip(time, run.gyro_time[0], run.gyro_time[-1])
    (spinning, turned), (_, turned_slope) = (
        rate_across(cluster.gimbal_axis_B, cluster.spin_axis_B, angle, body_motion(run)(at, order)) for order in (0, 1)
    )
    return spinning, turned, -rate * spinning, turned_slope


def _rotor_momentum(run: GimbalRun, time: Series) -> Array:
    """Return Js·Ω as the tachometers show it, the nominal one without them, shape (N, M) or (M,), N·m·s."""
    spin = run.gimbals.rotor_momentum
    if spin is None:
        return run.gimbals.cluster.rotor_momentum
    return np.stack([np.interp(time, run.actuator_time, column) for column in spin.T], axis=1)


def _response(run: CommandedRun, units: NDArray[np.intp], lag: Array, friction: Array) -> Array:
    """Return the angles of some units at the samples, shape (W, K), rad, under lags (W,) and frictions (N, W)."""
    ticks, servo = ticks_of(run), run.gimbals.servo
    of_units = (each[:, units] for each in (ticks.command, ticks.fed_forward, ticks.load, ticks.load_slope))
    command, fed_forward, load, slope = of_units
    signals = (command, fed_forward, load - friction, slope, ticks.first_angle[None, units])
    law = (servo.bandwidth, servo.stiffness / servo.bandwidth, servo.rate_limit, servo.angle_error_bound, servo.period)
    return _sampled(run, kernels.servo_angles(signals, _Step(servo, lag).shares, law).T)


def _sampled(run: CommandedRun, angles: Array) -> Array:
    """Return what a run's encoders show of angles at all ticks, shape (W, N), at the samples, shape (W, K), rad."""
    ticks, late = ticks_of(run), run.gimbals.angles_late
    if not late:
        return np.asarray(angles[:, ticks.samples])
    at = np.clip(run.actuator_time - late, *ticks.time[[0, -1]])
    return np.asarray(CubicSpline(ticks.time, angles, axis=1)(at))


def _pushed(run: CommandedRun, push: Array) -> Array:
    """Return by how much pushes, (W, N), rad/s², move the angles at the samples, (W, K), rad, if motors are ideal."""
    step = _Step(run.gimbals.servo, np.zeros(1))
    return _sampled(run, scipy.signal.lfilter(*step.response_to_push, push, axis=1))


class _Step:
    """One control period T of d̈ = l - ω_b ḋ + load, exactly: demand held, load a line, l after the demand with lag."""

    def __init__(self, servo: Servo, lag: Array) -> None:
        period, bandwidth, self._stiffness = servo.period, servo.bandwidth, servo.stiffness
        lag = np.where(np.abs(bandwidth * lag - 1.0) < _RESONANT, lag + 2.0 * _RESONANT / bandwidth, lag)
        self._left = decay(np.array([period]), lag)  # e^(-T/T_m)
        slowed = np.exp(-bandwidth * period)
        self._rate_kept, self._rate_moves = slowed, (1.0 - slowed) / bandwidth
        self._push_turns, self._push_moves = self._rate_moves, (period - self._rate_moves) / bandwidth
        # Of a push that rises from -½ T to ½ T of its slope.
        ramp_moves = (period**2 / 2 - self._push_moves) / bandwidth
        self._ramp_turns = self._push_moves - 0.5 * period * self._push_turns
        self._ramp_moves = ramp_moves - 0.5 * period * self._push_moves
        # Of what the motor still has of its last demand: ∫ e^(-t/T_m) into rate and angle.
        self._rest_turns = lag * (self._left - slowed) / (bandwidth * lag - 1.0)
        self._rest_moves = (lag * (1.0 - self._left) - self._rest_turns) / bandwidth

    @property
    def response_to_push(self) -> tuple[Array, Array]:
        """Numerator and denominator, in powers of 1/z, from a push in every period to the angle, no motor late.

        The characteristic polynomial of θ' = θ + a ḋ + b (push - k θ), ḋ' = e ḋ + f (push - k θ).
        """
        moved_by_rate, moved, kept, turned = self._rate_moves, self._push_moves, self._rate_kept, self._push_turns
        still = 1.0 - moved * self._stiffness
        numerator = [0.0, moved, moved_by_rate * turned - kept * moved]
        denominator = [1.0, -(still + kept), still * kept + moved_by_rate * turned * self._stiffness]
        return np.array(numerator), np.array(denominator)

    @property
    def shares(self) -> tuple[Array, ...]:
        """What a period makes of rate, push, rest and slope: the angle's, the rate's, and the rest that remains."""
        of_angle = (self._rate_moves, self._push_moves, self._rest_moves, self._ramp_moves)
        of_rate = (self._rate_kept, self._push_turns, self._rest_turns, self._ramp_turns)
        return (*of_angle, *of_rate, self._left)
