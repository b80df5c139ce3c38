"""Consider covariance: how far what is not estimated moves the estimate (Schmidt's considered parameters).

An estimator takes the actuators as nominal. If they differ by δp, the platform turns differently,
by G δp with G = ∂ω/∂p; against the motion of the estimator's model, that is an error of the gyro's samples, as a
bias of the gyro is. To first order every estimator answers an error e of the samples with A e, A its influence. So one
matrix G serves all of them: θ̂ moves by A G δp.

Source: S. F. Schmidt, Application of State-Space Methods to Navigation Problems, Advances in Control Systems 3, 1966.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import NamedTuple

import numpy as np

from testbed.arrays import Array, Theta, Vectors3
from testbed.cmg.wheels import wheel_turning_directions
from testbed.estimation.alignment_model import held_momentum_of_unit, sampled_unit
from testbed.estimation.momentum_equation import likely_motion
from testbed.estimation.motion import Drive, Motion
from testbed.estimation.sensitivity import HeldMomentum, held_sensitivity, torque_sensitivity
from testbed.estimation.telemetry import Telemetry, WheelTelemetry, has_gimbals
from testbed.estimation.uncertainty import Uncertainty

_OF_GIMBAL = ("gimbal_misalignment", "gimbal_misalignment", "gimbal_zero", "rotor_momentum")
"""Of each unit, in the order of `alignment_model.KINDS`."""
_OF_WHEEL = ("rotor_momentum", "gimbal_misalignment", "gimbal_misalignment")
"""Of each wheel: the scale of its momentum, and two turns of its axis."""


class ConsideredErrors(NamedTuple):
    """What one standard deviation of each of some quantities puts on the gyro's samples.

    Attributes:
        errors: shape (N, 3, K), rad/s.
        kinds: of the quantities, K fields of `Uncertainty`.
    """

    errors: Array
    kinds: tuple[str, ...]


class ConsideredShifts(NamedTuple):
    """By how much each considered quantity's standard deviation moves each estimate.

    Attributes:
        by_name: of each estimate, shape (6, K), kg·m²; on a pivot three rows more, of the offset of the centre of mass,
            m.
        kinds: of the quantities, K fields of `Uncertainty`.
    """

    by_name: Mapping[str, Array]
    kinds: tuple[str, ...]


def considered_shifts(
    telemetry: Telemetry, theta: Theta, uncertainty: Uncertainty, influences: Mapping[str, Array]
) -> ConsideredShifts:
    """Return by how much each considered quantity's standard deviation moves each estimate.

    Args:
        telemetry: the covered part of one run.
        theta: likely inertia, at which the motion is linearised, kg·m².
        uncertainty: of actuators and gyro.
        influences: ∂θ̂/∂e of each estimate, shape (6 or 9, 3N), by its name; e in the order of the gyro's samples.
    """
    shifts = {name: [np.zeros((len(influence), 0))] for name, influence in influences.items()}
    kinds: list[str] = []
    for errors, of in considered_errors(telemetry, theta, uncertainty):
        columns = errors.reshape(-1, errors.shape[-1])
        kinds += of
        for name, influence in influences.items():
            shifts[name].append(influence @ columns)
    by_name = {name: np.concatenate(parts, axis=1) for name, parts in shifts.items()}
    return ConsideredShifts(by_name=by_name, kinds=tuple(kinds))


def considered_errors(telemetry: Telemetry, theta: Theta, uncertainty: Uncertainty) -> Iterator[ConsideredErrors]:
    """Yield what one standard deviation of each quantity puts on the gyro's samples.

    Args:
        telemetry: the covered part of one run.
        theta: likely inertia, at which the motion is linearised, kg·m².
        uncertainty: of actuators and gyro.
    """
    if uncertainty.nothing:
        return
    drive, motion = likely_motion(telemetry, theta)
    yield from _actuator_errors(telemetry, drive, motion, uncertainty)
    yield from _gyro_errors(motion, uncertainty)


def _actuator_errors(
    telemetry: Telemetry, drive: Drive, motion: Motion, uncertainty: Uncertainty
) -> Iterator[ConsideredErrors]:
    """Yield ∂ω/∂p of the actuators, unit by unit: all units together would fill the memory on a long record."""
    if has_gimbals(telemetry):
        std = _stds(uncertainty, _OF_GIMBAL)
        for unit in range(len(telemetry.gimbals.cluster.rotor_momentum)) if std.any() else ():
            held = held_momentum_of_unit(sampled_unit(telemetry, unit), motion)
            yield ConsideredErrors(held_sensitivity(drive, motion, held) * std, _OF_GIMBAL)
    if telemetry.wheels is not None:
        std = _stds(uncertainty, _OF_WHEEL)
        for wheel in range(len(telemetry.wheels.wheels.spin_inertia)) if std.any() else ():
            held = _held_by_wheel(telemetry, telemetry.wheels, drive, wheel)
            yield ConsideredErrors(held_sensitivity(drive, motion, held) * std, _OF_WHEEL)
    elif not has_gimbals(telemetry) and telemetry.cluster_momentum is not None and uncertainty.rotor_momentum:
        errors = held_sensitivity(drive, motion, _momentum_scale(drive)) * uncertainty.rotor_momentum
        yield ConsideredErrors(errors, 3 * ("rotor_momentum",))
    if telemetry.applied_torque is not None and uncertainty.applied_torque:
        torques_B = _single_torques(telemetry, telemetry.applied_torque, drive)
        errors = torque_sensitivity(drive, motion, torques_B) * uncertainty.applied_torque
        yield ConsideredErrors(errors, errors.shape[-1] * ("applied_torque",))


def _stds(uncertainty: Uncertainty, kinds: tuple[str, ...]) -> Array:
    return np.array([getattr(uncertainty, kind) for kind in kinds])


def _held_by_wheel(telemetry: Telemetry, sent: WheelTelemetry, drive: Drive, wheel: int) -> HeldMomentum:
    """Return ∂h/∂(k, α, β): of the scale k of a wheel's momentum, and of two turns of its axis."""
    along = telemetry.momentum_through(sent.momentum[:, wheel])
    axis_B = sent.wheels.axis_B[wheel]
    directions = np.stack([axis_B, *wheel_turning_directions(axis_B[None])[:, 0]], axis=-1)
    nodes, samples = along(drive.grid_time[::2]), along(drive.time)
    return HeldMomentum(at_nodes=nodes[:, None, None] * directions, at_samples=samples[:, None, None] * directions)


