"""A scenario as one flight of a campaign draws it."""

from __future__ import annotations

import numpy as np
from pydantic import BaseModel

from testbed.arrays import Array
from testbed.assembly.platform import nominal_platform
from testbed.dynamics.inertia import inertia_of, theta_of
from testbed.scenario.dispersion import Dispersion
from testbed.scenario.scenario import Scenario
from testbed.sensors.sampling import generators

_STREAM = 4
"""Key of the dispersions among the children of a flight's seed; the sensors have 0 to 3."""


def dispersed(scenario: Scenario, seed: int) -> Scenario:
    """Return a scenario with the truth, the start and the gyro that a seed draws from its [dispersion].

    Each quantity has a generator of its own: to disperse one more does not change what is drawn for another.

    Args:
        scenario: with or without dispersions; without, it is returned as it is.
        seed: of the flight.
    """
    spread = scenario.dispersion
    if spread is None:
        return scenario
    inertia, rotors, rate, velocity, bias, scale = generators(np.random.SeedSequence(seed, spawn_key=(_STREAM,)), 6)
    start, gyro = scenario.initial, scenario.gyro
    return scenario.model_copy(
        update={
            "truth": _changed(scenario.truth, _inertia(scenario, spread, inertia) | _rotors(scenario, spread, rotors)),
            "initial": _changed(
                start,
                {
                    "body_rate_rad_s": _drawn(start.body_rate_rad_s, spread.body_rate_rad_s, rate),
                    "velocity_m_s": _drawn(start.velocity_m_s, spread.velocity_m_s, velocity),
                },
            ),
            "gyro": _changed(
                gyro,
                {
                    "bias_rad_s": _drawn(gyro.bias_rad_s, spread.gyro_bias_rad_s, bias),
                    "scale_factor_error": _drawn(gyro.scale_factor_error, spread.gyro_scale_factor, scale),
                },
            ),
        }
    )


def _drawn(mean: tuple[float, ...], std: tuple[float, ...], rng: np.random.Generator) -> tuple[float, ...]:
    return _plain(np.array(mean) + np.array(std) * rng.standard_normal(len(std)))


def _inertia(scenario: Scenario, spread: Dispersion, rng: np.random.Generator) -> dict[str, object]:
    """The true inertia; where neither [truth] nor [platform] states one, the spread is about the model's own."""
    if not any(spread.inertia_kg_m2):
        return {}
    stated = scenario.truth.inertia_kg_m2 or scenario.platform.inertia_kg_m2
    mean = nominal_platform(scenario).inertia if stated is None else np.array(stated)
    theta = theta_of(mean) + np.array(spread.inertia_kg_m2) * rng.standard_normal(6)
    return {"inertia_kg_m2": tuple(_plain(row) for row in inertia_of(theta))}


def _rotors(scenario: Scenario, spread: Dispersion, rng: np.random.Generator) -> dict[str, object]:
    if spread.rotor_momentum_relative == 0.0:
        return {}
    stated = scenario.truth.rotor_momentum_N_m_s
    mean = np.broadcast_to(scenario.gyros.rotor_momentum if stated is None else stated, scenario.gyros.units)
    return {
        "rotor_momentum_N_m_s": _plain(mean * (1.0 + spread.rotor_momentum_relative * rng.standard_normal(len(mean))))
    }


def _changed(section: BaseModel, update: dict[str, object]) -> BaseModel:
    return section.model_copy(update=update)


def _plain(values: Array) -> tuple[float, ...]:
    return tuple(float(value) for value in values)
