"""Gaps of the actuators' telemetry: which are bridged, what that costs, and what wheels' motors tell over them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation

from support.wheel_telemetry import ARRAY, NOISE, PERIOD, TICKS, WHEELS, commanded_wheels, wheels_at_rest
from testbed.arrays import Array, Flags, Series
from testbed.diagnosis.bridging import _costs, _tried, bridged_stretches
from testbed.dynamics.environment import Pivoted
from testbed.estimation.gaps import bursts, gaps
from testbed.estimation.surroundings import Attitude, Surroundings
from testbed.estimation.telemetry import Telemetry
from testbed.prediction.impulse_noise import impulse_fit, wheels_with
from testbed.prediction.wheel_impulses import impulses_of, lagged, without_correlation

INERTIA = np.diag([0.03, 0.04, 0.05])
TIME = PERIOD * np.arange(TICKS)


def swinging(rate: float) -> Telemetry:
    """Wheels that swing at an angular frequency, rad/s."""
    phase = rate * TIME[:, None] + np.arange(WHEELS)
    return wheels_at_rest(0.02 + 2e-3 * np.sin(phase), 2e-3 * rate * np.cos(phase), TIME)


def without_rows(run: Telemetry, gone: Flags) -> Telemetry:
    return run.with_actuator_rows(~gone)


def lost(*seconds: tuple[float, float]) -> Flags:
    return np.any([np.abs(2.0 * TIME - first - last) < last - first for first, last in seconds], axis=0)


@pytest.mark.parametrize(
    ("rate", "until", "stretches"),
    [
        pytest.param(0.5, 20.35, 1, id="slow wheels are known over four tenths of a second"),
        pytest.param(0.5, 20.85, 1, id="and over nine"),
        pytest.param(0.5, 21.25, 2, id="what happened in longer gaps no telemetry tells"),
        pytest.param(9.0, 20.35, 2, id="wheels that swing in half a second are not known"),
    ],
)
def test_a_gap_is_bridged_where_samples_that_came_through_show_that_it_costs_little(rate, until, stretches):
    run = without_rows(swinging(rate), lost((19.95, until)))
    assert len(bridged_stretches(run, INERTIA)) == stretches


@pytest.mark.parametrize(("lost_rows", "stretches"), [(13, 1), (16, 2)])
def test_gaps_up_to_three_tenths_are_bridged_without_being_asked(lost_rows, stretches):
    """At 50 Hz, of wheels that swing twice a second: 0.28 s and 0.34 s."""
    time = 0.02 * np.arange(1000)
    phase = 12.0 * time[:, None] + np.arange(WHEELS)
    run = wheels_at_rest(0.02 + 2e-3 * np.sin(phase), -0.024 * np.cos(phase), time)
    gone = (np.arange(1000) >= 500) & (np.arange(1000) < 500 + lost_rows)
    assert len(bridged_stretches(without_rows(run, gone), INERTIA)) == stretches


def test_an_axis_that_a_bearing_holds_costs_nothing():
    run = without_rows(swinging(3.0), lost((19.95, 20.55)))
    held = replace(run, live=(False, False, True))
    assert len(bridged_stretches(run, INERTIA)) == 2
    assert len(bridged_stretches(held, INERTIA)) == 1  # about one axis the total momentum does not turn in the body


def test_a_pivot_on_which_gravity_pulls_makes_a_gap_dearer():
    run = without_rows(swinging(0.5), lost((19.95, 20.35)))
    light, heavy = (
        _costs(on_pivot(run, mass), INERTIA, gaps(run.actuator_time, shortest=0.3)) for mass in (1e-6, 50.0)
    )
    cut = np.isfinite(light)
    assert cut.sum() == 1
    assert heavy[cut] > 100.0 * light[cut]


def on_pivot(run: Telemetry, mass: float) -> Telemetry:
    attitude = Attitude(
        start=np.array([1.0, 0.0, 0.0, 0.0]), turns=CubicSpline(TIME, np.tile([1.0, 0.0, 0.0, 0.0], (TICKS, 1)))
    )
    environment = Pivoted(mass=mass, gravity=9.81, offset_B=np.array([0.0, 0.0, -1e-3]))
    around = Surroundings(environment=environment, inertia=INERTIA, attitude=attitude, measured=True)
    return replace(run, surroundings=around)


def test_noise_of_tachometers_that_commands_separate_costs_little():
    run = smooth()
    alone = replace(run, wheels=replace(run.wheels, torque_command=None))
    cut = gaps(run.actuator_time, shortest=0.3)
    known, unknown = (_costs(each, INERTIA, cut)[cut] for each in (run, alone))
    assert known < 0.3 * unknown


def smooth() -> Telemetry:
    """Wheels that follow smooth commands, with noise in their tachometers and a gap."""
    command = swinging(0.9).wheels.torque_command
    held = 0.02 + PERIOD * np.cumsum(np.concatenate([np.zeros((1, WHEELS)), command[:-1]]), axis=0)
    scatter = NOISE * np.random.default_rng(5).standard_normal(held.shape)
    return without_rows(wheels_at_rest(held + scatter, command, TIME), lost((19.95, 20.35)))


@pytest.mark.parametrize("lost_rows", [1, 7, 12, 13, 60, 199])
def test_gaps_are_tried_at_least_as_long_as_they_are(lost_rows):
    (tried,) = _tried(np.array([lost_rows]))
    assert lost_rows <= tried <= max(lost_rows, 1.2 * lost_rows + 1)
    assert tried == lost_rows or lost_rows > 12


def test_few_gaps_are_bridged_where_each_costs_much_and_the_cheapest_first():
    run = without_rows(swinging(1.0), lost((9.95, 10.45), (19.95, 20.65), (29.95, 30.65), (39.95, 40.65)))
    cut = gaps(run.actuator_time, shortest=0.3)
    costs = np.sort(_costs(run, INERTIA, cut)[cut])
    assert costs[0] < 0.2 * costs[1]
    assert len(bridged_stretches(run, INERTIA)) == 4
    assert len(bridged_stretches(run, 3.0 * INERTIA)) == 1


def test_a_run_that_is_too_short_to_tell_is_cut():
    run = without_rows(swinging(0.5), lost((1.95, 2.35)) | (TIME > 4.0))
    assert len(bridged_stretches(run, INERTIA)) == 2


@pytest.mark.parametrize("rate", [2.0, 4.0])
def test_a_gap_costs_what_the_motion_behind_it_errs_by(rate):
    """The body's rate by conservation of momentum, with and without samples, for a gap in every tenth of the run."""
    run = swinging(rate)
    assert run.wheels is not None
    exact = turned(TIME, run.wheels.momentum @ ARRAY.axis_B, TIME)
    squares = []
    for begin in np.arange(5.0, 55.0, 5.0):
        gone = lost((begin - 0.05, begin + 0.55))
        found = turned(TIME[~gone], run.wheels.momentum[~gone] @ ARRAY.axis_B, TIME)
        squares.append(np.sum((found - exact)[~gone] ** 2) / run.gyro_noise**2)
    moving = without_rows(replace(run, body_rate=exact), lost((29.95, 30.55)))
    cut = gaps(moving.actuator_time, shortest=0.3)
    (cost,) = _costs(moving, INERTIA, cut)[cut]
    assert cost == pytest.approx(np.mean(squares), rel=0.5)


