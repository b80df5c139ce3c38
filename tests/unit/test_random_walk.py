"""The likelihood of unmeasured increments is that of the whole covariance, whatever runs share."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import block_diag
from scipy.stats import multivariate_normal

from testbed.estimation.random_walk import Increments, likeliest_variance

RUNS, SAMPLES, COUNT, SHARED = 3, 40, 12, 4


def _problem(variance):
    """Runs of their own, of which what they share is projected out."""
    rng = np.random.default_rng(7)
    response = block_diag(*(rng.standard_normal((SAMPLES, COUNT)) for _ in range(RUNS)))
    shared = np.linalg.qr(rng.standard_normal((RUNS * SAMPLES, SHARED)))[0]
    torque = np.sqrt(variance) * rng.standard_normal(RUNS * COUNT)
    residual = response @ torque + rng.standard_normal(RUNS * SAMPLES)
    free = response - shared @ (shared.T @ response)
    residual -= shared @ (shared.T @ residual)
    return response, shared, free, residual


def _increments(response, shared, free, residual):
    power, along = np.linalg.eigh(response.T @ response)
    return along, Increments(power=power, slope=along.T @ (free.T @ residual), across=along.T @ (response.T @ shared))


@pytest.mark.parametrize("variance", [1e-3, 0.3, 20.0])
def test_what_runs_share_is_taken_out_of_all_of_them_together(variance):
    response, shared, free, residual = _problem(0.3)
    along, increments = _increments(response, shared, free, residual)
    normal = free.T @ free
    expected = np.linalg.solve(np.eye(len(normal)) + variance * normal, free.T @ residual)
    np.testing.assert_allclose(along @ increments.solved(variance), expected, rtol=1e-9, atol=1e-9)
    assert increments.explained(variance) == pytest.approx(variance * (free.T @ residual) @ expected, rel=1e-9)
    assert increments.widened(variance) == pytest.approx(
        np.linalg.slogdet(np.eye(len(normal)) + variance * normal)[1], rel=1e-9
    )
    power = np.linalg.eigvalsh(normal)
    assert increments.count(variance) == pytest.approx((variance * power / (1.0 + variance * power)).sum(), rel=1e-9)


def test_the_ratio_is_that_of_the_densities_of_all_samples():
    """Of the samples that the model leaves free, in a basis of their own."""
    response, shared, free, residual = _problem(0.3)
    variance, ratio = likeliest_variance(_increments(response, shared, free, residual)[1])
    left = np.linalg.qr(shared, mode="complete")[0][:, SHARED:]
    seen, through = left.T @ residual, left.T @ free
    dense = np.eye(len(seen)) + variance * through @ through.T
    expected = multivariate_normal.logpdf(seen, cov=dense) - multivariate_normal.logpdf(seen, cov=np.eye(len(seen)))
    assert 0.1 < variance < 1.0
    assert ratio == pytest.approx(2.0 * expected, rel=1e-9)
