"""The motion that an inertia and an initial momentum predict from the actuators' telemetry.

The state is the platform's total angular momentum L in body axes, because its equation needs no derivative of a
measurement: `dynamics.gyrostat`. With L = J(d) ω + h this is paper eq. (1), the gimbals' own terms included.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TypeAlias

import numpy as np
from scipy.interpolate import CubicHermiteSpline, CubicSpline

from testbed.arrays import Array, Matrices3, Series, Theta, Vector3, Vectors3
from testbed.compiled import LONG, compiled
from testbed.dynamics.gyrostat import require_bounded
from testbed.dynamics.inertia import inertia_of, symmetric_inverse
from testbed.estimation.actuation import Actuation, actuation
from testbed.estimation.telemetry import Telemetry
from testbed.rotation.kinematics import integrate_attitude
from testbed.rotation.quaternion import matrix_of

LONGEST_STEP = 0.03125
"""s; the error of the integration is then below 1e-8 rad/s for motions of 1 rad/s (a test says so)."""
SMALLEST_SHARE = 0.01
"""Least ratio of principal moments that is simulated; no real body comes near it."""


@dataclass(frozen=True, kw_only=True)
class Drive:
    """What the actuators impose on a motion, sampled once for all evaluations.

    Attributes:
        time: output times, shape (N,), s.
        samples: the actuators at the output times.
        grid_time: times of the integration, every half step, shape (4P+1,), s.
        grid: the actuators at these times.
        torque_basis: of the constant torques that are estimated jointly, at the times of the integration, shape
            (4P+1, 3, K): a torque per unit of each unknown, body axes.
    """

    time: Series
    samples: Actuation
    grid_time: Series
    grid: Actuation
    torque_basis: Array


@dataclass(frozen=True, kw_only=True)
class Motion:
    """A predicted motion.

    Attributes:
        body_rate: ω at the output times, shape (N, 3), rad/s, body axes.
        momentum_B: L at the ends of the integration's steps, shape (2P+1, 3), N·m·s.
        inertia_inverse: J(d)⁻¹ at the output times, shape (N, 3, 3), 1/(kg·m²).
        node_inverse: J(d)⁻¹ at the ends of the steps, shape (2P+1, 3, 3).
        node_rate: ω at the ends of the steps, shape (2P+1, 3), rad/s.
    """

    body_rate: Vectors3
    momentum_B: Vectors3
    inertia_inverse: Matrices3
    node_inverse: Matrices3
    node_rate: Vectors3


@lru_cache(maxsize=2)  # a run's telemetry, and the one of its true motion that the bound is taken of
def drive_of(telemetry: Telemetry) -> Drive:
    """Return the actuators' part of the motion at the gyro's times and on the integration's grid."""
    start, stop = telemetry.gyro_time[0], telemetry.gyro_time[-1]
    step_pairs = int(np.ceil((stop - start) / (2.0 * LONGEST_STEP)))
    grid_time = np.linspace(start, stop, 4 * step_pairs + 1)
    return Drive(
        time=telemetry.gyro_time,
        samples=actuation(telemetry, telemetry.gyro_time),
        grid_time=grid_time,
        grid=actuation(telemetry, grid_time),
        torque_basis=torque_basis(telemetry, grid_time),
    )


def torque_basis(telemetry: Telemetry, time: Series) -> Array:
    """Return the unit torques of a run's constant torques, shape (N, 3, K), body axes; the body's own come first.

    The attitude is the integral of the measured rate: its error, 0.014 rad after 5 s of the paper's noise, matters
    little to a torque that is itself a small correction.

    Args:
        telemetry: states which torques are estimated.
        time: shape (N,), s.
    """
    fixed = np.broadcast_to(np.eye(3), (len(time), 3, 3))
    parts = [fixed[..., :0]]
    if telemetry.constant_torque in {"body", "both"}:
        parts.append(fixed)
    if telemetry.constant_torque in {"inertial", "both"}:
        parts.append(matrix_BN(telemetry, time))
    return np.concatenate(parts, axis=2)


def matrix_BN(telemetry: Telemetry, time: Series) -> Matrices3:
    """Return the attitude by the measured rate, shape (N, 3, 3), inertial to body axes; N is B at the first sample."""
    attitude_NB = integrate_attitude(telemetry.gyro_time, telemetry.body_rate)
    columns = CubicSpline(telemetry.gyro_time, attitude_NB)(time)
    return np.swapaxes(matrix_of(columns / np.linalg.norm(columns, axis=1, keepdims=True)), 1, 2)


