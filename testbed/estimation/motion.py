"""The motion that an inertia and an initial momentum predict from the actuators' telemetry.

The state is the platform's total angular momentum L in body axes, because its equation needs no derivative of a
measurement: `dynamics.gyrostat`. With L = J(d) ω + h this is paper eq. (1), the gimbals' own terms included.

Flights side by side, with the same times and in no surroundings, stand on leading axes of all arrays.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TypeAlias

import numpy as np
from scipy.interpolate import CubicHermiteSpline, CubicSpline

from testbed.arrays import Array, Flags, Indices, Matrices3, Series, Theta, Vector3, Vectors3
from testbed.compiled import LONG, compiler_loaded, kept
from testbed.dynamics.environment import gravity_torque
from testbed.dynamics.gyrostat import require_bounded
from testbed.dynamics.inertia import inertia_of, symmetric_inverse
from testbed.estimation.actuation import Actuation, actuation
from testbed.estimation.held import along_steps, step_within
from testbed.estimation.telemetry import Telemetry
from testbed.rotation.kinematics import integrate_attitude
from testbed.rotation.quaternion import matrix_of
from testbed.rotation.vectors import cross

LONGEST_STEP = 0.03125
"""s; the error of the integration is then below 1e-8 rad/s for motions of 1 rad/s (a test says so)."""
_ROUNDING = 1e-9
"""Steps by which a whole number of them may be missed: times are differences of numbers with sixteen digits."""
SMALLEST_SHARE = 0.01
"""Least ratio of principal moments that is simulated; no real body comes near it."""


_Row: TypeAlias = list[float] | Array
_Rows: TypeAlias = list[list[float]] | Array


@dataclass(frozen=True, kw_only=True)
class Pendulum:
    """Gravity on a pivot, where the attitude is no sensor's but follows from the motion.

    Attributes:
        weight: m g, N.
        up_B: u, against gravity, at the first output time, shape (3,), body axes.
        offset_B: c, from the pivot to the centre of mass, shape (3,), m, body axes.
    """

    weight: float
    up_B: Vector3
    offset_B: Vector3


@dataclass(frozen=True, kw_only=True)
class HeldImpulse:
    """What a held torque has given since its first sample: the momentum bends with it, and is smooth without it.

    Attributes:
        at_nodes: at the ends of the integration's steps, shape (2P+1, 3), N·m·s, body axes.
        torque_at_nodes: the mean about them, as the grid has it, shape (2P+1, 3), N·m.
        at_samples: at the output times, shape (N, 3), N·m·s.
    """

    at_nodes: Vectors3
    torque_at_nodes: Vectors3
    at_samples: Vectors3


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
        pendulum: gravity whose torque follows from the motion; the grid's torque is without it.
        held: that part of the grid's torque which is held from sample to sample; None without one.
    """

    time: Series
    samples: Actuation
    grid_time: Series
    grid: Actuation
    torque_basis: Array
    pendulum: Pendulum | None = None
    held: HeldImpulse | None = None


@dataclass(frozen=True, kw_only=True)
class Motion:
    """A predicted motion.

    Attributes:
        body_rate: ω at the output times, shape (N, 3), rad/s, body axes.
        momentum_B: L at the ends of the integration's steps, shape (2P+1, 3), N·m·s.
        inertia_inverse: J(d)⁻¹ at the output times, shape (N, 3, 3), 1/(kg·m²).
        node_inverse: J(d)⁻¹ at the ends of the steps, shape (2P+1, 3, 3).
        node_rate: ω at the ends of the steps, shape (2P+1, 3), rad/s.
        up_B: u of a pendulum at the ends of the steps, shape (2P+1, 3); None without one.
    """

    body_rate: Vectors3
    momentum_B: Vectors3
    inertia_inverse: Matrices3
    node_inverse: Matrices3
    node_rate: Vectors3
    up_B: Vectors3 | None = None


