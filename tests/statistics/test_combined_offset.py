"""Records on an air bearing combined: inertia and centre of mass of 200 sets of two, against their stated intervals."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from testbed.assembly.estimators import estimation_settings
from testbed.assembly.platform import nominal_platform, true_platform
from testbed.assembly.telemetry import telemetry_of
from testbed.dynamics.inertia import theta_of
from testbed.estimation.agreement import runs_agreement
from testbed.estimation.combine import combined
from testbed.estimation.output_error import output_error
from testbed.estimation.surroundings import integrated
from testbed.estimation.telemetry import Telemetry, covered_part
from testbed.experiment.conduct import conduct
from testbed.scenario.reader import read_scenario
from testbed.scenario.scenario import Scenario
from testbed.scenario.shipped import shipped_scenario

SETS, SEED, NOISE = 200, 9102, 4e-4
MOTIONS = ((1.0, 1.0, 1.0), (-1.0, 1.0, 0.5))
"""Shares of the shipped motion about each axis, a record each: offset and inertia mix differently in the two."""


@cache
def scenario(shares: tuple[float, ...] = MOTIONS[0]) -> Scenario:
    """Ten seconds of the shipped table without noise."""
    shipped = read_scenario(shipped_scenario("air_bearing"))
    keys = shipped.model_dump(mode="json", by_alias=True, exclude_unset=True, exclude_none=True)
    keys["gyro"] = {"sample_rate_hz": 25.0, "noise_rad_s": 0.0}
    keys["wheel_tachometer"] = {"noise_rad_s": 0.0}
    keys["simulation"] |= {"duration_s": 10.0, "control_rate_hz": 200.0, "telemetry_rate_hz": 200.0}
    keys["maneuver"]["body_rate_rad_s"] = (np.array(keys["maneuver"]["body_rate_rad_s"]) * shares).tolist()
    return Scenario.model_validate(keys)


@cache
def records() -> tuple[Telemetry, ...]:
    flights = ((each, conduct(each, seed=1).flown.record) for each in map(scenario, MOTIONS))
    found = (covered_part(telemetry_of(record, each, nominal_platform(each))) for each, record in flights)
    return tuple(replace(each, gyro_noise=NOISE) for each in found)


@cache
def estimates():
    """Estimates of every set's records."""
    settings = estimation_settings(scenario(), nominal_platform(scenario()), maneuver=None)
    rng, start = np.random.default_rng(SEED), np.array(scenario().initial.attitude_quat_NB)

    def noisy(run: Telemetry) -> Telemetry:
        rate = run.body_rate + NOISE * rng.standard_normal(run.body_rate.shape)
        return replace(run, body_rate=rate, surroundings=replace(
            run.surroundings, attitude=integrated(run.gyro_time, rate, start)
        ))  # fmt: skip

    return [
        [output_error(noisy(run), settings).about_center_of_mass(run.pivot) for run in records()] for _ in range(SETS)
    ]


def truth():
    """θ, and the offset's error."""
    true = true_platform(scenario())
    offset_error = true.environment.offset_B - nominal_platform(scenario()).environment.offset_B
    return np.concatenate([theta_of(true.inertia), offset_error])


def test_combined_intervals_hold_inertia_and_centre_of_mass_in_95_percent():
    together = [combined(each) for each in estimates()]
    errors = np.array([each.joint - truth() for each in together])
    stds = np.array([np.concatenate([each.std, each.offset_std]) for each in together])
    held = (np.abs(errors) < 1.96 * stds).mean(axis=0)
    scatter = errors.std(axis=0) / np.sqrt((stds**2).mean(axis=0))
    squares = [
        error @ np.linalg.solve(each.joint_covariance, error) for error, each in zip(errors, together, strict=True)
    ]
    print(f"held {held.round(3)}, scatter over stated {scatter.round(2)}, χ² {np.mean(squares):.2f} of 9")
    # A share of 200 sets has a standard deviation of 1.5 %, a scatter of 5 %, the mean of χ² of 0.3: 3.3 of each.
    assert held.min() > 0.90
    assert held.mean() == pytest.approx(0.95, abs=0.02)
    assert scatter == pytest.approx(1.0, abs=0.165)
    assert np.mean(squares) == pytest.approx(9.0, abs=1.0)


def test_the_centre_of_mass_is_known_better_by_both_records_than_by_either_and_than_without_the_inertia_beside_it():
    """Offset and inertia are correlated, otherwise in each record: a joint average uses it."""
    together, each = combined(estimates()[0]), estimates()[0]
    apart = np.sqrt(np.diag(np.linalg.inv(sum(np.linalg.inv(one.offset_covariance) for one in each))))
    print(f"offset known to {1e6 * together.offset_std} µm, without the inertia beside it to {1e6 * apart} µm")
    assert all((together.offset_std < one.offset_std).all() for one in each)
    assert (together.offset_std < apart).all()


def test_records_that_agree_are_not_refused_and_a_moved_centre_of_mass_is():
    chances = [runs_agreement(each).p_value for each in estimates()]
    assert np.mean(np.array(chances) < 0.05) < 0.10
    first, second = estimates()[0]
    moved = replace(second, offset_error=second.offset_error + 10.0 * second.offset_std)
    assert runs_agreement([first, second]).freedom == 9
    assert runs_agreement([first, moved]).refused