def with_torque(drive: Drive, torque: Array) -> Drive:
    """Return what acts on the platform with constant torques of the given sizes, shape (K,), N·m."""
    if not torque.size:
        return drive
    torque_B = drive.grid.applied_torque_B + drive.torque_basis @ torque
    return replace(drive, grid=replace(drive.grid, applied_torque_B=torque_B))


def is_physical(theta: Theta) -> bool:
    """Return whether an inertia resists turning about every axis; an estimate from poor data may not."""
    principal = np.linalg.eigvalsh(inertia_of(theta))
    return bool(principal[0] > SMALLEST_SHARE * abs(principal[2]))


def simulate(drive: Drive, theta: Theta, initial_momentum_B: Vector3) -> Motion:
    """Return the motion that follows from an inertia and the momentum at the first output time.

    Args:
        drive: what the actuators did.
        theta: inertia parameters, kg·m², physical.
        initial_momentum_B: L at the first output time, N·m·s, body axes.

    Raises:
        InputError: the motion leaves the finite numbers, as it does where channels or units do not belong together.
    """
    grid, samples = drive.grid, drive.samples
    inverse = _inverse(theta, grid)
    with np.errstate(over="ignore", invalid="ignore"):
        momentum_B = _runge_kutta(drive, inverse, initial_momentum_B)
    require_bounded(momentum_B)
    node_rate = np.matvec(inverse[::2], momentum_B - grid.cluster_momentum_B[::2])
    slope = grid.applied_torque_B[::2] + np.cross(momentum_B, node_rate)
    at_samples = CubicHermiteSpline(drive.grid_time[::2], momentum_B, slope)(drive.time)
    sample_inverse = _inverse(theta, samples)
    return Motion(
        body_rate=np.matvec(sample_inverse, at_samples - samples.cluster_momentum_B),
        momentum_B=momentum_B,
        inertia_inverse=sample_inverse,
        node_inverse=inverse[::2],
        node_rate=node_rate,
    )


def _inverse(theta: Theta, known: Actuation) -> Matrices3:
    return symmetric_inverse(inertia_of(theta) + known.inertia_change_B)


def _runge_kutta(drive: Drive, inverse: Matrices3, initial_momentum_B: Vector3) -> Vectors3:
    """Integrate L̇ = τ + L × (J⁻¹ L - J⁻¹ h) with the classical fourth-order rule.

    On plain numbers: NumPy's overhead on single vectors would be four fifths of the time.
    """
    step = float(drive.grid_time[2] - drive.grid_time[0])
    free_rate = np.matvec(inverse, drive.grid.cluster_momentum_B)
    inputs = np.concatenate([inverse.reshape(-1, 9), free_rate, drive.grid.applied_torque_B], axis=1)
    history = np.zeros((len(inputs) // 2 + 1, 3))
    history[0] = initial_momentum_B
    if len(history) > LONG:
        compiled(_march)(compiled(_slope), inputs, history, step)
        return history
    rows = history.tolist()
    _march(_slope, inputs.tolist(), rows, step)
    return np.array(rows)


_Row: TypeAlias = list[float] | Array
_Rows: TypeAlias = list[list[float]] | Array


def _march(slope: Callable[..., tuple[float, float, float]], inputs: _Rows, history: _Rows, step: float) -> None:
    """Fill in a history of L from its first row on; a step begins at every other row of the inputs."""
    half = step / 2
    first = history[0]
    x, y, z = first[0], first[1], first[2]
    for index in range(len(history) - 1):
        start, middle, end = inputs[2 * index], inputs[2 * index + 1], inputs[2 * index + 2]
        a, b, c = slope(x, y, z, start)
        d, e, f = slope(x + half * a, y + half * b, z + half * c, middle)
        g, h, i = slope(x + half * d, y + half * e, z + half * f, middle)
        j, k, m = slope(x + step * g, y + step * h, z + step * i, end)
        x += step / 6 * (a + 2 * d + 2 * g + j)
        y += step / 6 * (b + 2 * e + 2 * h + k)
        z += step / 6 * (c + 2 * f + 2 * i + m)
        after = history[index + 1]
        after[0], after[1], after[2] = x, y, z


def _slope(x: float, y: float, z: float, of: _Row) -> tuple[float, float, float]:
    """Return τ + L × ω with ω = J⁻¹ L - J⁻¹ h, of L = (x, y, z) and a row of J⁻¹, J⁻¹ h and τ."""
    rate_x = of[0] * x + of[1] * y + of[2] * z - of[9]
    rate_y = of[3] * x + of[4] * y + of[5] * z - of[10]
    rate_z = of[6] * x + of[7] * y + of[8] * z - of[11]
    return of[12] + y * rate_z - z * rate_y, of[13] + z * rate_x - x * rate_z, of[14] + x * rate_y - y * rate_x
