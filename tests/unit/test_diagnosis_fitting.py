"""Steps within a trust region, and noise over windows side by side."""

from __future__ import annotations

import numpy as np
import pytest

from testbed.diagnosis.descent import _Around
from testbed.diagnosis.model import _normal_of_windows
from testbed.diagnosis.window_noise import WindowNoise
from testbed.estimation.torque_noise import covariance, torque_noise

NOISE = np.array([[0.01, 0.02, 0.3, 0.1, 0.2], [0.02, 0.01, 0.1, 0.05, 0.2], [0.005, 0.03, 0.0, 0.2, 0.1]])


def around(rng: np.random.Generator) -> _Around:
    columns = rng.normal(size=(40, 5)) * [1.0, 1e3, 1e-2, 5.0, 1.0]
    columns[:, 4] = columns[:, 0] + 1e-3 * columns[:, 4]  # nearly the same: a valley
    moving = np.array([True, True, True, False, True])
    return _Around(slope=columns.T @ rng.normal(size=40), normal=columns.T @ columns, moving=moving, ways=None)


@pytest.mark.parametrize("share", [0.7, 0.1, 1e-3])
def test_a_step_is_as_long_as_it_may_be(share):
    near = around(np.random.default_rng(1))
    damping, whole = near.step_within(np.inf)
    assert damping == 1e-6
    more, step = near.step_within(share * near.length(whole))
    assert more > damping
    assert near.length(step) == pytest.approx(share * near.length(whole), rel=0.25)
    assert step[3] == whole[3] == 0.0
    assert near.slope @ step > 0.0


def test_a_step_that_may_be_longer_than_it_is_is_not_damped():
    near = around(np.random.default_rng(2))
    _, whole = near.step_within(np.inf)
    damping, step = near.step_within(1.01 * near.length(whole))
    assert damping == 1e-6
    np.testing.assert_array_equal(step, whole)


def test_a_normal_matrix_in_parts_is_the_whole_one():
    rng = np.random.default_rng(3)
    jacobian = np.zeros((2000, 160))
    jacobian[:, :10] = rng.normal(size=(2000, 10))
    for window in range(50):
        jacobian[40 * window : 40 * window + 40, 10 + 3 * window : 13 + 3 * window] = rng.normal(size=(40, 3))
    np.testing.assert_allclose(_normal_of_windows(jacobian), jacobian.T @ jacobian, atol=1e-10)


def windows() -> list[np.ndarray]:
    rng = np.random.default_rng(4)
    return [5.0 + np.cumsum(rng.uniform(0.009, 0.011, size)) for size in (20, 17, 20, 20, 17)]


def test_windows_side_by_side_are_whitened_as_each_by_itself():
    times, rng = windows(), np.random.default_rng(5)
    noise = WindowNoise(times, NOISE)
    blocks = [rng.normal(size=(len(time), 3, 2)) for time in times]
    for time, block, white in zip(times, blocks, noise.whitened(blocks), strict=True):
        for axis, of_axis in enumerate(covariance(time, NOISE)):
            own = np.linalg.solve(np.linalg.cholesky(of_axis), block[:, axis])
            np.testing.assert_allclose(white[:, axis], own, rtol=1e-9)
    samples = [block[..., 0] for block in blocks]
    for sample, again in zip(samples, noise.colored(noise.whitened(samples)), strict=True):
        np.testing.assert_allclose(again, sample, atol=1e-12)


def test_the_deviance_is_of_the_samples_with_a_free_initial_rate():
    times = windows()
    for time, deviance in zip(times, WindowNoise(times, NOISE).deviance, strict=True):
        for of_axis, one in zip(covariance(time, NOISE), deviance, strict=True):
            constant = np.ones(len(time)) @ np.linalg.solve(of_axis, np.ones(len(time)))
            assert one == pytest.approx(np.linalg.slogdet(of_axis)[1] + np.log(constant))


def test_noise_that_is_searched_for_from_where_it_was_makes_samples_as_probable():
    rng, time = np.random.default_rng(6), np.arange(20) * 0.01
    factors = np.linalg.cholesky(covariance(time, NOISE))
    residuals = [np.einsum("anm,ma->na", factors, rng.normal(size=(20, 3))) for _ in range(80)]
    residuals = [residual - residual[:1] for residual in residuals]  # the initial rate is free

    def deviance(noise: np.ndarray) -> float:
        contrasts = np.linalg.svd(np.ones((1, 20)))[2][1:]
        total = 0.0
        for axis, whole in enumerate(covariance(time, noise)):
            of_axis = contrasts @ whole @ contrasts.T
            samples = np.array([contrasts @ residual[:, axis] for residual in residuals])
            total += 80 * np.linalg.slogdet(of_axis)[1] + np.sum(samples.T * np.linalg.solve(of_axis, samples.T))
        return float(total)

    found = torque_noise([time] * 80, residuals)
    of_others = torque_noise([time] * 80, [1.3 * residual for residual in residuals])
    again = torque_noise([time] * 80, residuals, begun=of_others)
    assert deviance(again) == pytest.approx(deviance(found), abs=0.1)
    assert deviance(of_others) > deviance(found) + 10.0