@lru_cache(maxsize=2)  # a run's telemetry, and the one of its true motion that the bound is taken of
def drive_of(telemetry: Telemetry) -> Drive:
    """Return the actuators' part of the motion at the gyro's times and on the integration's grid."""
    start, stop = telemetry.gyro_time[0], telemetry.gyro_time[-1]
    grid_time = np.linspace(start, stop, 4 * _step_pairs(telemetry, stop - start) + 1)
    known, impulse, held = actuation(telemetry, grid_time), telemetry.held_torque, None
    if impulse is not None:
        torque_B = along_steps(impulse, grid_time)
        known = replace(known, applied_torque_B=known.applied_torque_B + torque_B)
        held = HeldImpulse(
            at_nodes=impulse(grid_time[::2]), torque_at_nodes=torque_B[::2], at_samples=impulse(telemetry.gyro_time)
        )
    drive = Drive(
        time=telemetry.gyro_time,
        samples=actuation(telemetry, telemetry.gyro_time),
        grid_time=grid_time,
        grid=known,
        torque_basis=torque_basis(telemetry, grid_time),
        held=held,
    )
    return _as_pendulum(drive, telemetry)


def _step_pairs(telemetry: Telemetry, span: float) -> int:
    """Return P, half the number of steps; where a torque is held, pairs of them end with every sample, at corners."""
    if not telemetry.torque_held:
        return math.ceil(span / (2.0 * LONGEST_STEP))
    step = step_within(float(np.median(np.diff(telemetry.actuator_time))), LONGEST_STEP)
    return math.ceil(span / (2.0 * step) - _ROUNDING)


def _as_pendulum(drive: Drive, telemetry: Telemetry) -> Drive:
    """Leave gravity's torque to the motion, unless a sensor measures the attitude.

    Along the gyro's own integral it would carry that one's error: 1e-3 rad after a minute of a good MEMS gyro are
    2e-5 N·m of a table of 20 kg whose centre of mass is 0.1 mm off, and as much again as the gyro's noise in the rate.
    """
    around, pivot = telemetry.surroundings, telemetry.pivot
    if around is None or pivot is None or around.exact:
        return drive
    torque_B = drive.grid.applied_torque_B - around.gravity(drive.grid_time)
    return replace(
        drive,
        grid=replace(drive.grid, applied_torque_B=torque_B),
        pendulum=Pendulum(weight=pivot.weight, up_B=around.up_B(drive.time[:1])[0], offset_B=pivot.offset_B),
    )


