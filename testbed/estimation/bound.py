"""The Cramér-Rao bound of a motion as flown: what no unbiased estimator can undercut."""

from __future__ import annotations

import numpy as np

from testbed.arrays import Array, Covariance, Regressor, Theta, Vector3
from testbed.estimation.identifiability import inertia_size, require_identifiable, without_momentum
from testbed.estimation.motion import Drive, Motion, drive_of, simulate, with_torque
from testbed.estimation.regression import rows_of
from testbed.estimation.sensitivity import acting_basis, rate_sensitivity, torque_sensitivity
from testbed.estimation.stated_noise import whitened
from testbed.estimation.telemetry import Telemetry, covered_part


def cramer_rao_bound(
    telemetry: Telemetry, theta: Theta, initial_momentum_B: Vector3, acting: Array | None = None
) -> Covariance:
    """Return the smallest covariance of θ that gyro noise allows, shape (..., 6, 6), kg²·m⁴.

    On a pivot three rows and columns more are of the offset of the centre of mass, m, which is estimated with it.

    The gyro's noise is white, eq. (4), or is made so where its bias is stated to wander, and enters the rates alone, so
    that the Fisher information is SᵀS/σ² with the sensitivities S of the rates; an unknown initial momentum costs what
    its columns explain of the inertia's.

    Args:
        telemetry: the gyro's times and noise, the actuators' motion (its measured rates are not used), and whether
            the initial momentum is known to be zero.
        theta: true inertia parameters, shape (..., 6), kg·m².
        initial_momentum_B: true momentum of the whole platform at the first sample, shape (..., 3), N·m·s, body axes.
        acting: true torques and offset's error, as `Telemetry.torque_of`; none where None.

    Raises:
        InputError: too few samples.
        UnidentifiableError: the motion leaves directions of the inertia open.

    Source: paper eqs. (9), (12), (13).
    """
    part = covered_part(telemetry)
    drive = drive_of(part) if acting is None else with_torque(drive_of(part), acting)
    motion = simulate(drive, theta, initial_momentum_B)
    columns = rate_columns(part, drive, motion)
    require_identifiable(columns, 0.0, inertia_size(theta), motion.body_rate)
    wanted = 6 if part.pivot is None else 9
    columns = whitened(part, columns)
    turned = np.roll(columns[..., 6:], wanted - 6, axis=-1)
    columns = without_momentum(np.concatenate([columns[..., :6], turned], axis=-1), wanted)
    return np.asarray(part.gyro_noise**2 * np.linalg.inv(columns.mT @ columns))  # eqs. (12), (13)


def rate_columns(telemetry: Telemetry, drive: Drive, motion: Motion) -> Regressor:
    """Return ∂ω/∂(unknowns), shape (..., 3N, P): of the inertia, then of the momentum and the torques where unknown."""
    known = rate_sensitivity(drive, motion)[..., : 6 + telemetry.momentum_unknowns]
    if not telemetry.torque_unknowns:
        return rows_of(known)
    return rows_of(np.concatenate([known, torque_sensitivity(drive, motion, acting_basis(drive, motion))], axis=-1))