def _momentum_scale(drive: Drive) -> HeldMomentum:
    """Return ∂h/∂k of a scale k of each body axis: what unequal rotors do to a momentum that the platform reports."""
    nodes, samples = drive.grid.cluster_momentum_B[::2], drive.samples.cluster_momentum_B
    return HeldMomentum(at_nodes=nodes[..., None] * np.eye(3), at_samples=samples[..., None] * np.eye(3))


def _single_torques(telemetry: Telemetry, torque_B: Vectors3, drive: Drive) -> Array:
    """Return the torque of each thruster, or about each body axis where none is known, shape (4P+1, 3, K), N·m."""
    if telemetry.thrusters is None or telemetry.thrust is None:
        return telemetry.driven(torque_B, drive.grid_time)[..., None] * np.eye(3)
    thrust = telemetry.driven(telemetry.thrust, drive.grid_time)
    return np.asarray(thrust[:, None, :] * telemetry.thrusters.torque_per_thrust_B.T)


def _gyro_errors(motion: Motion, uncertainty: Uncertainty) -> Iterator[ConsideredErrors]:
    rate = motion.body_rate[..., None]
    if uncertainty.gyro_bias:
        errors = np.broadcast_to(uncertainty.gyro_bias * np.eye(3), (len(rate), 3, 3))
        yield ConsideredErrors(errors, 3 * ("gyro_bias",))
    if uncertainty.gyro_scale:
        yield ConsideredErrors(uncertainty.gyro_scale * rate * np.eye(3), 3 * ("gyro_scale",))
    if uncertainty.gyro_misalignment:
        for turn in (1, 2):  # each axis reads a share of the next one, and of the one after that
            errors = uncertainty.gyro_misalignment * np.roll(rate, -turn, axis=1) * np.eye(3)
            yield ConsideredErrors(errors, 3 * ("gyro_misalignment",))
