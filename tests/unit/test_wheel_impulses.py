"""Impulses of wheels' motors are compared wheel by wheel: what one of them does costs the others nothing."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from support.wheel_telemetry import NOISE, ONE_WAY, PERIOD, SPIN, WHEELS, commanded_wheels, undersampled_wheels
from testbed.arrays import Units
from testbed.diagnosis.data import Runs, runs_of
from testbed.diagnosis.location import located
from testbed.diagnosis.method import baseline
from testbed.diagnosis.run_residuals import residuals_of
from testbed.diagnosis.testable import hypotheses
from testbed.effects.registry import EFFECTS
from testbed.estimation.telemetry import Telemetry
from testbed.prediction.command_phase import command_phase, with_command_phase
from testbed.prediction.integration import Values
from testbed.prediction.prediction import predicted_channels, predicted_with_derivatives
from testbed.prediction.wheel_impulses import delayed, impulses_of

ROUND = np.array([5e-4, 0.02, 0.02, 0.02])
"""N·m·s. From there the first wheel turns round fourteen times or more, the others never."""
INERTIA = np.array([0.03, 0.03, 0.03, 0.0, 0.0, 0.0])
OF_WHEELS = {name: effect for name, effect in EFFECTS.items() if name.startswith("wheel_")}
UNSEEN_BY_GYRO = 1e3
"""rad/s of noise in the gyro: the body, which these wheels do not turn, counts for nothing."""


def runs_with(*flown: Telemetry) -> Runs:
    names = [f"run {number}" for number, _ in enumerate(flown)]
    return runs_of(names, [replace(each, gyro_noise=UNSEEN_BY_GYRO) for each in flown])


def with_still(run: Telemetry, wheel: int) -> Telemetry:
    """The same with a wheel that stands still and is commanded nothing."""
    assert run.wheels is not None
    assert run.wheels.torque_command is not None
    turning = np.arange(WHEELS) != wheel
    return replace(
        run,
        wheels=replace(
            run.wheels,
            momentum=run.wheels.momentum * turning,
            torque_command=run.wheels.torque_command * turning,
        ),
    )


def with_coasting(run: Telemetry, wheel: int) -> Telemetry:
    """The same with a wheel that turns on without friction, commanded nothing."""
    still = with_still(run, wheel).wheels
    assert still is not None
    noise = NOISE * np.random.default_rng(7).standard_normal(len(run.actuator_time))
    momentum = still.momentum.copy()
    momentum[:, wheel] = 0.02 + noise
    return replace(run, wheels=replace(still, momentum=momentum))


def smallest_friction(runs: Runs, component: str) -> float:
    """Standard error of a dry friction alone, N·m."""
    at_rest = np.zeros((len(runs.names), 1, 3))
    values = Values(theta=INERTIA[None], initial_rate=at_rest, effects=(np.zeros((1, 1)),))
    hooks = [EFFECTS["wheel_coulomb_friction"].hooks(component)]
    _, blocks = predicted_with_derivatives(runs.grid, hooks, values, range(6, 7), predicted_channels)
    return float(sum(np.square(block).sum() for block in runs.whitened_columns(blocks)) ** -0.5)


def flown(start: Units = ONE_WAY, seed: int = 51) -> Telemetry:
    return commanded_wheels(0.0, seed, start=start)


def test_a_wheel_that_turns_round_costs_the_others_nothing():
    one_way, turning = runs_with(flown()), runs_with(flown(ROUND))
    for component in ("wheel2", "wheel3", "wheel4"):
        alone = smallest_friction(one_way, component)
        print(f"{component}: {alone:.2g} N·m")
        assert smallest_friction(turning, component) == pytest.approx(alone, rel=1e-9)
    assert smallest_friction(one_way, "wheel1") < smallest_friction(turning, "wheel1") < np.inf


def test_lost_samples_do_not_begin_the_sum_of_impulses_anew():
    """A constant torque shows in what all of them add up to. One of 25 samples is lost; the commands bend slowly."""
    run = flown()
    assert run.wheels is not None
    assert run.wheels.torque_command is not None
    bent = 1e-6 * np.sin(0.3 * run.actuator_time)[:, None] * np.ones(WHEELS)
    noise = NOISE * np.random.default_rng(9).standard_normal(bent.shape)
    given = np.concatenate([np.zeros((1, WHEELS)), np.cumsum(bent[:-1] * PERIOD, axis=0)])
    run = replace(run, wheels=replace(run.wheels, torque_command=bent, momentum=0.02 + given + noise))
    lossy = run.with_actuator_rows(np.arange(len(run.actuator_time)) % 25 != 12)
    whole, left = (smallest_friction(runs_with(each), "wheel2") for each in (run, lossy))
    print(f"{whole:.2g} -> {left:.2g} N·m")
    assert left < 1.1 * whole


def test_noise_in_commands_is_not_carried_over_lost_samples():
    """Feedback makes it of the tachometers' noise; over three lost samples in fifty nobody can know more than the rest.

    What changes smoothly is known from the rest well enough to add less than as much again; a spline through the
    samples beside the gap carries their noise across, and errs by 3.1 times the least.
    """
    run, feedback = flown(), 5e-5
    assert run.wheels is not None
    assert run.wheels.torque_command is not None
    smooth = 1e-3 * np.cos(0.9 * run.actuator_time)[:, None] * np.ones(WHEELS)
    noise = feedback * np.random.default_rng(10).standard_normal(smooth.shape)
    lost = np.arange(len(run.actuator_time)) % 50
    lossy = replace(run, wheels=replace(run.wheels, torque_command=smooth + noise)).with_actuator_rows(
        ~np.isin(lost, (20, 21, 22))
    )
    impulses = impulses_of(lossy, commanded=True)
    assert impulses is not None
    unseen = np.sqrt(impulses.unseen[impulses.unseen > 0.0])
    assert len(unseen) == 12 * 2 * WHEELS  # a gap's, and those behind it
    least = np.sqrt(3.0) * feedback * PERIOD
    print(f"{unseen.mean() / least:.2f} of the least")
    assert 0.9 * least < unseen.mean() < 1.5 * least


def test_of_a_wheel_that_turns_round_only_the_passages_are_cut():
    run = flown(ROUND)
    impulses = impulses_of(run, commanded=True)
    assert impulses is not None
    assert run.wheels is not None
    slow = np.abs(run.wheels.momentum[:, 0] / SPIN) < 0.5 + PERIOD * 1.2e-3 / SPIN  # it passes in one period at most
    cut = np.setdiff1d(impulses.kept[1], impulses.kept[0])
    assert 14 <= len(cut) < 100
    assert (slow[cut] | slow[cut + 1]).all()
    assert len(impulses.kept[1]) == len(impulses.kept[2]) == len(impulses.kept[3]) == len(impulses.interval) - 2


def test_a_wheel_that_stands_still_is_left_out_by_itself():
    runs = runs_with(with_still(flown(), 1), with_still(flown(seed=52), 1))
    noise = runs.grid.wheel_noise
    assert noise is not None
    assert noise.commanded
    assert noise.wheels == (0, 2, 3)
    np.testing.assert_allclose(noise.tachometer, NOISE, rtol=0.1)
    assert [block.shape[1] for block in runs.inner] == [1] * 6


def test_what_a_motor_does_is_not_tested_for_in_a_wheel_that_stands_still():
    testable, untestable = hypotheses(runs_with(with_still(flown(), 1)), OF_WHEELS)
    assert {each.component for each in testable if each.effect.id == "wheel_lag"} == {
        "wheel1",
        "wheel3",
        "wheel4",
        "wheels",
    }
    assert {each.component for each in testable if each.effect.id == "wheel_inertia"} == {
        f"wheel{n}" for n in range(1, 5)
    }
    assert {(each.effect, each.component) for each in untestable} == {
        (effect, "wheel2")
        for effect in ("wheel_viscous_friction", "wheel_coulomb_friction", "wheel_torque_scale", "wheel_lag")
    }


def test_the_phase_of_the_commands_is_found_beside_a_wheel_that_stands_still():
    run = with_still(commanded_wheels(0.3, 53), 1)
    assert command_phase(with_command_phase([run])) == pytest.approx(0.3 * PERIOD, abs=0.015 * PERIOD)


def test_a_wheel_that_is_commanded_nothing_keeps_the_others_compared_by_their_commands():
    noise = runs_with(with_coasting(flown(), 1)).grid.wheel_noise
    assert noise is not None
    assert noise.commanded
    assert noise.wheels == (0, 1, 2, 3)


def test_the_phase_of_the_commands_is_found_beside_wheels_that_are_commanded_nothing():
    run = with_coasting(with_coasting(commanded_wheels(0.3, 54), 1), 3)
    assert command_phase(with_command_phase([run])) == pytest.approx(0.3 * PERIOD, abs=0.015 * PERIOD)


def test_the_residual_of_each_wheel_is_shown_and_located_at_its_own_times():
    run = flown(ROUND)
    assert run.wheels is not None
    momentum = run.wheels.momentum.copy()
    momentum[400:410, 0] += 40.0 * NOISE * np.arange(1, 11)  # for a second the motor gives what nobody commanded
    momentum[410:, 0] += 400.0 * NOISE
    runs = runs_with(replace(run, wheels=replace(run.wheels, momentum=momentum)))
    state = baseline(runs, None, INERTIA)
    (shown,) = residuals_of(state)
    (channel,) = shown.gimbals
    assert [each.name for each in channel.actuators] == ["wheel 1", "wheel 2", "wheel 3", "wheel 4"]
    assert len(channel.actuators[0].time) < len(channel.actuators[1].time)
    for each in channel.actuators:
        assert len(each.time) == len(each.measured) == len(each.nominal) == len(each.extended)
    loudest = located(runs, state.baseline)[0]
    assert loudest.signal == "wheel_torque_1"
    assert loudest.from_s == pytest.approx(40.0, abs=0.5)
    assert loudest.to_s == pytest.approx(40.9, abs=0.5)


def test_what_is_commanded_between_samples_lies_on_a_spline():
    """Commands that bend in a parabola, each held for a period; one of four is sampled."""
    run = commanded_wheels(0.0, 1)
    assert run.wheels is not None
    assert run.wheels.torque_command is not None
    every = slice(None, None, 4)
    bent = 1e-4 * (run.actuator_time / 10.0) ** 2
    command = np.broadcast_to(bent[:, None], run.wheels.torque_command.shape).copy()
    fast = replace(run, wheels=replace(run.wheels, torque_command=command))
    slow = replace(
        fast,
        actuator_time=run.actuator_time[every],
        wheels=replace(fast.wheels, momentum=run.wheels.momentum[every], torque_command=command[every]),
    )
    all_of, some_of = (impulses_of(each, commanded=True) for each in (fast, slow))
    assert all_of is not None
    assert some_of is not None
    whole = len(some_of.asked) * 4
    np.testing.assert_allclose(some_of.asked, all_of.asked[:whole].reshape(-1, 4, WHEELS).sum(axis=1), rtol=1e-9)


def test_a_delay_of_whole_periods_gives_what_was_asked_for_so_many_before():
    impulses = impulses_of(commanded_wheels(0.0, 61), commanded=True)
    assert impulses is not None
    late = delayed(impulses, impulses.asked[None], np.full((1, WHEELS), 3.0 * PERIOD))[0]
    np.testing.assert_allclose(late[3:], impulses.asked[:-3], rtol=1e-9)
    np.testing.assert_allclose(late[:3], impulses.asked[[0, 0, 0]], rtol=1e-9)  # before the record as at first


def test_a_delay_of_a_part_of_a_period_gives_a_part_of_either():
    impulses = impulses_of(commanded_wheels(0.0, 62), commanded=True)
    assert impulses is not None
    late = delayed(impulses, impulses.asked[None], np.array([[0.25, 0.0, 0.5, 1.0]]) * PERIOD)[0]
    before = impulses.asked[:-1]
    share = np.array([0.25, 0.0, 0.5, 1.0])
    np.testing.assert_allclose(late[1:], share * before + (1.0 - share) * impulses.asked[1:], rtol=1e-9)


@pytest.mark.parametrize("jitter", [0.0, 2e-3, 5e-3])
def test_stamps_that_are_off_are_noise_of_the_impulses(jitter):
    """By the two commands before it an impulse seemed known without its stamps: a healthy wheel had a gap of 2.9."""
    run = undersampled_wheels(1, 52, scatter=0.0)
    off = jitter * np.random.default_rng(53).standard_normal(len(run.actuator_time))
    runs = runs_with(replace(run, actuator_time=run.actuator_time + off))
    state = baseline(runs, None, INERTIA)
    (blocks,) = runs.gimbals_by_run(state.model.residual)
    assert [float(np.sqrt(np.mean(block**2))) for block in blocks] == pytest.approx(WHEELS * [1.0], abs=0.1)
