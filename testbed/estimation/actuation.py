"""What the actuators did, at any time: their momentum, the inertia they shift, and the torque applied."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from scipy.interpolate import CubicSpline

from testbed.arrays import Array, Matrices3, Series, UnitSeries, Vectors3
from testbed.cmg.cluster import Cluster, cluster_momentum, inertia_change
from testbed.estimation.telemetry import Telemetry

_BLOCK = 16_384
"""Instants whose units' axes are worked out at once: they take 600 bytes each, and fit into a processor's cache."""


@dataclass(frozen=True, kw_only=True)
class Actuation:
    """The known part of the platform's angular momentum at N times, body axes.

    Attributes:
        cluster_momentum_B: h, shape (N, 3), N·m·s.
        inertia_change_B: J(d) - J(0), shape (N, 3, 3), kg·m².
        applied_torque_B: shape (N, 3), N·m.
    """

    cluster_momentum_B: Vectors3
    inertia_change_B: Matrices3
    applied_torque_B: Vectors3


class GimbalMotion(NamedTuple):
    """What encoders and tachometers say at N times.

    Attributes:
        angle: d, shape (N, 6), rad.
        rate: ḋ, shape (N, 6), rad/s.
        rotor_momentum: Js·Ω, shape (N, 6), N·m·s; the nominal one where there are no tachometers.
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
    blocks = [_actuation(telemetry, splines, time[first : first + _BLOCK]) for first in range(0, len(time), _BLOCK)]
    if len(blocks) == 1:
        return blocks[0]
    return Actuation(
        cluster_momentum_B=np.concatenate([block.cluster_momentum_B for block in blocks]),
        inertia_change_B=np.concatenate([block.inertia_change_B for block in blocks]),
        applied_torque_B=np.concatenate([block.applied_torque_B for block in blocks]),
    )


def gimbal_motion(telemetry: Telemetry, cluster: Cluster, gimbal_angle: UnitSeries, time: Series) -> GimbalMotion:
    """Return the gimbals' motion at given times, from cubic splines through the samples.

    Args:
        telemetry: the tachometers and the samples' times.
        cluster: the units.
        gimbal_angle: encoders, shape (K, 6), rad.
        time: shape (N,), s.
    """
    spin = telemetry.rotor_momentum
    return _gimbal_motion(
        cluster, _angle_spline(telemetry, gimbal_angle), None if spin is None else _spline(telemetry, spin), time
    )


class _Splines(NamedTuple):
    """Through the samples of what a run has; None of what it has not."""

    angle: CubicSpline | None
    spin: CubicSpline | None
    momentum: CubicSpline | None
    torque: CubicSpline | None


@lru_cache(maxsize=1)  # every grid of an estimate asks for the same run's
def _splines(telemetry: Telemetry) -> _Splines:
    def through(samples: Array | None) -> CubicSpline | None:
        return None if samples is None else _spline(telemetry, samples)

    angle = None if telemetry.cluster is None else telemetry.gimbal_angle
    return _Splines(
        angle=None if angle is None else _angle_spline(telemetry, angle),
        spin=None if angle is None else through(telemetry.rotor_momentum),
        momentum=None if angle is not None else through(telemetry.cluster_momentum),
        torque=through(telemetry.applied_torque),
    )


def _actuation(telemetry: Telemetry, splines: _Splines, time: Series) -> Actuation:
    momentum_B, change_B = _momentum_and_change(telemetry.cluster, splines, time)
    return Actuation(
        cluster_momentum_B=momentum_B,
        inertia_change_B=change_B,
        applied_torque_B=np.zeros((len(time), 3)) if splines.torque is None else splines.torque(time),
    )


def _momentum_and_change(cluster: Cluster | None, splines: _Splines, time: Series) -> tuple[Vectors3, Matrices3]:
    if cluster is not None and splines.angle is not None:
        motion = _gimbal_motion(cluster, splines.angle, splines.spin, time)
        return cluster_momentum(cluster, *motion), inertia_change(cluster, motion.angle)
    known_B = np.zeros((len(time), 3)) if splines.momentum is None else splines.momentum(time)
    return known_B, np.zeros((len(time), 3, 3))


def _gimbal_motion(cluster: Cluster, angle: CubicSpline, spin: CubicSpline | None, time: Series) -> GimbalMotion:
    nominal = np.broadcast_to(cluster.rotor_momentum, (len(time), len(cluster.rotor_momentum)))
    return GimbalMotion(angle(time), angle(time, 1), nominal if spin is None else spin(time))


def _angle_spline(telemetry: Telemetry, gimbal_angle: UnitSeries) -> CubicSpline:
    return _spline(telemetry, np.unwrap(gimbal_angle, axis=0))  # encoders may start over after a turn


def _spline(telemetry: Telemetry, samples: Array) -> CubicSpline:
    return CubicSpline(telemetry.actuator_time, samples)
