"""What the actuators did, at any time: their momentum, the inertia they shift, and the torque applied."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from testbed.arrays import Array, Matrices3, Series, Vectors3
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


def _momentum_and_change(telemetry: Telemetry, time: Series) -> tuple[Vectors3, Matrices3]:
    if telemetry.cluster is not None and telemetry.gimbal_angle is not None:
        continuous = np.unwrap(telemetry.gimbal_angle, axis=0)  # encoders may start over after a turn
        return _from_gimbals(telemetry, telemetry.cluster, _spline(telemetry, continuous), time)
    momentum_B = telemetry.cluster_momentum
    known_B = np.zeros((len(time), 3)) if momentum_B is None else _spline(telemetry, momentum_B)(time)
    return known_B, np.zeros((len(time), 3, 3))


def _from_gimbals(
    telemetry: Telemetry, cluster: Cluster, angle: CubicSpline, time: Series
) -> tuple[Vectors3, Matrices3]:
    spin = telemetry.rotor_momentum
    rotor_momentum = None if spin is None else _spline(telemetry, spin)(time)
    gimbal_angle = angle(time)
    momentum_B = cluster_momentum(cluster, gimbal_angle, angle(time, 1), rotor_momentum)
    return momentum_B, inertia_change(cluster, gimbal_angle)


def _spline(telemetry: Telemetry, samples: Array) -> CubicSpline:
    return CubicSpline(telemetry.actuator_time, samples)
