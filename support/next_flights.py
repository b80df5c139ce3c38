"""A proposed flight, flown by the concealing engine on the craft that a case hides."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from concealing.case import Case, Run
from concealing.files import record
from concealing.flight import fly
from concealing.flown import FlownCase, as_flown, clock_of, epochs, noise_of, released_rates
from concealing.guidance import OnBoard, software_of
from concealing.mechanics import Mechanics
from testbed.experiment.planning import plan_maneuver
from testbed.records.record import Record
from testbed.scenario.scenario import Scenario


def next_record(case: Case, scenario: Scenario, number: int = 1) -> Record:
    """Return what a case's craft shows when it flies a scenario with a gimbal maneuver.

    Args:
        case: whose craft, telemetry and controller these are; its own runs are not flown.
        scenario: with the start and the maneuver.
        number: of the flight, from 1; each has its own noise and its own error at release.
    """
    known = software_of(case.scenario)
    maneuver = plan_maneuver(scenario, known.nominal).maneuver
    assert maneuver.gimbal_angle is not None
    error = np.random.default_rng([case.seed, number]).normal(0.0, 0.01, 3)
    run = Run(
        duration=maneuver.duration,
        maneuver=0,
        planned_spin=scenario.initial.body_rate_rad_s,
        release_error=tuple(map(float, error)),
    )
    flight = replace(case, seed=case.seed + number, runs=(run,))
    clock = clock_of(flight)
    craft, sensors = as_flown(flight, quiet=False)
    mechanics = Mechanics(craft=craft, epoch=epochs(flight), release_attitude=np.eye(3)[None])
    controller = known.controller(flight.telemetry.control_rate, flight.telemetry.gyro_rate, feedback=flight.feedback)
    log = fly(
        mechanics,
        mechanics.start(released_rates(flight), maneuver.gimbal_angle(0.0)[None]),
        OnBoard(controller, [maneuver], clock),
        clock,
        sensors,
        noise_of(flight, clock, len(craft.units.spin_inertia)),
    )
    flown = FlownCase(case=flight, craft=craft, mechanics=mechanics, clock=clock, sensors=sensors, log=log)
    return named(record(flown, 0), number)


def named(flown: Record, number: int) -> Record:
    """Return a record under a name that no run of the case has."""
    return replace(flown, details=replace(flown.details, name=f"next_{number}"))
