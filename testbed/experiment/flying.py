"""Fly a maneuver on the true platform of a scenario, once or many times side by side."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from testbed.arrays import Vectors3
from testbed.assembly.control import expected_torque, flight_clock, flight_controller, preferred_gimbal_angle
from testbed.assembly.engine import engine_of
from testbed.assembly.platform import PlatformModel, each_wheel, initial_momentum, true_plant
from testbed.assembly.sensors import flight_sensors
from testbed.dynamics.environment import outside_torque
from testbed.maneuver.maneuver import Maneuver
from testbed.records.record import Record, RunDetails
from testbed.rotation.quaternion import matrix_of
from testbed.scenario.environment import AirBearing
from testbed.scenario.scenario import Scenario
from testbed.simulation.channels import channels_of
from testbed.simulation.flight import Clock, Flight, flight_of, side_by_side, targets_of
from testbed.simulation.loop import Outcome, fly
from testbed.simulation.summary import FlightLimits, FlightSummary, summarize


@dataclass(frozen=True, kw_only=True)
class FlownRun:
    """A finished flight.

    Attributes:
        record: telemetry and what only the simulation knows, one row per control period.
        summary: tracking, use of limits, conservation.
        divergence: what went wrong and when; empty for a completed flight.
        first_contact: time of the first contact with the cabin, s; None where there was none.
        period: between rows of the record, s.
        tilt_limit: that a bearing allows, rad, infinite where none is stated; None of a platform that floats.
    """

    record: Record
    summary: FlightSummary
    divergence: str
    first_contact: float | None
    period: float
    tilt_limit: float | None = None


@dataclass(frozen=True, kw_only=True)
class Sortie:
    """One flight among several of a scenario: what may differ between them.

    Attributes:
        scenario: with the truth, the start and the gyro of this flight; all else is as the controller believes.
        truth: what flies.
        seed: of all sensor noise.
    """

    scenario: Scenario
    truth: PlatformModel
    seed: int


def prepare_flight(scenario: Scenario, sorties: Sequence[Sortie], nominal: PlatformModel, maneuver: Maneuver) -> Flight:
    """Put together everything about flights side by side but the plant.

    Args:
        scenario: clock and controller, and the start that the controller expects.
        sorties: the flights.
        nominal: what the controller believes.
        maneuver: the reference.

    Raises:
        InputError: clocks that do not divide.
    """
    clock = flight_clock(scenario, maneuver.duration)
    controller = flight_controller(scenario, nominal)
    return Flight(
        clock=clock,
        controller=controller,
        sensors=side_by_side([flight_sensors(sortie.scenario, clock, sortie.seed) for sortie in sorties]),
        targets=targets_of(
            maneuver,
            clock,
            controller,
            preferred_gimbal_angle=preferred_gimbal_angle(scenario),
            initial_momentum_B=initial_momentum(scenario, nominal),
            outside_torque_B=expected_torque(scenario, nominal, maneuver, clock.tick_times),
        ),
    )


def fly_maneuver(
    scenario: Scenario, nominal: PlatformModel, truth: PlatformModel, maneuver: Maneuver, seed: int
) -> FlownRun:
    """Fly a maneuver once in the closed loop.

    Args:
        scenario: what to fly.
        nominal: what the controller believes.
        truth: what flies.
        maneuver: the reference.
        seed: of all sensor noise.
    """
    (run,) = fly_sorties(scenario, [Sortie(scenario=scenario, truth=truth, seed=seed)], nominal, maneuver)
    return run


def fly_sorties(
    scenario: Scenario,
    sorties: Sequence[Sortie],
    nominal: PlatformModel,
    maneuver: Maneuver,
    threads: int = 1,
    *,
    many: bool = False,
) -> list[FlownRun]:
    """Fly a maneuver in the closed loop, several flights side by side; each comes out as if flown alone, bit for bit.

    Args:
        scenario: clock and controller, and the start that the controller expects.
        sorties: the flights.
        nominal: what the controller believes.
        maneuver: the reference.
        threads: that step the platforms.
        many: whether they are of many flights, as of a campaign; see `assembly.engine.engine_of`.

    Raises:
        InputError: the scenario asks for an engine that does not cover its platform.
    """
    flight = prepare_flight(scenario, sorties, nominal, maneuver)
    engine = engine_of(scenario, sorties[0].truth.model, many=many)
    plant = true_plant([(sortie.scenario, sortie.truth) for sortie in sorties], threads, engine)
    outcomes = fly(plant, flight)
    return [
        _flown(
            sortie,
            outcome,
            flight_of(flight, platform),
            plant.total_momentum(platform, outcome.log.qpos, outcome.log.qvel),
        )
        for platform, (sortie, outcome) in enumerate(zip(sorties, outcomes, strict=True))
    ]


def _flown(sortie: Sortie, outcome: Outcome, flight: Flight, momentum_N: Vectors3) -> FlownRun:
    """Make the record and the figures of one flight, whose total momentum the simulation knows."""
    scenario, truth = sortie.scenario, sortie.truth
    channels = channels_of(outcome.log, flight, truth.model, truth.cluster, truth.wheels, momentum_N)
    time = flight.clock.tick_times[: len(outcome.log.gyro)]
    touched = np.flatnonzero(outcome.log.contacts)
    record = Record(
        time=time,
        channels=channels,
        details=RunDetails(
            name=scenario.name,
            source="simulated",
            gyro_noise=scenario.gyro.noise_rad_s or None,
            # The row that shows the contact was written after it; the one before may have seen its beginning.
            usable_to=float(time[max(touched[0] - 2, 0)]) if touched.size else None,
        ),
    )
    return FlownRun(
        record=record,
        summary=_summary(scenario, truth, record, flight.clock),
        divergence=outcome.divergence,
        first_contact=float(time[touched[0]]) if touched.size else None,
        period=flight.clock.period,
        tilt_limit=_tilt_limit(scenario),
    )


def flight_limits(scenario: Scenario) -> FlightLimits:
    """Return the limits that a flight's use is measured against."""
    return {
        "gimbal_rate": scenario.gyros.gimbal_rate_limit,
        "gimbal_torque": scenario.gyros.gimbal_torque_limit,
        "cluster_momentum": np.array(scenario.limits.cluster_momentum_N_m_s),
        "cluster_torque": np.array(scenario.limits.cluster_torque_N_m),
        "wheel_torque": each_wheel(scenario, "torque_limit_N_m"),
        "wheel_speed": each_wheel(scenario, "momentum_limit_N_m_s") / each_wheel(scenario, "spin_inertia_kg_m2"),
    }


def _tilt_limit(scenario: Scenario) -> float | None:
    environment = scenario.environment
    if not isinstance(environment, AirBearing):
        return None
    return np.inf if environment.tilt_limit_rad is None else environment.tilt_limit_rad


def _summary(scenario: Scenario, truth: PlatformModel, record: Record, clock: Clock) -> FlightSummary:
    return summarize(
        record.channels, clock.period, flight_limits(scenario), truth.held_capacity, _outside_impulse(truth, record)
    )


def _outside_impulse(truth: PlatformModel, record: Record) -> Vectors3 | None:
    """Return ∫ R τ dt of the environment along the flight as flown, shape (N, 3), N·m·s, in N; None without one."""
    if truth.environment is None or len(record.time) < 2:
        return None
    matrix_NB = matrix_of(record.channels["true_attitude"])
    torque_B = outside_torque(
        truth.environment, truth.inertia, record.time, matrix_NB, record.channels["true_body_rate"]
    )
    return np.asarray(CubicSpline(record.time, np.matvec(matrix_NB, torque_B)).antiderivative()(record.time))
