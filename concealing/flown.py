"""From a case to its flights."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from concealing.case import Case
from concealing.craft import Array, Craft, nominal_craft
from concealing.flight import Clock, FlightLog, Guidance, Recording, fly
from concealing.guidance import NoGuidance, OnBoard, Software, planned_maneuver, software_of
from concealing.instruments import gyro_noise
from concealing.library import with_effects
from concealing.mechanics import Mechanics
from concealing.sensors import Noise, SensorNumbers, draw_noise

_ENTRIES = ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))
_NOISE, _EPOCH, _TORQUE = range(3)
_APPLIED_AMPLITUDE = 0.006


@dataclass(frozen=True, kw_only=True)
class Flown:
    """The flights of a case; runs that are shorter than the longest have to be cut.

    Attributes:
        case: as ordered.
        craft: as flown.
        clock: ticks of the longest run.
        sensors: nominal noise, as flown.
        log: of all runs side by side.
    """

    case: Case
    craft: Craft
    clock: Clock
    sensors: SensorNumbers
    log: Recording


@dataclass(frozen=True, kw_only=True)
class FlownCase(Flown):
    """The flights of a case by this package's own equations of motion.

    Attributes:
        mechanics: the equations.
        log: with the true states.
    """

    mechanics: Mechanics
    log: FlightLog


def generator(case: Case, purpose: int) -> np.random.SeedSequence:
    """Return the seed of one purpose."""
    return np.random.SeedSequence(case.seed, spawn_key=(purpose,))


def clock_of(case: Case) -> Clock:
    """Return the ticks of a case's longest run."""
    rate = case.telemetry.control_rate
    longest = max(run.duration for run in case.runs)
    return Clock(period=1.0 / rate, ticks=round(longest * rate), gyro_ticks=round(rate / case.telemetry.gyro_rate))


def true_craft(case: Case, known: Software) -> Craft:
    """Return the craft with its own inertia and all hidden effects."""
    numbers = known.platform
    numbers = numbers._replace(units=numbers.units if case.actuation == "cmg" else 0)
    error = np.zeros((3, 3))
    for (row, column), value in zip(_ENTRIES, case.theta_error, strict=True):
        error[row, column] = error[column, row] = value
    return with_effects(nominal_craft(numbers._replace(inertia=numbers.inertia + error)), case.effects)


def theta(craft: Craft) -> list[float]:
    """Return J11, J22, J33, J23, J13, J12, kg·m²."""
    return [float(craft.inertia[entry]) for entry in _ENTRIES]


def fly_case(case: Case, *, quiet: bool = False, refinement: float = 1.0) -> FlownCase:
    """Fly all runs of a case.

    Args:
        case: what to fly.
        quiet: without any noise of the sensors, on board and recorded.
        refinement: of the integrator's steps.
    """
    known, clock = software_of(case.scenario), clock_of(case)
    craft, sensors = as_flown(case, quiet=quiet)
    runs, units = len(case.runs), len(craft.units.spin_inertia)
    mechanics = Mechanics(
        craft=craft,
        epoch=epochs(case),
        release_attitude=np.broadcast_to(np.eye(3), (runs, 3, 3)),
        applied=applied_torque(case) if case.actuation == "applied_torque" else None,
    )
    start = mechanics.start(released_rates(case), np.zeros((runs, units)))
    noise = noise_of(case, clock, units)
    log = fly(mechanics, start, guidance_of(case, known, clock), clock, sensors, noise, refinement)
    return FlownCase(case=case, craft=craft, mechanics=mechanics, clock=clock, sensors=sensors, log=log)


def as_flown(case: Case, *, quiet: bool) -> tuple[Craft, SensorNumbers]:
    """Return the true craft and the noise of its sensors; quiet, both without any noise."""
    craft, sensors = true_craft(case, software_of(case.scenario)), sensors_of(case)
    if quiet:
        return replace(craft, gyro=replace(craft.gyro, extra_noise=np.zeros(3))), sensors.quiet()
    return craft, sensors


def epochs(case: Case) -> Array:
    """Return when each run is released on a clock that runs on between runs, (B,), s."""
    return np.random.default_rng(generator(case, _EPOCH)).uniform(0.0, 100.0, len(case.runs))


def released_rates(case: Case) -> Array:
    """Return the body rates at release, (B, 3), rad/s."""
    return np.array([np.add(run.planned_spin, run.release_error) for run in case.runs])


def noise_of(case: Case, clock: Clock, units: int) -> Noise:
    """Return the noise of all sensors, drawn."""
    white = draw_noise(generator(case, _NOISE), clock.ticks + 1, len(case.runs), units, clock.period)
    correlation = true_craft(case, software_of(case.scenario)).gyro.noise_correlation
    return gyro_noise(case, white, clock.gyro_ticks, correlation)


def applied_torque(case: Case) -> Callable[[float], Array]:
    """Return the torque asked of actuators without momentum in each run, (B, 3), N·m: four sines an axis to 3 Hz."""
    rng = np.random.default_rng(generator(case, _TORQUE))
    shape = (len(case.runs), 3, 4)
    rate, phase = 2.0 * np.pi * rng.uniform(0.3, 3.0, shape), rng.uniform(0.0, 2.0 * np.pi, shape)
    amplitude = _APPLIED_AMPLITUDE * rng.uniform(0.5, 1.5, shape)
    return lambda time: (amplitude * np.sin(rate * time + phase)).sum(axis=-1)


def guidance_of(case: Case, known: Software, clock: Clock) -> Guidance:
    """Return what steers the runs of a case."""
    if case.actuation == "applied_torque":
        return NoGuidance()
    telemetry = case.telemetry
    controller = known.controller(telemetry.control_rate, telemetry.gyro_rate, feedback=case.feedback)
    maneuvers = [planned_maneuver(case.scenario, run.maneuver, run.planned_spin) for run in case.runs]
    return OnBoard(controller, maneuvers, clock)


def sensors_of(case: Case) -> SensorNumbers:
    """Return the noise of a case's sensors, beside what effects add."""
    sensors, telemetry = software_of(case.scenario).sensors, case.telemetry
    if telemetry.encoder_noise is not None:
        sensors = replace(sensors, encoder_noise=telemetry.encoder_noise)
    if telemetry.encoder_step is not None:
        sensors = replace(sensors, encoder_step=telemetry.encoder_step)
    return sensors
