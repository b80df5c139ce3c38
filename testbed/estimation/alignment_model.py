"""What the actuators hold as a function of their alignments: axes, encoder zeros and rotor momenta off nominal."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from testbed.arrays import Array, Axes, Flags, Series, Units, UnitSeries, Vectors3
from testbed.cmg.cluster import Cluster, cluster_momentum, inertia_change, spin_axes, transverse_axes
from testbed.cmg.misalignment import misaligned, turning_axes
from testbed.errors import InputError
from testbed.estimation.actuation import Actuation, GimbalMotion, gimbal_motion
from testbed.estimation.motion import Drive, Motion, drive_of
from testbed.estimation.sensitivity import HeldMomentum
from testbed.estimation.telemetry import GimbalRun, Telemetry, has_gimbals

KINDS = ("axis about s", "axis about t", "encoder zero", "momentum scale")
"""What is aligned of each unit, in the order of the parameters."""


@dataclass(frozen=True, kw_only=True)
class Alignment:
    """How the units differ from nominal.

    Attributes:
        misalignment: turns of the gimbal axis about s0 and t, shape (M, 2), rad, as in `testbed.cmg.misalignment`.
        encoder_zero: what the encoders read at gimbal angle zero, shape (M,), rad.
        momentum_scale: k, shape (M,): a rotor carries (1 + k) times Js·Ω of its tachometer.
    """

    misalignment: Array
    encoder_zero: Units
    momentum_scale: Units

    @property
    def parameters(self) -> Array:
        """All of them in the order of `KINDS`, all units of a kind together, shape (4 M,)."""
        return np.concatenate([*self.misalignment.T, self.encoder_zero, self.momentum_scale])


@dataclass(frozen=True, kw_only=True)
class SampledGimbals:
    """The gimbals' motion as sent, sampled once for all evaluations.

    Attributes:
        cluster: nominal.
        nominal: what the actuators did if all is aligned.
        samples: the gimbals at the output times.
        grid: the gimbals at the times of the integration.
    """

    cluster: Cluster
    nominal: Drive
    samples: GimbalMotion
    grid: GimbalMotion


def alignment_of(parameters: Array) -> Alignment:
    """Return the alignment of parameters in the order of `KINDS`, shape (4 M,)."""
    about_spin, about_transverse, zero, scale = parameters.reshape(len(KINDS), -1)
    return Alignment(
        misalignment=np.stack([about_spin, about_transverse], axis=1), encoder_zero=zero, momentum_scale=scale
    )


def sampled_gimbals(telemetry: Telemetry) -> SampledGimbals:
    """Sample a run's gimbals.

    Raises:
        InputError: the run has no encoders.
    """
    if not has_gimbals(telemetry):
        raise InputError("alignments cannot be estimated without gimbal angles: send the encoders' channels")
    nominal = drive_of(telemetry)
    return SampledGimbals(
        cluster=telemetry.gimbals.cluster,
        nominal=nominal,
        samples=gimbal_motion(telemetry, nominal.time),
        grid=gimbal_motion(telemetry, nominal.grid_time),
    )


def drive_at(record: SampledGimbals, alignment: Alignment) -> Drive:
    """Return what the actuators did if their alignment is as given."""
    cluster = misaligned(record.cluster, alignment.misalignment)

    def known(motion: GimbalMotion, nominal: Actuation) -> Actuation:
        angle, rate, momentum = _corrected(motion, alignment)
        return replace(
            nominal,
            cluster_momentum_B=cluster_momentum(cluster, angle, rate, momentum),
            inertia_change_B=inertia_change(cluster, angle),
        )

    drive = record.nominal
    return replace(drive, samples=known(record.samples, drive.samples), grid=known(record.grid, drive.grid))


def held_momentum(record: SampledGimbals, alignment: Alignment, motion: Motion) -> HeldMomentum:
    """Return what the momentum that the actuators hold owes to each alignment parameter, at a motion's rates."""
    nodes = GimbalMotion(*(channel[::2] for channel in record.grid))
    return HeldMomentum(
        at_nodes=_held(record.cluster, alignment, nodes, motion.node_rate),
        at_samples=_held(record.cluster, alignment, record.samples, motion.body_rate),
    )


