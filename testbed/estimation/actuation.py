"""What the actuators did, at any time: their momentum, the inertia they shift, and the torque applied."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from scipy.interpolate import CubicSpline

from testbed.arrays import Array, Axes, Matrices3, Series, UnitSeries, Vectors3
from testbed.cmg.cluster import Cluster, cluster_momentum, inertia_change
from testbed.estimation.telemetry import GimbalRun, Telemetry, has_gimbals

_BLOCK = 16_384
"""Instants whose units' axes are computed together: they take 600 bytes each, and fit into a processor's cache."""


@dataclass(frozen=True, kw_only=True)
class Actuation:
    """The known part of the platform's angular momentum at N times, body axes; of flights side by side on leading axes.

    Attributes:
        cluster_momentum_B: h, shape (N, 3), N·m·s.
        inertia_change_B: J(d) - J(0), shape (N, 3, 3), kg·m².
        applied_torque_B: of actuators and, by the attitude as it is known, of the environment, shape (N, 3), N·m; a
            torque that is held from sample to sample is none of an instant, and left to `Telemetry.held_torque`.
    """

    cluster_momentum_B: Vectors3
    inertia_change_B: Matrices3
    applied_torque_B: Vectors3


class GimbalMotion(NamedTuple):
    """What the encoders and tachometers of M units show at N times.

    Attributes:
        angle: d, shape (N, M), rad.
        rate: ḋ, shape (N, M), rad/s.
        rotor_momentum: Js·Ω, shape (N, M), N·m·s; the nominal one where there are no tachometers.
    """

    angle: UnitSeries
    rate: UnitSeries
    rotor_momentum: UnitSeries


def actuation(telemetry: Telemetry, time: Series) -> Actuation:
    """Return the actuators' part at given times, from cubic splines through their samples.

    Gimbal rates are the spline's slope: their share of h is 0.2 % of the spin momentum's, so that encoder noise does
    not matter there.

    Args:
        telemetry: the measurements.
        time: shape (N,), s, within the actuator telemetry.
    """
    splines = _splines(telemetry)
    blocks = [_actuation(splines, time[first : first + _BLOCK]) for first in range(0, len(time), _BLOCK)]
    if len(blocks) == 1:
        return blocks[0]
    return Actuation(
        cluster_momentum_B=np.concatenate([block.cluster_momentum_B for block in blocks], axis=-2),
        inertia_change_B=np.concatenate([block.inertia_change_B for block in blocks], axis=-3),
        applied_torque_B=np.concatenate([block.applied_torque_B for block in blocks], axis=-2),
    )


def gimbal_motion(run: GimbalRun, time: Series) -> GimbalMotion:
    """Return the gimbals' motion at given times, from cubic splines through the samples.

    Args:
        run: its encoders, tachometers and their times.
        time: shape (N,), s.
    """
    return _gimbal_splines(run).at(time)


class _GimbalSplines(NamedTuple):
    """Through the samples of a run's gimbals; none of rotors without tachometers."""

    cluster: Cluster
    angle: CubicSpline
    spin: CubicSpline | None

    def at(self, time: Series) -> GimbalMotion:
        nominal = np.broadcast_to(self.cluster.rotor_momentum, (len(time), len(self.cluster.rotor_momentum)))
        rate = np.ascontiguousarray(self.angle(time, 1))
        return GimbalMotion(_at(self.angle, time), rate, nominal if self.spin is None else _at(self.spin, time))


def _at(spline: CubicSpline, time: Series) -> Array:
    """Return a spline's values, flight after flight in memory: products are then rounded as those of one flight."""
    return np.ascontiguousarray(spline(time))


class _Splines(NamedTuple):
    """Through the samples of what a run has; None of what it has not."""

    gimbals: _GimbalSplines | None
    wheels: CubicSpline | None
    wheel_axes_B: Axes
    momentum: CubicSpline | None
    torque: CubicSpline | None
    outside: Callable[[Series], Vectors3] | None


@lru_cache(maxsize=1)  # every grid of an estimate asks for the same run's
def _splines(telemetry: Telemetry) -> _Splines:
    reported, torque = telemetry.cluster_momentum, telemetry.applied_torque
    gimbals = _gimbal_splines(telemetry) if has_gimbals(telemetry) else None
    wheels = telemetry.wheels
    known = gimbals is not None or wheels is not None
    return _Splines(
        gimbals=gimbals,
        wheels=None if wheels is None else telemetry.momentum_through(wheels.momentum, axis=-2),
        wheel_axes_B=np.zeros((0, 3)) if wheels is None else wheels.wheels.axis_B,
        momentum=None if known or reported is None else telemetry.momentum_through(reported, axis=-2),
        torque=None if torque is None or telemetry.torque_held else telemetry.through(torque, axis=-2),
        outside=_outside(telemetry),
    )


def _outside(telemetry: Telemetry) -> Callable[[Series], Vectors3] | None:
    surroundings = telemetry.surroundings
    if surroundings is None:
        return None
    body_rate = CubicSpline(telemetry.gyro_time, telemetry.body_rate)
    return lambda time: surroundings.torque(time, body_rate(time))


def _gimbal_splines(run: GimbalRun) -> _GimbalSplines:
    spin = run.gimbals.rotor_momentum
    return _GimbalSplines(
        cluster=run.gimbals.cluster,
        angle=run.through(np.unwrap(run.gimbals.angle, axis=-2), axis=-2),  # encoders may start over after a turn
        spin=None if spin is None else run.through(spin, axis=-2),
    )


def _actuation(splines: _Splines, time: Series) -> Actuation:
    momentum_B, change_B = _momentum_and_change(splines, time)
    if splines.wheels is not None:
        momentum_B = momentum_B + _at(splines.wheels, time) @ splines.wheel_axes_B
    torque_B = np.zeros((len(time), 3)) if splines.torque is None else _at(splines.torque, time)
    if splines.outside is not None:
        torque_B = torque_B + splines.outside(time)
    return Actuation(cluster_momentum_B=momentum_B, inertia_change_B=change_B, applied_torque_B=torque_B)


def _momentum_and_change(splines: _Splines, time: Series) -> tuple[Vectors3, Matrices3]:
    if splines.gimbals is not None:
        cluster, motion = splines.gimbals.cluster, splines.gimbals.at(time)
        return cluster_momentum(cluster, *motion), inertia_change(cluster, motion.angle)
    known_B = np.zeros((len(time), 3)) if splines.momentum is None else _at(splines.momentum, time)
    return known_B, np.zeros((len(time), 3, 3))