def torque_basis(telemetry: Telemetry, time: Series) -> Array:
    """Return the unit torques of a run's constant torques, shape (..., N, 3, K), body axes; the body's own come first.

    Behind them stand, on a pivot, those of an offset of the centre of mass.

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
    if telemetry.surroundings is not None:
        parts.append(telemetry.surroundings.gravity_basis(time))
    lead = max((part.shape[:-3] for part in parts), key=len)
    return np.concatenate([np.broadcast_to(part, (*lead, *part.shape[-3:])) for part in parts], axis=-1)


def matrix_BN(telemetry: Telemetry, time: Series) -> Matrices3:
    """Return the attitude by the measured rate, shape (..., N, 3, 3), inertial to body axes; N is B at its start."""
    attitude_NB = integrate_attitude(telemetry.gyro_time, telemetry.body_rate, telemetry.corners)
    columns = CubicSpline(telemetry.gyro_time, attitude_NB, axis=-2)(time)
    return np.swapaxes(matrix_of(columns / np.linalg.norm(columns, axis=-1, keepdims=True)), -1, -2)


def drive_of_some(drive: Drive, flights: Indices) -> Drive:
    """Return what acts on some of the flights side by side, in a given order."""

    def some(known: Actuation) -> Actuation:
        return Actuation(
            cluster_momentum_B=_some(known.cluster_momentum_B, flights, axes=2),
            inertia_change_B=_some(known.inertia_change_B, flights, axes=3),
            applied_torque_B=_some(known.applied_torque_B, flights, axes=2),
        )

    basis = _some(drive.torque_basis, flights, axes=3)
    return replace(drive, samples=some(drive.samples), grid=some(drive.grid), torque_basis=basis)


def _some(values: Array, flights: Indices, axes: int) -> Array:
    """Return the values of some flights; what is the same of all has no axis for them."""
    return values[flights] if values.ndim > axes else values


def with_torque(drive: Drive, torque: Array) -> Drive:
    """Return what acts on the platform with constant torques, N·m, and an error of the offset, m, shape (..., K)."""
    if not torque.size:
        return drive
    pendulum = drive.pendulum
    if pendulum is not None:
        moved = replace(drive, pendulum=replace(pendulum, offset_B=pendulum.offset_B + torque[-3:]))
        torque_B = drive.grid.applied_torque_B + drive.torque_basis[..., :-3] @ torque[:-3]
        return replace(moved, grid=replace(drive.grid, applied_torque_B=torque_B))
    torque_B = drive.grid.applied_torque_B + np.matvec(drive.torque_basis, torque[..., None, :])
    return replace(drive, grid=replace(drive.grid, applied_torque_B=torque_B))


def is_physical(theta: Theta) -> Flags:
    """Return whether an inertia resists turning about every axis, shape (...); an estimate from poor data may not."""
    principal = np.linalg.eigvalsh(inertia_of(theta))
    return np.asarray(principal[..., 0] > SMALLEST_SHARE * np.abs(principal[..., 2]))


def simulate(drive: Drive, theta: Theta, initial_momentum_B: Vector3) -> Motion:
    """Return the motion that follows from an inertia and the momentum at the first output time.

    Args:
        drive: what the actuators did.
        theta: inertia parameters, shape (..., 6), kg·m², physical.
        initial_momentum_B: L at the first output time, shape (..., 3), N·m·s, body axes.

    Raises:
        InputError: the motion leaves the finite numbers, as it does where channels or units do not belong together.
    """
    grid, samples = drive.grid, drive.samples
    inverse = _inverse(theta, grid)
    with np.errstate(over="ignore", invalid="ignore"):
        momentum_B, up_B = _integrated(drive, inverse, initial_momentum_B)
    require_bounded(momentum_B)
    node_inverse = inverse[..., ::2, :, :]
    node_rate = np.matvec(node_inverse, momentum_B - grid.cluster_momentum_B[..., ::2, :])
    slope = grid.applied_torque_B[..., ::2, :] + cross(momentum_B, node_rate)
    if drive.pendulum is not None and up_B is not None:
        slope = slope + gravity_torque(drive.pendulum.weight, up_B, drive.pendulum.offset_B)
    at_samples = _at_samples(drive, momentum_B, slope)
    sample_inverse = _inverse(theta, samples)
    return Motion(
        body_rate=np.matvec(sample_inverse, at_samples - samples.cluster_momentum_B),
        momentum_B=momentum_B,
        inertia_inverse=sample_inverse,
        node_inverse=node_inverse,
        node_rate=node_rate,
        up_B=up_B,
    )


def _at_samples(drive: Drive, momentum_B: Vectors3, slope: Vectors3) -> Vectors3:
    """Return L at the output times, shape (..., N, 3), joined between the steps' ends where it does not bend."""
    nodes, held = drive.grid_time[::2], drive.held
    if held is None:
        return np.ascontiguousarray(CubicHermiteSpline(nodes, momentum_B, slope, axis=-2)(drive.time))
    smooth = CubicHermiteSpline(nodes, momentum_B - held.at_nodes, slope - held.torque_at_nodes, axis=-2)
    return np.ascontiguousarray(smooth(drive.time)) + held.at_samples


def _inverse(theta: Theta, known: Actuation) -> Matrices3:
    return symmetric_inverse(inertia_of(theta)[..., None, :, :] + known.inertia_change_B)


def _integrated(drive: Drive, inverse: Matrices3, initial_momentum_B: Vector3) -> tuple[Vectors3, Vectors3 | None]:
    """Return L at the ends of the steps, and u of a pendulum."""
    if drive.pendulum is None:
        return _runge_kutta(drive, inverse, initial_momentum_B), None
    states = _swing(drive, drive.pendulum, inverse, initial_momentum_B)
    return states[:, :3], states[:, 3:]


