"""Conservation of momentum at the samples alone: Γ(ω) θ - Rᵀ H₀ = -h - (J(d) - J(0)) ω + Rᵀ ∫ R τ dt."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.interpolate import CubicSpline

from testbed.arrays import Array, Matrices3, Quaternions, Series, Theta, Vector3, Vectors3
from testbed.dynamics.inertia import momentum_regressor
from testbed.estimation.identifiability import explaining
from testbed.estimation.motion import Drive, Motion, drive_of, simulate, torque_basis, with_torque
from testbed.estimation.regression import rows_of
from testbed.estimation.telemetry import Telemetry
from testbed.rotation.kinematics import integrate_attitude
from testbed.rotation.quaternion import matrix_of


@dataclass(frozen=True, kw_only=True)
class MomentumEquation:
    """The equation Ψ (θ, H₀, c) = Y at the gyro's times.

    Attributes:
        regressor: Ψ = [Γ(ω), -Rᵀ, -Rᵀ ∫ R b dt], shape (..., N, 3, 9 + K), b the directions of the constant torques c.
        response: Y, shape (..., N, 3), N·m·s.
        matrix_NB: R, shape (..., N, 3, 3); N is the body frame at the first sample.
    """

    regressor: Array
    response: Vectors3
    matrix_NB: Matrices3


@lru_cache(maxsize=2)  # several steps of several estimators ask for a run's own in turn
def measured_equation(telemetry: Telemetry) -> MomentumEquation:
    """Return Ψ and Y of the measured body rate, as `momentum_equation`."""
    return momentum_equation(telemetry, telemetry.body_rate)


def momentum_equation(telemetry: Telemetry, body_rate: Vectors3) -> MomentumEquation:
    """Return Ψ and Y of a body rate, measured or of an instrument; the attitude is the rate's own integral.

    Args:
        telemetry: the actuators' part and the times.
        body_rate: ω at the gyro's times, shape (..., N, 3), rad/s.
    """
    known = drive_of(telemetry).samples
    attitude_NB = integrate_attitude(telemetry.gyro_time, body_rate, telemetry.corners)
    matrix_NB = matrix_of(attitude_NB)
    to_body, impulse_B = np.swapaxes(matrix_NB, -1, -2), np.zeros(3)
    if known.applied_torque_B.any():
        torque_N = np.matvec(matrix_NB, known.applied_torque_B)
        impulse_B = np.matvec(to_body, _impulse(telemetry.gyro_time, torque_N, axis=-2))
    held = telemetry.held_torque
    if held is not None:
        impulse_N = _held_impulse_N(held(telemetry.gyro_time), attitude_NB, matrix_NB)
        impulse_B = impulse_B + np.matvec(to_body, impulse_N)
    shifted = np.matvec(known.inertia_change_B, body_rate)
    columns = [momentum_regressor(body_rate), -to_body]
    if telemetry.torque_unknowns:
        turned = matrix_NB @ torque_basis(telemetry, telemetry.gyro_time)
        columns.append(-to_body @ _impulse(telemetry.gyro_time, turned, axis=-3))
    return MomentumEquation(
        regressor=np.concatenate(columns, axis=-1),
        response=impulse_B - known.cluster_momentum_B - shifted,
        matrix_NB=matrix_NB,
    )


def _held_impulse_N(impulse_B: Vectors3, attitude_NB: Quaternions, matrix_NB: Matrices3) -> Vectors3:
    """Return the impulse of a held torque in axes N, shape (..., N, 3): of each interval at its mean attitude."""
    half_way = attitude_NB[..., :-1, :] + attitude_NB[..., 1:, :]
    middle_NB = matrix_of(half_way / np.linalg.norm(half_way, axis=-1, keepdims=True))
    mean_NB = (matrix_NB[..., :-1, :, :] + 4.0 * middle_NB + matrix_NB[..., 1:, :, :]) / 6.0
    share_N = np.matvec(mean_NB, np.diff(impulse_B, axis=-2))
    return np.concatenate([np.zeros_like(share_N[..., :1, :]), np.cumsum(share_N, axis=-2)], axis=-2)


def unknown_columns(telemetry: Telemetry, regressor: Array) -> Array:
    """Return Ψ without the initial momentum's columns where that is known, shape (..., N, 3, P)."""
    return regressor if telemetry.momentum_unknowns else np.delete(regressor, slice(6, 9), axis=-1)


def mean_momentum(telemetry: Telemetry, theta: Theta) -> Vector3:
    """Return H₀ that fits an inertia and the measured rates best, shape (..., 3), N·m·s; zero where the run says so."""
    if telemetry.initial_momentum == "zero":
        return np.zeros(3)
    if telemetry.torque_unknowns:
        return _momentum_and_torque(telemetry, theta)[..., :3]
    momentum_B, equation = _turning_momentum(telemetry, theta), measured_equation(telemetry)
    return np.asarray(np.matvec(equation.matrix_NB, momentum_B).mean(axis=-2))


def likely_motion(telemetry: Telemetry, theta: Theta) -> tuple[Drive, Motion]:
    """Return the motion of an inertia with the momentum, and on a pivot the offset, that fit the measured rates best.

    A believed offset may be wrong by so much that the motion would be another one; other torques are corrections.

    Args:
        telemetry: one run.
        theta: kg·m².

    Returns:
        What acts, and the motion.
    """
    drive, momentum_B = drive_of(telemetry), mean_momentum(telemetry, theta)
    if telemetry.pivot is not None:
        acting = np.zeros(telemetry.torque_unknowns)
        acting[-3:] = _momentum_and_torque(telemetry, theta)[-3:]
        drive = with_torque(drive, acting)
    return drive, simulate(drive, theta, momentum_B)


def _momentum_and_torque(telemetry: Telemetry, theta: Theta) -> Array:
    """Return the unknown momentum and torques that fit an inertia and the measured rates best, shape (..., P - 6)."""
    others = rows_of(unknown_columns(telemetry, measured_equation(telemetry).regressor)[..., 6:])
    momentum_B = _turning_momentum(telemetry, theta)
    return explaining(-others, momentum_B.reshape(*momentum_B.shape[:-2], -1, 1))[..., 0]


def _turning_momentum(telemetry: Telemetry, theta: Theta) -> Vectors3:
    """Return Γ(ω) θ - Y, the momentum that is left to the other unknowns, shape (..., N, 3), N·m·s."""
    equation = measured_equation(telemetry)
    return np.asarray(np.matvec(equation.regressor[..., :6], theta[..., None, :]) - equation.response)


def _impulse(time: Series, torque_N: Array, axis: int) -> Array:
    """Return ∫ R τ dt from the first sample, of the shape of the torque with its samples on an axis, N·m·s."""
    return np.ascontiguousarray(CubicSpline(time, torque_N, axis=axis).antiderivative()(time))
