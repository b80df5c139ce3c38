"""What the actuators did, at any time: their momentum, the inertia they shift, and the torque applied."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.interpolate import CubicSpline

from testbed.arrays import Array, Matrices3, Series, UnitSeries, Vectors3
from testbed.cmg.cluster import Cluster, cluster_momentum, inertia_change
from testbed.estimation.telemetry import Telemetry


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
    momentum_B, change_B = _momentum_and_change(telemetry, time)
    torque_B = telemetry.applied_torque
    return Actuation(
        cluster_momentum_B=momentum_B,
        inertia_change_B=change_B,
        applied_torque_B=np.zeros((len(time), 3)) if torque_B is None else _spline(telemetry, torque_B)(time),
    )


def gimbal_motion(telemetry: Telemetry, cluster: Cluster, gimbal_angle: UnitSeries, time: Series) -> GimbalMotion:
    """Return the gimbals' motion at given times, from cubic splines through the samples.

    Args:
        telemetry: the tachometers and the samples' times.
        cluster: the units.
        gimbal_angle: encoders, shape (K, 6), rad.
        time: shape (N,), s.
    """
    angle = _spline(telemetry, np.unwrap(gimbal_angle, axis=0))  # encoders may start over after a turn
    spin = telemetry.rotor_momentum
    nominal = np.broadcast_to(cluster.rotor_momentum, (len(time), len(cluster.rotor_momentum)))
    return GimbalMotion(angle(time), angle(time, 1), nominal if spin is None else _spline(telemetry, spin)(time))


def _momentum_and_change(telemetry: Telemetry, time: Series) -> tuple[Vectors3, Matrices3]:
    if telemetry.cluster is not None and telemetry.gimbal_angle is not None:
        cluster = telemetry.cluster
        motion = gimbal_motion(telemetry, cluster, telemetry.gimbal_angle, time)
        return cluster_momentum(cluster, *motion), inertia_change(cluster, motion.angle)
    momentum_B = telemetry.cluster_momentum
    known_B = np.zeros((len(time), 3)) if momentum_B is None else _spline(telemetry, momentum_B)(time)
    return known_B, np.zeros((len(time), 3, 3))


def _spline(telemetry: Telemetry, samples: Array) -> CubicSpline:
    return CubicSpline(telemetry.actuator_time, samples)