def _swing(drive: Drive, pendulum: Pendulum, inverse: Matrices3, initial_momentum_B: Vector3) -> Array:
    """Integrate L̇ = τ + L × ω + m g u × c and u̇ = u × ω as `_runge_kutta` does, shape (2P+1, 6)."""
    step = float(drive.grid_time[2] - drive.grid_time[0])
    free_rate = np.matvec(inverse, drive.grid.cluster_momentum_B)
    inputs = np.concatenate([inverse.reshape(-1, 9), free_rate, drive.grid.applied_torque_B], axis=1)
    history = np.zeros((len(inputs) // 2 + 1, 6))
    history[0] = [*initial_momentum_B, *pendulum.up_B]
    constants = np.array([step, *pendulum.weight * pendulum.offset_B])
    _fill(_march_pendulum, inputs, constants, history)
    return history


def _march_pendulum(inputs: _Rows, constants: _Row, history: _Rows) -> None:
    """Fill in a history of (L, u) from its first row on; a step begins at every other row of the inputs."""
    step, moment, slope = constants[0], constants[1:], _pendulum_slope
    half = step / 2
    for index in range(len(history) - 1):
        start, middle, end = inputs[2 * index], inputs[2 * index + 1], inputs[2 * index + 2]
        at, after = history[index], history[index + 1]
        x, y, z, p, q, r = at[0], at[1], at[2], at[3], at[4], at[5]
        a = slope(x, y, z, p, q, r, start, moment)
        b = slope(
            x + half * a[0], y + half * a[1], z + half * a[2], p + half * a[3], q + half * a[4], r + half * a[5],
            middle, moment,
        )  # fmt: skip
        c = slope(
            x + half * b[0], y + half * b[1], z + half * b[2], p + half * b[3], q + half * b[4], r + half * b[5],
            middle, moment,
        )  # fmt: skip
        d = slope(
            x + step * c[0], y + step * c[1], z + step * c[2], p + step * c[3], q + step * c[4], r + step * c[5],
            end, moment,
        )  # fmt: skip
        for part in range(6):
            after[part] = at[part] + step / 6 * (a[part] + 2 * b[part] + 2 * c[part] + d[part])


def _pendulum_slope(
    x: float, y: float, z: float, p: float, q: float, r: float, of: _Row, moment: _Row
) -> tuple[float, ...]:
    """Return the rates of L = (x, y, z) and u = (p, q, r), of a row of J⁻¹, J⁻¹ h and τ, and of m g c."""
    rate_x = of[0] * x + of[1] * y + of[2] * z - of[9]
    rate_y = of[3] * x + of[4] * y + of[5] * z - of[10]
    rate_z = of[6] * x + of[7] * y + of[8] * z - of[11]
    return (
        of[12] + y * rate_z - z * rate_y + q * moment[2] - r * moment[1],
        of[13] + z * rate_x - x * rate_z + r * moment[0] - p * moment[2],
        of[14] + x * rate_y - y * rate_x + p * moment[1] - q * moment[0],
        q * rate_z - r * rate_y,
        r * rate_x - p * rate_z,
        p * rate_y - q * rate_x,
    )


def _runge_kutta(drive: Drive, inverse: Matrices3, initial_momentum_B: Vector3) -> Vectors3:
    """Integrate L̇ = τ + L × (J⁻¹ L - J⁻¹ h) with the classical fourth-order rule.

    On plain numbers: NumPy's overhead on single vectors would be four fifths of the time.
    """
    step = float(drive.grid_time[2] - drive.grid_time[0])
    acting = (drive.grid.cluster_momentum_B, drive.grid.applied_torque_B)  # wheels do not change J: it has no flights
    lead = np.broadcast_shapes(inverse.shape[:-3], initial_momentum_B.shape[:-1], *(each.shape[:-2] for each in acting))
    instants = len(drive.grid_time)
    inputs = np.empty((*lead, instants, 15))
    inputs[..., :9] = inverse.reshape(*inverse.shape[:-2], 9)
    inputs[..., 9:12] = np.matvec(inverse, drive.grid.cluster_momentum_B)
    inputs[..., 12:] = drive.grid.applied_torque_B
    history = np.zeros((*lead, instants // 2 + 1, 3))
    history[..., 0, :] = initial_momentum_B
    for own, motion in zip(inputs.reshape(-1, instants, 15), history.reshape(-1, instants // 2 + 1, 3), strict=True):
        _fill(_march, own, np.array([step]), motion)
    return history


def _fill(march: Callable[[_Rows, _Row, _Rows], None], inputs: Array, constants: Array, history: Array) -> None:
    """Let a march fill in a history from its first row on: as machine code, of the same bits, where that is quicker."""
    if len(history) > LONG or compiler_loaded():
        kept(march, (("f8", 2), ("f8", 1), ("f8", 2)))(inputs, constants, history)
        return
    rows = history.tolist()
    march(inputs.tolist(), constants.tolist(), rows)
    history[:] = rows


def _march(inputs: _Rows, steps: _Row, history: _Rows) -> None:
    """Fill in a history of L from its first row on; a step, all alike, begins at every other row of the inputs."""
    step, slope = steps[0], _slope
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
