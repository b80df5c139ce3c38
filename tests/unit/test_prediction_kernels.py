"""The integration's inner loops give what NumPy gives, with real numbers and with those that carry a derivative."""

from __future__ import annotations

import os
import subprocess
import sys

import numpy as np
import pytest
from numba.core.caching import CacheImpl
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation

from support.processes import PATIENCE
from testbed.cmg import servo_law
from testbed.compiled import kept
from testbed.dynamics.inertia import cross_matrix
from testbed.estimation import recursions
from testbed.prediction import kernels
from testbed.prediction.smooth import node_slopes

RUNS, NODES, SETS = 4, 7, 5
ONE_OF_MANY = """
import sys, numpy as np
from testbed.prediction import kernels
vectors, matrices = np.ones((3, 2, 3)), np.broadcast_to(np.eye(3), (3, 2, 3, 3))
calls = [
    lambda: kernels.body_rate(vectors, 0.0 * vectors, matrices),
    lambda: kernels.body_rate(vectors + 0j, 0.0 * vectors, matrices),
    lambda: kernels.stepped_body_rate(vectors, 0.0 * vectors, matrices, 0.0 * matrices),
    lambda: kernels.turning(vectors, vectors, 0.0 * vectors),
]
turn = int(sys.argv[1])
for call in calls[turn:] + calls[:turn]:
    assert (call() == 1.0).all()
"""
STEP = 1e-20j


def _drawn(*shape, carries):
    rng = np.random.default_rng(sum(shape) + carries)
    values = rng.standard_normal(shape)
    return values + STEP * rng.standard_normal(shape) if carries else values


def _alike(one, other):
    """To rounding, of the derivative as of the value."""
    assert one.shape == other.shape
    np.testing.assert_allclose(one.real, other.real, rtol=1e-13, atol=1e-13)
    np.testing.assert_allclose(one.imag, other.imag, rtol=1e-13, atol=1e-33)


@pytest.mark.parametrize("carries", [False, True])
@pytest.mark.parametrize("sets", [1, SETS])
def test_a_body_rate_is_the_inverse_times_the_momentum_that_is_left(carries, sets):
    momentum, held = _drawn(NODES, SETS, 3, carries=carries), _drawn(NODES, 1, 3, carries=False)
    inverse = _drawn(1, sets, 3, 3, carries=False)
    _alike(kernels.body_rate(momentum, held, inverse), np.matvec(inverse, momentum - held))


def test_a_step_of_the_inertia_turns_up_as_the_derivative_of_its_inverse():
    momentum, held = _drawn(NODES, SETS, 3, carries=True), _drawn(NODES, 1, 3, carries=True)
    inertia = np.diag([2.0, 3.0, 4.0]) + 0.1 * np.ones((3, 3))
    change = STEP.imag * _drawn(1, SETS, 3, 3, carries=False)
    rate = kernels.stepped_body_rate(momentum, held, np.linalg.inv(inertia)[None, None], change)
    nudge = 1e-6  # of a central difference, whose error is its square
    either = [np.linalg.inv(inertia + sign * nudge * change / STEP.imag) for sign in (1.0, -1.0)]
    slope = np.matvec(np.subtract(*either) / (2.0 * nudge), (momentum - held).real)
    passed_on = np.matvec(np.linalg.inv(inertia), (momentum - held).imag)
    np.testing.assert_allclose(rate.imag / STEP.imag, slope + passed_on / STEP.imag, rtol=1e-8, atol=1e-8)


@pytest.mark.parametrize("carries", [False, True])
def test_momentum_turns_by_the_torque_and_with_the_body(carries):
    torque, momentum, rate = (_drawn(NODES, SETS, 3, carries=carries) for _ in range(3))
    _alike(kernels.turning(torque[:, :1], momentum, rate), torque[:, :1] + np.cross(momentum, rate))


@pytest.mark.parametrize("carries", [False, True])
def test_a_gimbal_follows_the_law_of_the_servo_as_it_is_flown(carries):
    """Commands beyond both limits, so that they act; the plant's step is a table of any numbers here."""
    ticks, units = 60, 4
    command, fed_forward, load, slope = (2.0 * _drawn(ticks, units, carries=carries) for _ in range(4))
    first, step = _drawn(1, units, carries=carries), list(0.3 * _drawn(9, units, carries=carries))
    bandwidth, gain, limit, bound, period = law = (20.0, 12.5, 2.0, 0.12, 0.01)
    angles, rate, motor, commanded, angle = [], 0.0, 0.0, first[0], first[0]
    for tick in range(ticks):
        angles.append(angle)
        point = servo_law.within(servo_law.set_point(command[tick], commanded - angle, gain), limit)
        commanded = servo_law.next_commanded_angle(commanded, angle, bound, command[tick], period)
        demand = bandwidth * point + fed_forward[tick]
        signals = (rate, demand + load[tick], motor - demand, slope[tick])
        moved, turned = (sum(by * of for by, of in zip(part, signals, strict=True)) for part in (step[:4], step[4:8]))
        angle, rate, motor = angle + moved, turned, demand + step[8] * signals[2]
    flown = kernels.servo_angles((command, fed_forward, load, slope, first), step, law)
    scale = np.abs(angles).max()
    assert flown.shape == (ticks, units)
    np.testing.assert_allclose(flown.real, np.real(angles), atol=1e-11 * scale)
    np.testing.assert_allclose(flown.imag, np.imag(angles), atol=1e-9 * np.abs(np.imag(angles)).max())


