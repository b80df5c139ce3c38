"""Predictions of measured runs against a tight integration, and their derivatives against differences."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation
from typing_extensions import override

from support.synthetic_telemetry import TRUE_THETA, exact_telemetry, nominal_flight, sample_times
from testbed.arrays import Array
from testbed.dynamics.inertia import symmetric_inverse
from testbed.effects.contact import Contact
from testbed.effects.contract import components_in
from testbed.effects.registry import EFFECTS
from testbed.errors import InputError
from testbed.estimation.motion import drive_of, simulate
from testbed.prediction.grid import PAUSE, grid_of
from testbed.prediction.hooks import Hooks, Instant
from testbed.prediction.integration import Values, node_rates
from testbed.prediction.prediction import (
    derivatives_at,
    predicted,
    predicted_with_derivatives,
    torque_responses,
    without_gyro_errors,
)
from testbed.prediction.smoothed import body_motion

MOMENTUM_B = np.array([0.003, -0.004, 0.006])
FLIGHT = nominal_flight(MOMENTUM_B)
RUN = exact_telemetry(FLIGHT, sample_times(16.0), sample_times(1000.0))  # so that encoders leave no error
SHORT = replace(RUN, gyro_time=RUN.gyro_time[:40], body_rate=RUN.body_rate[:40])
GRID = grid_of([RUN, SHORT])
INITIAL_RATE = np.stack([RUN.body_rate[0], SHORT.body_rate[0]])[:, None]


def values(*effects: float | Array, theta=TRUE_THETA) -> Values:
    return Values(
        theta=np.atleast_2d(theta),
        initial_rate=INITIAL_RATE,
        effects=tuple(np.atleast_2d(np.asarray(value, dtype=float)) for value in effects),
    )


def test_the_prediction_meets_the_exact_motion_in_every_run():
    for reading, run in zip(predicted(GRID, [], values()), (RUN, SHORT), strict=True):
        np.testing.assert_allclose(reading[0], run.body_rate, atol=1e-8)  # rad/s, of 1 rad/s


def test_runs_of_many_lengths_are_integrated_in_parts_and_answered_in_their_order():
    lengths = (12, len(RUN.gyro_time), 14, 40, 13)
    runs = [replace(RUN, gyro_time=RUN.gyro_time[:number], body_rate=RUN.body_rate[:number]) for number in lengths]
    grid = grid_of(runs)
    assert [part.number.tolist() for part in grid.parts] == [[1], [3], [0, 2, 4]]
    begin = grid.earlier[3] + 3 * PAUSE - RUN.gyro_time[0]
    touch = np.array([[begin + RUN.gyro_time[20], 1e-3, -2e-3, 5e-4]])
    first = np.tile(RUN.body_rate[0], (len(runs), 1, 1))
    model = Values(theta=TRUE_THETA[None], initial_rate=first, effects=(touch,))
    found = predicted(grid, [Contact().hooks("platform")], model)
    assert [block.shape[1] for block in found] == list(lengths)
    for run, reading in enumerate(found):
        own = touch - np.eye(4)[0] * (grid.earlier[run] + run * PAUSE)  # in its own time
        alone = replace(model.of_runs(np.array([run])), effects=(own,))
        expected = predicted(grid_of([runs[run]]), [Contact().hooks("platform")], alone)[0]
        np.testing.assert_allclose(reading, expected, atol=1e-7)
        moved = np.abs(reading[0] - RUN.body_rate[: lengths[run]]).max()
        assert (moved > 1e-2) == (run == 3)  # the touch is in one run alone


def test_it_agrees_with_the_estimators_own_prediction():
    theirs = simulate(drive_of(RUN), TRUE_THETA + 1e-3, MOMENTUM_B).body_rate
    ours = predicted(grid_of([RUN]), [], replace(values(theta=TRUE_THETA + 1e-3), initial_rate=theirs[:1][:, None]))
    np.testing.assert_allclose(ours[0][0], theirs, atol=1e-8)


def test_gimbals_are_moved_by_the_body_and_not_by_what_a_late_gyro_shows():
    late, delay = EFFECTS["gyro_latency"].hooks("gyro"), replace(values(0.012), initial_rate=INITIAL_RATE[:1])
    grid = grid_of([RUN])
    late_grid = replace(grid, runs=(replace(RUN, body_rate=predicted(grid, [late], delay)[0][0]),))
    restored = without_gyro_errors(late_grid, [late], delay)
    missed = [np.abs(body_motion(each.runs[0])(RUN.gyro_time) - RUN.body_rate).max() for each in (late_grid, restored)]
    assert missed[0] > 3e-3  # rad/s
    assert missed[1] < 1e-4  # what smoothing costs
    assert without_gyro_errors(restored, [], delay).runs[0].gyro_error is None


@pytest.mark.parametrize(("effect", "value"), [("gyro_latency", 0.03), ("gyro_bandwidth", 0.03)])
def test_a_late_gyro_shows_what_was_before_its_first_sample(effect, value):
    """A run that begins in the middle of a motion, whose actuators' telemetry begins before its gyro's.

    Where that is by a sample or three, its own samples say whether it was released.
    """
    hooks, whole = [EFFECTS[effect].hooks("gyro")], replace(values(value), initial_rate=INITIAL_RATE[:1])
    shown = predicted(grid_of([RUN]), hooks, whole)[0][0]
    first = replace(whole, initial_rate=RUN.body_rate[20][None, None])
    cut = replace(RUN, gyro_time=RUN.gyro_time[20:], body_rate=RUN.body_rate[20:])
    late = predicted(grid_of([cut]), hooks, first)[0][0]
    np.testing.assert_allclose(late, shown[20:], atol=3e-4)
    assert np.abs(late[0] - RUN.body_rate[20]).max() > 3e-3
    short = cut.with_actuator_rows(RUN.actuator_time >= RUN.gyro_time[18])
    for seen, begin in ((shown[20:], late[0]), (shown[20:] + RUN.body_rate[20] - shown[20], RUN.body_rate[20])):
        sent = replace(short, body_rate=seen)
        np.testing.assert_allclose(predicted(grid_of([sent]), hooks, first)[0][0][0], begin, atol=3e-4)


@pytest.mark.parametrize("drift", [0.01, -0.01])
def test_a_gyro_with_another_clock_shows_the_motion_of_another_instant(drift):
    clock = EFFECTS["gyro_clock_drift"].hooks("gyro")
    models = (([clock], values(drift)), ([], values()))
    shown, motion = (predicted(GRID, hooks, model)[0][0] for hooks, model in models)
    at = RUN.gyro_time * (1.0 - drift)
    within = at <= RUN.gyro_time[-1]
    np.testing.assert_allclose(shown[within], CubicSpline(RUN.gyro_time, motion)(at[within]), atol=2e-4)
    assert np.abs(shown - motion).max() > 5e-3


@pytest.mark.parametrize("late", [0.012, -0.012])
def test_gimbals_are_moved_by_what_the_body_did_by_their_own_clock(late):
    """The body's rate of another instant had looked like a misalignment of a gimbal."""
    skew, value = EFFECTS["telemetry_skew"].hooks("actuators"), replace(values(late), initial_rate=INITIAL_RATE[:1])
    grid = grid_of([RUN])
    moved = without_gyro_errors(grid, [skew], value)
    at = RUN.gyro_time[5:-5]
    (motion,), (before,) = (map(body_motion, each.runs) for each in (moved, grid))
    left, shifted = (np.abs(motion(at) - each).max() for each in (before(at - late), before(at)))
    assert shifted > 5e-3  # rad/s
    assert left < 0.1 * shifted  # what this model's motion differs by from the measured one


