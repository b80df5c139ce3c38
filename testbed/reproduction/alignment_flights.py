"""Flights of platforms that are built out of alignment, with null motion and without."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from testbed.arrays import Array
from testbed.assembly.platform import PlatformModel, nominal_platform, true_platform
from testbed.experiment.aligning import align_flight, null_space_lines
from testbed.experiment.flying import FlownRun, Sortie, fly_sorties
from testbed.maneuver.maneuver import Maneuver
from testbed.scenario.scenario import Scenario

AXIS_SPREAD = 0.012
"""rad, 0.7 deg: standard deviation of each turn of a gimbal axis, and of each encoder's zero."""
SCALE_SPREAD = 0.01
"""Standard deviation of each tachometer's scale, which its rotor's speed servo goes by."""


class Flight(NamedTuple):
    """What one flight gave; errors and stds are NaN where it gave nothing."""

    error: Array
    std: Array
    saturated: float
    gimbal_rate: float
    rate_difference: float
    null_space: tuple[str, ...]


def fly_block(scenario: Scenario, maneuver: Maneuver, seeds: Sequence[int]) -> list[tuple[Flight, Flight]]:
    """Fly platforms side by side, with null motion and then without; a pair for each seed.

    Args:
        scenario: nominal platform and sensors.
        maneuver: the designed one.
        seeds: of the flights.
    """
    without = replace(maneuver, gimbal_angle=None)
    return list(
        zip(
            _flights(scenario, maneuver, seeds),
            _flights(pseudo_inverse_scenario(scenario), without, seeds),
            strict=True,
        )
    )


def pseudo_inverse_scenario(scenario: Scenario) -> Scenario:
    """Return the same scenario steered without null motion: no gimbal angles are preferred to others."""
    steering = scenario.controller.steering.model_copy(
        update={"preferred_gimbal_angle_rad": "zero", "null_motion_gain_1_s": 0.0}
    )
    controller = scenario.controller.model_copy(update={"steering": steering})
    return scenario.model_copy(update={"controller": controller})


def as_built(scenario: Scenario, seed: int) -> Scenario:
    """Return a scenario whose flown units are out of alignment as a seed draws it.

    A rotor's servo goes by its tachometer, so that a tachometer that reads too much leaves it too slow.
    """
    rng, units = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(0,))), scenario.gyros.units
    axes, zeros = AXIS_SPREAD * rng.standard_normal((units, 2)), AXIS_SPREAD * rng.standard_normal(units)
    scales = SCALE_SPREAD * rng.standard_normal(units)
    momenta = scenario.gyros.rotor_momentum / (1.0 + scales)
    truth = {"gimbal_axis_misalignment_rad": axes.tolist(), "rotor_momentum_N_m_s": tuple(momenta.tolist())}
    return scenario.model_copy(
        update={
            "truth": scenario.truth.model_copy(update=truth),
            "encoder": scenario.encoder.model_copy(update={"zero_rad": tuple(zeros.tolist())}),
            "tachometer": scenario.tachometer.model_copy(update={"scale_factor_error": tuple(scales.tolist())}),
        }
    )


def _flights(scenario: Scenario, maneuver: Maneuver, seeds: Sequence[int]) -> list[Flight]:
    nominal = nominal_platform(scenario)
    built = [as_built(scenario, seed) for seed in seeds]
    sorties = [
        Sortie(scenario=each, truth=true_platform(each), seed=seed) for each, seed in zip(built, seeds, strict=True)
    ]
    flown = fly_sorties(scenario, sorties, nominal, maneuver)
    return [_flight(sortie, nominal, run) for sortie, run in zip(sorties, flown, strict=True)]


def _flight(sortie: Sortie, nominal: PlatformModel, run: FlownRun) -> Flight:
    aligning = align_flight(sortie.scenario, nominal, sortie.truth, run.record)
    estimate, nothing = aligning.estimate, np.full(len(aligning.true_parameters), np.nan)
    return Flight(
        error=nothing if estimate is None else estimate.parameters - aligning.true_parameters,
        std=nothing if estimate is None else estimate.std,
        saturated=run.summary.saturated,
        gimbal_rate=run.summary.limit_use["gimbal_rate"],
        rate_difference=float(run.summary.tracking_rms.max()),
        null_space=() if estimate is None else tuple(null_space_lines(estimate.observability)),
    )