def test_changes_are_carried_from_node_to_node():
    tangents, start = _drawn(RUNS, NODES, 6, 6, carries=False), _drawn(RUNS, SETS, 6, carries=False)
    added = _drawn(RUNS, NODES, SETS, 6, carries=False)
    expected = [start]
    for step in range(NODES):
        expected.append(expected[-1] @ tangents[:, step] + added[:, step])
    np.testing.assert_allclose(kernels.carried(tangents, start, added), np.stack(expected, axis=1), rtol=1e-11)


@pytest.mark.parametrize("carries", [False, True])
def test_sums_keep_a_share_of_those_before(carries):
    keeps, added = _drawn(1, NODES, 2, carries=False), _drawn(SETS, NODES, 2, carries=carries)
    expected = [added[:, 0]]
    for step in range(1, NODES):
        expected.append(added[:, step] + keeps[:, step] * expected[-1])
    _alike(recursions.accumulated(keeps, added), np.stack(expected, axis=1))


def test_pivots_are_the_squares_of_the_cholesky_factor():
    own, shared = 3.0 + np.abs(_drawn(NODES, 1, carries=False)), _drawn(NODES, 1, carries=False)
    matrix = np.diag(own[:, 0]) + np.diag(shared[1:, 0], 1) + np.diag(shared[1:, 0], -1)
    factor = np.diag(np.linalg.cholesky(matrix))
    np.testing.assert_allclose(recursions.pivots(own, shared)[:, 0], factor**2, rtol=1e-13)


@pytest.mark.parametrize("carries", [False, True])
@pytest.mark.parametrize("nodes", [2, 3, 4, 5, 60])
def test_slopes_at_nodes_are_those_of_the_cubic_spline(nodes, carries):
    values, at = _drawn(RUNS, SETS, nodes, 3, carries=carries), np.arange(nodes)
    _alike(node_slopes(values, 0.25), CubicSpline(at, values, axis=-2)(at, 1) / 0.25)


def test_where_nothing_can_be_kept_a_function_is_compiled_all_the_same(monkeypatch):
    monkeypatch.setattr(CacheImpl, "_locator_classes", [])

    def doubled(values, results):
        for index in range(len(values)):
            results[index] = 2.0 * values[index]

    results = np.empty(2)
    kept(doubled, (("f8", 1), ("f8", 1)))(np.array([1.0, 2.0]), results)
    np.testing.assert_array_equal(results, [2.0, 4.0])


def test_many_processes_at_once_make_and_keep_the_same_functions(tmp_path):
    """Each makes all of them, in an order of its own, so that files of different processes stand side by side."""
    folder = {"NUMBA_CACHE_DIR": str(tmp_path / "kept")}
    for _ in range(2):  # first they are made, then loaded
        running = [
            subprocess.Popen([sys.executable, "-c", ONE_OF_MANY, str(turn)], env=os.environ | folder)
            for turn in range(4)
        ]
        assert [process.wait(PATIENCE) for process in running] == [0] * 4


@pytest.mark.parametrize("carries", [False, True])
def test_a_cross_product_is_numpys_of_any_number_of_axes(carries):
    for left, right in (((NODES, SETS, 3), (SETS, 3)), ((SETS, 1, 3), (RUNS, SETS, NODES, 3)), ((SETS, 3), (SETS, 3))):
        one, other = _drawn(*left, carries=carries), _drawn(*right, carries=False)
        _alike(kernels.cross(one, other), np.cross(one, other))


def test_a_quaternion_turns_as_its_matrix_does():
    quaternion = _drawn(NODES, SETS, 4, carries=False)
    quaternion /= np.linalg.norm(quaternion, axis=-1, keepdims=True)
    expected = Rotation.from_quat(quaternion.reshape(-1, 4), scalar_first=True).as_matrix()
    matrix = kernels.matrix_of_quaternion(quaternion)
    np.testing.assert_allclose(matrix.reshape(-1, 3, 3), expected, atol=1e-15)
    up = _drawn(NODES, 1, 3, carries=False)
    _alike(kernels.turned_back(up, matrix), np.matvec(np.swapaxes(matrix, -1, -2), up))


def test_the_derivative_of_a_matrix_along_a_turning_quaternion_is_the_matrix_times_the_rate():
    quaternion, rate = _drawn(NODES, SETS, 4, carries=False), _drawn(NODES, SETS, 3, carries=False)
    turning = kernels.quaternion_rate(quaternion, rate)
    moved = kernels.matrix_of_quaternion(quaternion + STEP * turning).imag / STEP.imag
    _alike(moved, kernels.matrix_of_quaternion(quaternion) @ cross_matrix(rate))
    carried = kernels.quaternion_rate(quaternion + STEP * turning, rate).imag / STEP.imag
    _alike(carried, kernels.quaternion_rate(turning, rate))
