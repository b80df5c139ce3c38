"""The motion that an inertia and an initial momentum predict from the actuators' telemetry.

The state is the platform's whole momentum L in body axes, because its equation needs no derivative of a measurement:
L̇ = τ - ω × L, with ω = J(d)⁻¹ (L - h). With L = J(d) ω + h this is paper eq. (1), the gimbals' own terms included.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from testbed.arrays import Matrices3, Series, Theta, Vector3, Vectors3
from testbed.dynamics.inertia import inertia_of
from testbed.errors import InputError
from testbed.estimation.actuation import Actuation, actuation
from testbed.estimation.telemetry import Telemetry

LONGEST_STEP = 0.03125
"""s; the error of the integration is then below 1e-8 rad/s for motions of 1 rad/s (a test says so)."""
SMALLEST_SHARE = 0.01
"""Least ratio of principal moments that is simulated; no real body comes near it."""
_WILDEST_MOMENTUM = 1e6
"""N·m·s; beyond it no platform of this kind turns, and squares of it are still far from overflow."""
RUNAWAY = (
    "the motion that these actuator channels predict runs away: check their units and signs, and that the scenario is "
    "of this platform"
)


@dataclass(frozen=True, kw_only=True)
class Drive:
    """What the actuators impose on a motion, sampled once for all evaluations.

    Attributes:
        time: output times, shape (N,), s.
        samples: the actuators at the output times.
        grid_time: times of the integration, every half step, shape (4P+1,), s.
        grid: the actuators at these times.
    """

    time: Series
    samples: Actuation
    grid_time: Series
    grid: Actuation


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
    )


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
    if not np.abs(momentum_B).max() < _WILDEST_MOMENTUM:  # also true for NaN
        raise InputError(RUNAWAY)
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
    return np.asarray(np.linalg.inv(inertia_of(theta) + known.inertia_change_B), dtype=np.float64)


def _runge_kutta(drive: Drive, inverse: Matrices3, initial_momentum_B: Vector3) -> Vectors3:
    """Integrate L̇ = τ + L × (J⁻¹ L - J⁻¹ h) with the classical fourth-order rule.

    On plain numbers: NumPy's overhead on single vectors would be four fifths of the time.
    """
    step = float(drive.grid_time[2] - drive.grid_time[0])
    half = step / 2
    free_rate = np.matvec(inverse, drive.grid.cluster_momentum_B)
    inputs = np.concatenate([inverse.reshape(-1, 9), free_rate, drive.grid.applied_torque_B], axis=1).tolist()
    x, y, z = np.asarray(initial_momentum_B, dtype=np.float64).tolist()
    history = [(x, y, z)]
    for index in range(0, len(inputs) - 1, 2):
        start, middle, end = inputs[index : index + 3]
        a, b, c = _slope(x, y, z, start)
        d, e, f = _slope(x + half * a, y + half * b, z + half * c, middle)
        g, h, i = _slope(x + half * d, y + half * e, z + half * f, middle)
        j, k, m = _slope(x + step * g, y + step * h, z + step * i, end)
        x += step / 6 * (a + 2 * d + 2 * g + j)
        y += step / 6 * (b + 2 * e + 2 * h + k)
        z += step / 6 * (c + 2 * f + 2 * i + m)
        history.append((x, y, z))
    return np.array(history)


def _slope(x: float, y: float, z: float, inputs: list[float]) -> tuple[float, float, float]:
    """Return τ + L × ω with ω = J⁻¹ L - J⁻¹ h, of L = (x, y, z)."""
    xx, xy, xz, yx, yy, yz, zx, zy, zz, free_x, free_y, free_z, torque_x, torque_y, torque_z = inputs
    rate_x = xx * x + xy * y + xz * z - free_x
    rate_y = yx * x + yy * y + yz * z - free_y
    rate_z = zx * x + zy * y + zz * z - free_z
    return torque_x + y * rate_z - z * rate_y, torque_y + z * rate_x - x * rate_z, torque_z + x * rate_y - y * rate_x
