"""The centre of mass of one rotor lies beside its axis: a force turns with it, and the platform trembles."""

from __future__ import annotations

from collections.abc import Iterator
from typing import final

import numpy as np
import scipy
from typing_extensions import override

from testbed.arrays import Array, Matrix3, Vector3
from testbed.effects.contract import UNITS, Extension, Parameter, unit_index
from testbed.effects.noise_effect import Finding, NoiseEffect, Readings
from testbed.estimation.telemetry import GimbalRun, has_gimbals
from testbed.plant.unit_additions import UnbalancedRotor
from testbed.scenario.scenario import Scenario

_ALIASED = 1e-6
"""Share of the larger singular value of the normal matrix of a line's two columns below which they are one: a line at
half the gyro's rate, whose phase does not show."""


@final
class RotorImbalance(NoiseEffect):
    """J ω = ... - U Ω r × (g cos φ - t sin φ), φ = Ω t + φ₀, with a φ₀ of every run's own.

    Gyros sample far too slowly to follow the rotor: what shows is a line at its speed or at the alias, on the axes that
    the unit's place r and its axes g and t give. The platform's total angular momentum hardly changes within a turn, so
    that the rate is the momentum's, over the inertia.
    """

    id = "rotor_imbalance"
    components = UNITS
    parameters = (Parameter(name="static_kg_m", unit="kg·m", typical=2e-6, lower=0.0),)
    needs = ("gimbal_angle",)
    sentence = (
        "The rotor of {component} is out of balance: the gyro shows a line at its speed, or at the alias of that."
    )
    look_alikes = ("gyro_noise",)
    confirm = "Run that rotor at another speed: the line moves with it."

    @override
    def found(self, component: str, readings: Readings) -> Finding | None:
        unit = unit_index(component)
        lines = [_line_fit(part, readings, unit) for part in range(len(readings.runs))]
        if None in lines:
            return None
        fits = [each for each in lines if each is not None]
        gain, freedom = sum(fit[1] for fit in fits), 2 * len(fits)
        squares = np.array([fit[0] @ fit[0] for fit in fits])
        errors = np.array([np.trace(fit[2]) for fit in fits])  # noise alone has such squares
        size = float(np.sqrt(max(np.mean(squares - errors), 0.0)))
        explained = [fit[3] for fit in fits]
        return Finding(
            values=np.array([size]),
            std=np.array([np.sqrt(np.mean(errors) / freedom)]),
            chi_square_reduction=gain,
            freedom=freedom,
            p_value=float(scipy.stats.chi2.sf(gain, freedom)),
            variance=np.asarray(np.mean(np.concatenate(explained) ** 2, axis=0)),
            explained=explained,
        )

    @override
    def extension(self, component: str, values: Array, scenario: Scenario) -> Extension:
        return Extension(platform=(UnbalancedRotor(unit=unit_index(component), static=float(values[0])),))


def _line_fit(part: int, readings: Readings, unit: int) -> tuple[Array, float, Array, Array] | None:
    """Return a run's (U cos φ₀, U sin φ₀), kg·m, the χ² that they explain, their covariance, and what they explain."""
    run = readings.runs[part]
    if not has_gimbals(run) or run.gimbals.cluster.position_B is None:
        return None
    columns = np.stack(list(_tremor(run, unit, run.gimbals.cluster.position_B[unit], readings.inertia)), axis=-1)
    white = readings.whitened(columns, part).reshape(-1, 2)
    residual = readings.whitened(readings.residual[part], part).ravel()
    covariance = np.asarray(np.linalg.pinv(white.T @ white, rcond=_ALIASED))
    values = covariance @ (white.T @ residual)
    return values, float(values @ (white.T @ residual)), covariance, columns @ values


def _tremor(run: GimbalRun, unit: int, position_B: Vector3, inertia: Matrix3) -> Iterator[Array]:
    """Yield the body rates at the gyro's samples for an imbalance of one kg·m at φ₀ of 0 and 90 degrees, (N, 3)."""
    cluster, spin = run.gimbals.cluster, run.gimbals.rotor_momentum
    momentum = cluster.rotor_momentum if spin is None else spin.mean(axis=0)
    speed = float(momentum[unit] / cluster.rotor_spin_inertia[unit])
    angle = run.through(np.unwrap(run.gimbals.angle, axis=0)[:, unit])(run.gyro_time)[:, None]
    transverse_B = np.cos(angle) * cluster.transverse_axis_B[unit] - np.sin(angle) * cluster.spin_axis_B[unit]
    for lead in (0.0, 0.5 * np.pi):
        turn = (speed * run.gyro_time + lead)[:, None]
        ahead_B = np.cos(turn) * cluster.gimbal_axis_B[unit] - np.sin(turn) * transverse_B
        yield np.asarray(-speed * np.linalg.solve(inertia, np.cross(position_B, ahead_B).T).T)