class SampledUnit(NamedTuple):
    """One nominal unit, and its gimbal's motion at the output times and at the ends of the integration's steps."""

    cluster: Cluster
    samples: GimbalMotion
    nodes: GimbalMotion


def sampled_unit(run: GimbalRun, unit: int) -> SampledUnit:
    """Sample one unit's gimbal.

    Args:
        run: with encoders.
        unit: index of the unit.
    """
    drive, own = drive_of(run), replace(run, gimbals=run.gimbals.unit(unit))
    return SampledUnit(
        cluster=own.gimbals.cluster,
        samples=gimbal_motion(own, drive.time),
        nodes=gimbal_motion(own, drive.grid_time[::2]),
    )


def held_momentum_of_unit(unit: SampledUnit, motion: Motion) -> HeldMomentum:
    """Return what the momentum that a unit holds owes to each of its four alignments, in the order of `KINDS`."""
    aligned = Alignment(misalignment=np.zeros((1, 2)), encoder_zero=np.zeros(1), momentum_scale=np.zeros(1))
    return HeldMomentum(
        at_nodes=_held(unit.cluster, aligned, unit.nodes, motion.node_rate),
        at_samples=_held(unit.cluster, aligned, unit.samples, motion.body_rate),
    )


def working_units(cluster: Cluster) -> Flags:
    """Return which units carry momentum, shape (6,); failed ones show nothing of their alignment."""
    return np.asarray(cluster.rotor_momentum != 0.0)


def _corrected(motion: GimbalMotion, alignment: Alignment) -> tuple[UnitSeries, UnitSeries, UnitSeries]:
    momentum = (1.0 + alignment.momentum_scale) * motion.rotor_momentum
    return motion.angle - alignment.encoder_zero, motion.rate, momentum


def _held(cluster: Cluster, alignment: Alignment, motion: GimbalMotion, body_rate: Vectors3) -> Array:
    """∂(J(d) ω + h)/∂p, shape (N, 3, 4 M) of M units; a unit's axes turn by axis × vector, and ∂s/∂(zero) = -t(d)."""
    turned = misaligned(cluster, alignment.misalignment)
    angle, rate, momentum = _corrected(motion, alignment)
    spin, home, gimbal = spin_axes(turned, angle), turned.spin_axis_B, turned.gimbal_axis_B
    carried = cluster.gimbal_axis_inertia * rate

    def turn(axis: Axes) -> Array:
        along_gimbal = carried[..., None] * np.cross(axis, gimbal)
        return along_gimbal + _moved(turned, momentum, spin, np.cross(axis, spin), np.cross(axis, home), body_rate)

    zero = _moved(turned, momentum, spin, -transverse_axes(turned, angle), np.zeros_like(home), body_rate)
    about_spin, about_transverse = turning_axes(cluster, alignment.misalignment)
    scale = motion.rotor_momentum[..., None] * spin
    columns = np.stack([turn(about_spin), turn(about_transverse), zero, scale], axis=1)
    return np.moveaxis(columns.reshape(len(angle), -1, 3), 1, 2)


def _moved(
    cluster: Cluster, momentum: UnitSeries, spin: Array, change: Array, home_change: Axes, body_rate: Vectors3
) -> Array:
    """Js Ω ∂s + (Js - Jt) ∂(s sᵀ - s0 s0ᵀ) ω of each unit, shape (N, 6, 3), for changes of s(d) and of s0."""
    asymmetry = (cluster.rotor_spin_inertia - cluster.rotor_transverse_inertia)[:, None]
    home = cluster.spin_axis_B

    def product_change(axis: Array, of_axis: Array) -> Array:
        along, of_along = _dot(axis, body_rate), _dot(of_axis, body_rate)
        return np.asarray(of_axis * along[..., None] + axis * of_along[..., None])

    turning = product_change(spin, change) - product_change(home, home_change)
    return np.asarray(momentum[..., None] * change + asymmetry * turning)


def _dot(axis: Array, body_rate: Vectors3) -> Series:
    """Return each unit's axis·ω, shape (N, 6)."""
    return np.asarray(np.sum(axis * body_rate[:, None, :], axis=-1))