def turned(samples: Series, momentum_B: Array, time: Series) -> Array:
    """Return the rate of a body whose wheels hold a momentum, its total that of the wheels at first, rad/s."""
    stored = CubicSpline(samples, momentum_B)
    total = momentum_B[0]

    def slope(at: float, state: Array) -> Array:
        rate = np.linalg.solve(INERTIA, Rotation.from_quat(state).inv().apply(total) - stored(at))
        x, y, z, w = state
        matrix = np.array([[w, -z, y], [z, w, -x], [-y, x, w], [-x, -y, -z]])
        return np.asarray(0.5 * matrix @ rate)

    flown = solve_ivp(slope, time[[0, -1]], [0.0, 0.0, 0.0, 1.0], t_eval=time, rtol=1e-10, atol=1e-12)
    held = Rotation.from_quat(flown.y.T).inv().apply(total)
    return np.linalg.solve(INERTIA, (held - stored(time)).T).T


def test_a_motor_with_a_lag_gives_over_lost_samples_and_behind_them_what_is_predicted():
    lag = np.full(WHEELS, 0.03)
    run = without_rows(commanded_wheels(0.0, 41, lag=lag), bursts(TICKS, 5) & (TIME > 30.0))
    impulses = impulses_of(run, commanded=True)
    noise = impulse_fit([impulses], tuple(range(WHEELS)), commanded=True).noise
    left = without_correlation(impulses, noise, impulses.needed - lagged(impulses, lag[None])[0])
    scaled = np.concatenate([each / sigma for each, sigma in zip(left, noise.sigma, strict=True)])
    assert np.std(scaled) == pytest.approx(1.0, rel=0.1)


def test_a_gyro_on_a_clock_of_its_own_knows_the_rate_beside_a_gap():
    run = without_rows(commanded_wheels(0.0, 41), bursts(TICKS, 3) & (TIME > 30.0))
    gyro = run.gyro_time[~(bursts(TICKS, 3) & (TIME > 30.0))] + 0.037
    apart = replace(run, gyro_time=gyro, body_rate=np.zeros((len(gyro), 3)))
    over = impulses_of(apart, commanded=True).interval > 1.5 * PERIOD
    assert all(over[kept].sum() == over.sum() for kept in impulses_of(apart, commanded=True).kept)


def test_a_wheel_that_is_compared_over_lost_samples_alone_is_left_out():
    every_second = (TIME > 30.0) & (np.arange(TICKS) % 2 == 1)
    run = commanded_wheels(0.0, 41)
    still = np.where((TIME < 30.0)[:, None] & (np.arange(WHEELS) == 0), 0.0, run.wheels.momentum)
    run = without_rows(replace(run, wheels=replace(run.wheels, momentum=still)), every_second)
    assert wheels_with([impulses_of(run, commanded=True)], fewest=20) == (1, 2, 3)


@pytest.mark.parametrize("seed", [41, 42, 43])
def test_lost_samples_pass_for_no_noise_of_the_motors_and_impulses_over_them_are_in_their_own(seed):
    run = without_rows(commanded_wheels(0.0, seed), bursts(TICKS, 3) & (TIME > 30.0))
    impulses = impulses_of(run, commanded=True)
    assert impulses is not None
    noise = impulse_fit([impulses], tuple(range(WHEELS)), commanded=True).noise
    assert (noise.torque * np.ptp(TIME) < 0.5 * NOISE**2).all()
    assert noise.tachometer == pytest.approx(np.full(WHEELS, NOISE), rel=0.15)
    over = impulses.interval > 1.5 * PERIOD
    assert over.sum() == 26
    left = without_correlation(impulses, noise, impulses.needed - impulses.asked)
    scaled = [(each / sigma, over[kept]) for each, sigma, kept in zip(left, noise.sigma, impulses.kept, strict=True)]
    over_lost = np.concatenate([values[of] for values, of in scaled])
    assert len(over_lost) == 26 * WHEELS
    assert np.std(over_lost) == pytest.approx(1.0, rel=0.3)
    assert np.std(np.concatenate([values[~of] for values, of in scaled])) == pytest.approx(1.0, rel=0.1)