def test_an_effect_outside_the_gyro_tells_nothing_of_it():
    drag = EFFECTS["viscous_drag"].hooks("platform")
    assert without_gyro_errors(GRID, [drag], values(1e-4)) is GRID


@pytest.mark.parametrize("effect", ["contact", "flexible_appendage", "slosh"])
def test_derivatives_at_the_starts_of_a_scan_are_those_of_a_model_that_begins_there(effect):
    """A speck that does not move the body, all starts together, against the whole model at one start."""
    scanned, drag = EFFECTS[effect], EFFECTS["viscous_drag"].hooks("platform")
    starts = scanned.starts("platform", GRID)[:3]
    shown = [place for place, parameter in enumerate(scanned.parameters) if not parameter.scanned]
    hooks, model = [drag, scanned.hooks("platform")], values(1e-4)
    found = derivatives_at(GRID, hooks, model, starts, shown)
    for start, *blocks in zip(starts, *found, strict=True):
        _, expected = predicted_with_derivatives(GRID, hooks, values(1e-4, start))
        own = np.concatenate(expected)[..., 7 : 7 + len(start)][..., shown]
        scale = np.abs(own).max()
        assert scale > 0.0
        np.testing.assert_allclose(np.concatenate(blocks)[..., shown], own, atol=1e-6 * scale)


