"""The e-value in linear Gaussian records: how often it ever passes 1/α without an effect, and how soon with one."""

from __future__ import annotations

from math import log

import numpy as np
import pytest

from testbed.diagnosis.settings import SETTINGS
from testbed.sequential.e_value import log_e_value

ALPHA = 0.05
STEPS = 20
SEQUENCES = 4000
SAMPLES = 24
TYPICAL = np.array([0.3, 0.3])


def designs(rng):
    """Return X and Z after every flight: three numbers that all share, two of each flight's own, an effect of two."""
    shared, effect = rng.normal(size=(2, STEPS * SAMPLES, 3))
    own = np.kron(np.eye(STEPS), np.ones((SAMPLES, 2))) * rng.normal(size=(STEPS * SAMPLES, 1))
    own[:, 1::2] = np.kron(np.eye(STEPS), np.ones((SAMPLES, 1)))
    for flights in range(1, STEPS + 1):
        rows = slice(0, flights * SAMPLES)
        yield np.hstack([shared[rows], own[rows, : 2 * flights]]), effect[rows, :2] + 0.5 * shared[rows, :2]


def paths(size, *, sequences=SEQUENCES, level=1.0, seed=90819):
    """Return the logarithm of the e-value after every flight of many campaigns, shape (sequences, steps).

    Args:
        size: of both parameters of the effect, or of each in every campaign, shape (2, sequences).
        sequences: number of campaigns.
        level: of the noise, 1 as stated.
        seed: of everything.
    """
    rng = np.random.default_rng(seed)
    noise = level * rng.normal(size=(STEPS * SAMPLES, sequences))
    unknown = 30.0 * rng.normal(size=(3 + 2 * STEPS, sequences))
    sizes = np.broadcast_to(size, (2, sequences))
    found = []
    for nuisance, effect in designs(rng):
        basis, _ = np.linalg.qr(nuisance)
        measured = nuisance @ unknown[: nuisance.shape[1]] + noise[: len(nuisance)] + effect @ sizes
        free, left = effect - basis @ (basis.T @ effect), measured - basis @ (basis.T @ measured)
        freedom = len(measured) - basis.shape[1]
        found.append(log_e_value(free.T @ free, left.T @ free, (left**2).sum(axis=0), freedom, TYPICAL))
    return np.stack(found, axis=1)


@pytest.mark.parametrize("level", [1.0, 1.3])
def test_without_an_effect_it_ever_passes_in_at_most_five_of_a_hundred_campaigns(level):
    """Whatever the inertia, the releases and the level of the noise, which is stated 30 % too small in one case."""
    ever = (paths(0.0, level=level).max(axis=1) >= log(1.0 / ALPHA)).mean()
    assert ever <= ALPHA


def test_its_mean_is_one_after_every_flight():
    """Without an effect rare campaigns carry the mean; with effects of the prior that of 1/E, also one, is plain."""
    rng = np.random.default_rng(5)
    drawn = (
        10.0 ** rng.normal(0.0, SETTINGS.size_decades, SEQUENCES) * TYPICAL[:, None] * rng.normal(size=(2, SEQUENCES))
    )
    values = np.exp(-paths(drawn))
    assert np.all(np.abs(values.mean(axis=0) - 1.0) < 4.0 * values.std(axis=0) / np.sqrt(SEQUENCES))


def test_an_effect_passes_and_a_larger_one_sooner():
    flights = {size: np.argmax(paths(size, sequences=200) >= log(1.0 / ALPHA), axis=1) + 1 for size in (0.2, 0.4)}
    passed = paths(0.2, sequences=200)[:, -1] >= log(1.0 / ALPHA)
    assert passed.mean() > 0.9
    assert np.median(flights[0.4]) < np.median(flights[0.2])


def test_it_does_not_depend_on_inertia_releases_and_level_of_the_noise():
    """What X explains and a common factor of all samples change nothing."""
    rng = np.random.default_rng(3)
    *_, (nuisance, effect) = designs(rng)
    basis, _ = np.linalg.qr(nuisance)
    measured = rng.normal(size=len(nuisance)) + effect @ [0.1, 0.2]

    def value(samples):
        free, left = effect - basis @ (basis.T @ effect), samples - basis @ (basis.T @ samples)
        return log_e_value(free.T @ free, left @ free, left @ left, len(samples) - basis.shape[1], TYPICAL)

    other = 3.0 * (measured + nuisance @ rng.normal(size=nuisance.shape[1]))
    assert value(other) == pytest.approx(value(measured), rel=1e-9)


def test_the_product_of_predictive_ratios_is_the_e_value_of_all_flights():
    """Of one flight after the other, each predicted from those before it, β and σ integrated: one size of the prior."""
    rng = np.random.default_rng(4)
    nuisance, effect = rng.normal(size=(40, 3)), rng.normal(size=(40, 1))
    measured = nuisance @ [1.0, -2.0, 0.5] + 0.4 * effect[:, 0] + rng.normal(size=40)

    def log_marginal(rows, spread):
        """Of rows of X, φ ~ N(0, σ² spread), flat in β and in log σ, up to what both models share."""
        covariance = np.eye(rows) + spread * effect[:rows] @ effect[:rows].T
        inverse, columns = np.linalg.inv(covariance), nuisance[:rows]
        normal = columns.T @ inverse @ columns
        projected = inverse - inverse @ columns @ np.linalg.solve(normal, columns.T @ inverse)
        square = measured[:rows] @ projected @ measured[:rows]
        return -0.5 * (np.linalg.slogdet(covariance)[1] + np.linalg.slogdet(normal)[1] + (rows - 3) * np.log(square))

    ratio = [log_marginal(rows, 0.09) - log_marginal(rows, 0.0) for rows in (10, 20, 30, 40)]
    steps = np.diff([0.0, *ratio])
    basis, _ = np.linalg.qr(nuisance)
    free, left = effect - basis @ (basis.T @ effect), measured - basis @ (basis.T @ measured)
    explained = (left @ free)[0] ** 2 / ((free.T @ free).item() + 1 / 0.09) / (left @ left)
    expected = -0.5 * np.log1p(0.09 * (free.T @ free).item()) - 0.5 * 37 * np.log1p(-explained)
    assert steps.sum() == pytest.approx(expected, rel=1e-9)