def test_parameter_sets_do_not_mix():
    many = values(theta=TRUE_THETA + 1e-3 * np.arange(3)[:, None])
    for run in range(2):
        together = predicted(GRID, [], many)[run]
        alone = [predicted(GRID, [], values(theta=theta))[run][0] for theta in many.theta]
        np.testing.assert_allclose(together, alone, atol=1e-14)


class Everything(Hooks):
    """Uses every hook at once: drag, a hinged mode, an inertial torque, a slow and late gyro, a leaking momentum."""

    states = 2
    needs_attitude = True

    @override
    def cluster_momentum(self, momentum_B, value, grid):
        return momentum_B * (1.0 + value[:, 0, None, None] * grid.time[:, None, :, None])

    @override
    def applied_torque(self, torque_B, value, grid):
        return torque_B + value[:, 1, None, None]

    @override
    def torque(self, value, at: Instant):
        field = np.array([1e-4, -2e-4, 1e-4])
        return -value[:, 2, None] * at.body_rate + value[:, 3, None] * np.vecmat(field, at.attitude)

    @override
    def hidden_inertia(self, value):
        return value[:, 4, None, None] * np.diag([1.0, 0.0, 0.0])

    @override
    def hidden_momentum(self, value, state):
        return state[..., 1:] * np.array([1.0, 0.0, 0.0])

    @override
    def state_rate(self, value, at: Instant):
        """π̇ = -k η - c η̇, η̇ = π / I - a·ω."""
        deflection, momentum = at.state[..., 0], at.state[..., 1]
        speed = momentum / value[:, 4] - at.body_rate[..., 0]
        return np.stack([speed, -value[:, 5] * deflection - 1e-5 * speed], axis=-1)

    @override
    def gyro_time_constant(self, value):
        return value[:, 6]

    @override
    def gyro_delay(self, value):
        return value[:, 7]

    @override
    def gyro_reading(self, reading, value, time, run):
        return reading * (1.0 + value[:, 8, None, None])


SIZES = np.array([0.01, 1e-4, 1e-4, 1.0, 1e-3, 0.4, 0.02, 0.013, 0.01])


def test_derivatives_agree_with_differences():
    samples, derivatives = predicted_with_derivatives(GRID, [Everything()], values(SIZES))
    for run, sample in enumerate(samples):
        np.testing.assert_allclose(sample, predicted(GRID, [Everything()], values(SIZES))[run][0], atol=1e-14)

    def shifted(index: int, step: float) -> list[Array]:
        change = np.zeros(6 + len(SIZES) + 3)
        change[index] = step
        moved = values(SIZES + change[6:-3], theta=TRUE_THETA + change[:6])
        return predicted(GRID, [Everything()], replace(moved, initial_rate=INITIAL_RATE + change[-3:]))

    scales = np.concatenate([np.full(6, 0.02), SIZES, np.ones(3)])
    for index, scale in enumerate(scales):
        step = 1e-5 * scale
        forward, back = shifted(index, step), shifted(index, -step)
        for run in range(2):
            difference = (forward[run][0] - back[run][0]) / (2 * step)
            # A central difference of 1e-5: 1e-10 of truncation, 1e-16 / 1e-5 of rounding, both per scale.
            np.testing.assert_allclose(derivatives[run][..., index] * scale, difference * scale, atol=2e-9)


def test_all_steps_at_once_are_what_stepping_along_gives():
    """Sets of different motions are stepped along, one motion is found by Newton's method."""
    hook, sizes = Everything(), np.stack([SIZES, 1.1 * SIZES])
    along = predicted(GRID, [hook], values(sizes))
    for index, size in enumerate(sizes):
        for run, at_once in enumerate(predicted(GRID, [hook], values(size))):
            np.testing.assert_allclose(at_once[0], along[run][index], atol=1e-13)  # rad/s: rounding


def test_a_motion_is_found_whatever_the_gyro_said():
    silent = [replace(run, body_rate=np.zeros_like(run.body_rate)) for run in (RUN, SHORT)]
    heard, unheard = (node_rates(grid, [Everything()], values(SIZES)) for grid in (GRID, grid_of(silent)))
    np.testing.assert_allclose(unheard, heard, atol=1e-13)


@pytest.mark.parametrize("lag", [1e-4, 0.02, 0.3])
def test_the_low_pass_is_that_of_a_line_and_of_a_sine(lag):
    """A rate that grows on a line is shown late by T; a hook that is only a lag must do what the theory says."""

    class Slow(Hooks):
        @override
        def gyro_time_constant(self, value):
            return value[:, 0]

    class Late(Hooks):
        @override
        def gyro_delay(self, value):
            return value[:, 0]

    slow, late = (predicted(GRID, [hook], values(lag))[0][0] for hook in (Slow(), Late()))
    straight = predicted(GRID, [], values())[0][0]
    if lag == 1e-4:  # T ≪ the motion's times: a lag is a delay but for T² ω̈ / 2, below 1e-8 · 100 / 2
        np.testing.assert_allclose(slow, late, atol=1e-6)
    assert np.abs(slow - straight).max() > 0.5 * lag
    # ∫ (u - x) dt = T (x(end) - x(0)): what a low-pass holds back, whatever the motion; Simpson at 16 Hz leaves 1e-4.
    held_back = np.trapezoid(straight - slow, RUN.gyro_time, axis=0)
    np.testing.assert_allclose(held_back, lag * (slow[-1] - slow[0]), atol=5e-3 * max(lag, 0.02))


def test_inverse_by_cofactors():
    matrix = np.random.default_rng(1).normal(size=(20, 3, 3))
    matrix = matrix @ np.swapaxes(matrix, -1, -2) + np.eye(3)
    np.testing.assert_allclose(symmetric_inverse(matrix) @ matrix, np.tile(np.eye(3), (20, 1, 1)), atol=1e-11)


def test_runs_with_other_channels_are_refused():
    with pytest.raises(InputError, match="same channels"):
        grid_of([RUN, without_angles()])


def without_angles():
    return replace(RUN, gimbals=None, cluster_momentum=np.zeros((len(RUN.actuator_time), 3)))


ON_GIMBALS = [each for each in EFFECTS.values() if not each.environment and "thrust" not in each.needs]
"""Those of a platform without thrusters, that flies freely."""


@pytest.mark.parametrize("effect", ON_GIMBALS, ids=lambda effect: effect.id)
def test_an_absent_effect_changes_nothing(effect):
    plain = predicted(GRID, [], values())
    absent = [parameter.absent for parameter in effect.parameters]
    for component in components_in(effect, 6):
        with_effect = predicted(GRID, [effect.hooks(component)], values(absent))
        for run in range(2):
            np.testing.assert_allclose(with_effect[run], plain[run], atol=1e-12)


@pytest.mark.parametrize("time_constant", [(), (0.01,)])
def test_equal_torques_at_all_knots_are_a_constant_torque(time_constant):
    """Behind a slow gyro as without one."""
    hooks = [EFFECTS["gyro_bandwidth"].hooks("gyro") for _ in time_constant]
    constant = [*hooks, EFFECTS["body_torque"].hooks("platform")]
    own = range(6 + len(hooks), 9 + len(hooks))
    _, expected = predicted_with_derivatives(GRID, constant, values(*time_constant, np.zeros(3)), own)
    for response, derivative in zip(torque_responses(GRID, hooks, values(*time_constant), 9), expected, strict=True):
        together = response.reshape(*response.shape[:2], 9, 3).sum(axis=2)
        np.testing.assert_allclose(together, derivative, atol=1e-11 * np.abs(derivative).max())


@pytest.mark.parametrize("effect", ["flexible_appendage", "slosh"])
def test_specks_of_the_second_degree_are_followed_as_step_by_step(effect):
    hook = EFFECTS[effect].hooks("platform")
    stepped = type("Stepped", (type(hook),), {"quadratic": False})()
    starts = EFFECTS[effect].starts("platform", GRID)[:2]
    every = [derivatives_at(GRID, [each], values(), starts, [2, 3, 4]) for each in (hook, stepped)]
    for compiled, expected in zip(*every, strict=True):
        assert np.abs(expected).max() > 0.0
        np.testing.assert_allclose(compiled, expected, atol=1e-10 * np.abs(expected).max())


def test_a_gyro_that_is_turned_reads_the_rate_about_its_own_axes_however_far_it_is_turned():
    """Without the square of 2 deg the inertia was off by seven standard deviations."""
    turn = np.array([0.12, -0.15, 0.05])
    straight, turned = (
        predicted(GRID, [], values()),
        predicted(GRID, [EFFECTS["gyro_misalignment"].hooks("gyro")], values(turn)),
    )
    own = Rotation.from_rotvec(turn).inv().apply(straight[0][0])
    np.testing.assert_allclose(turned[0][0], own, atol=1e-8)
