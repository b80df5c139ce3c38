"""Inertia and alignments from one record: exact sensitivities, recovered truth, and what stays open."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from support.synthetic_telemetry import (
    NOMINAL_THETA,
    TRUE_THETA,
    Flight,
    exact_telemetry,
    noisy,
    pyramid_cluster,
    sample_times,
    with_gimbals,
)
from testbed.cmg.cluster import cluster_momentum
from testbed.cmg.misalignment import misaligned
from testbed.errors import InputError
from testbed.estimation.alignment import estimated_alignments, relative_parameters
from testbed.estimation.alignment_model import Alignment, alignment_of, drive_at, held_momentum, sampled_gimbals
from testbed.estimation.alignment_observability import COMMON_SCALE, parameter_names
from testbed.estimation.estimate import EstimationSettings
from testbed.estimation.motion import simulate
from testbed.estimation.sensitivity import rate_sensitivity
from testbed.estimation.telemetry import Telemetry
from testbed.maneuver.splines import clamped_spline

DURATION = 5.0
NOISE = 0.001658
CLUSTER = pyramid_cluster()
SETTINGS = EstimationSettings(nominal_theta=NOMINAL_THETA)
ALL = np.ones(6, dtype=bool)
SCALE = np.repeat([0.022, 1.0], [6, 24])
rng = np.random.default_rng(11)
BUILT = Alignment(
    misalignment=rng.normal(0.0, 0.012, (6, 2)),
    encoder_zero=rng.normal(0.0, 0.012, 6),
    momentum_scale=rng.permutation([0.012, -0.007, 0.003, -0.011, 0.005, -0.002]),  # of mean zero, as the convention
)


class SplineGimbals:
    """Six gimbals along random splines, each for itself: null motion and all."""

    def __init__(self, points):
        self.spline = clamped_spline(DURATION, points)

    def angle(self, time):
        return self.spline(np.clip(time, 0.0, DURATION))

    def rate(self, time):
        return self.spline(np.clip(time, 0.0, DURATION), nu=1)


def restless(seed=2):
    points = np.random.default_rng(seed).uniform(-1.5, 1.5, (12, 6))
    points[:2], points[-1] = 0.0, points[-2]
    return SplineGimbals(points)


def record(gimbals, rate_hz=16.0) -> Telemetry:
    """What a platform out of alignment sends: it starts at rest, so that its units carry some momentum."""
    cluster = misaligned(CLUSTER, BUILT.misalignment)
    built = replace(cluster, rotor_momentum=CLUSTER.rotor_momentum * (1.0 + BUILT.momentum_scale))
    momentum_B = cluster_momentum(built, gimbals.angle(np.zeros(1))[0], np.zeros(6))
    flight = Flight(theta=TRUE_THETA, cluster=built, gimbals=gimbals, initial_momentum_B=momentum_B)
    sent = exact_telemetry(flight, sample_times(16.0), sample_times(rate_hz), NOISE)
    return with_gimbals(sent, cluster=CLUSTER, angle=sent.gimbals.angle + BUILT.encoder_zero)


@cache
def restless_record() -> Telemetry:
    return record(restless(), 400.0)  # Hz, so that encoders leave no error


@pytest.mark.parametrize("parameter", range(24))
def test_sensitivity_is_the_difference_quotient(parameter):
    telemetry, momentum_B = sampled_gimbals(restless_record()), np.array([0.003, -0.004, 0.006])

    def motion(parameters):
        return simulate(drive_at(telemetry, alignment_of(parameters)), TRUE_THETA, momentum_B)

    centre, step = BUILT.parameters, np.zeros(24)
    step[parameter] = 1e-5
    at = motion(centre)
    held = held_momentum(telemetry, BUILT, at)
    analytic = rate_sensitivity(drive_at(telemetry, BUILT), at, held)[..., 6 + parameter]
    quotient = (motion(centre + step).body_rate - motion(centre - step).body_rate) / 2e-5
    # The momentum moves along by Runge-Kutta in one and by its variational equation in the other: 4e-7.
    np.testing.assert_allclose(analytic, quotient, atol=2e-6 * np.abs(analytic).max())


def test_truth_is_recovered_without_noise():
    estimate = estimated_alignments(restless_record(), SETTINGS)
    truth = relative_parameters(TRUE_THETA, BUILT, ALL)
    # Of 0.022 kg·m² and of 0.01: what is left is the spline through encoders at 400 Hz and the search's own tolerance.
    np.testing.assert_allclose(estimate.parameters[:6], truth[:6], atol=1e-9)
    np.testing.assert_allclose(estimate.parameters[6:], truth[6:], atol=1e-7)
    assert estimate.residual_sigma < 1e-8  # rad/s


def test_relative_parameters_are_the_same_for_what_no_motion_tells_apart():
    scaled = replace(BUILT, momentum_scale=1.03 * (1.0 + BUILT.momentum_scale) - 1.0)
    first, second = relative_parameters(TRUE_THETA, BUILT, ALL), relative_parameters(1.03 * TRUE_THETA, scaled, ALL)
    np.testing.assert_allclose(first, second, atol=1e-15)
    assert first[-6:].mean() == pytest.approx(0.0, abs=1e-15)


def test_errors_are_as_large_as_claimed():
    truth = relative_parameters(TRUE_THETA, BUILT, ALL)
    sent = record(restless())
    squares = []
    for seed in range(8):
        estimate = estimated_alignments(noisy(sent, seed, 1e-4), SETTINGS)
        assert np.isfinite(estimate.std).all()
        whiten = np.linalg.pinv(estimate.covariance / np.outer(SCALE, SCALE), rcond=1e-9, hermitian=True)
        error = (estimate.parameters - truth) / SCALE
        squares.append(error @ whiten @ error / 29)
    # Chi-square with 8 × 29 degrees of freedom over as many: 1 ± 0.09, and 4 of these on either side.
    assert 0.63 < np.mean(squares) < 1.37


def test_only_a_common_scale_stays_open_with_null_motion():
    observability = estimated_alignments(record(restless()), SETTINGS).observability
    assert not observability.others
    assert observability.determined.all()
    assert observability.common_scale.name == COMMON_SCALE
    assert observability.common_scale.std > 0.2  # of J and of all momenta: nobody would call that known
    np.testing.assert_allclose(observability.common_scale.direction[6:24], 0.0)
    np.testing.assert_allclose(observability.basis.T @ observability.basis, np.eye(29), atol=1e-12)
    assert np.abs(observability.basis[-6:].sum(axis=0)).max() < 1e-12  # no step changes the mean momentum scale


def test_gimbals_in_step_leave_directions_open_and_say_which():
    """All six along one path but for small differences, which turn the body: hardly any null motion."""
    small = restless(3).spline.c * 0.12
    observability = estimated_alignments(record(SplineGimbals(small)), SETTINGS).observability
    assert observability.others
    named = " ".join(direction.name for direction in observability.others)
    assert "axis about t of cmg" in named
    assert not observability.determined.all()
    for direction in observability.others:
        assert np.abs(direction.direction @ observability.basis).max() < 1e-9  # nothing is moved along it


def test_a_failed_unit_shows_nothing_of_its_alignment():
    failed = replace(CLUSTER, rotor_momentum=CLUSTER.rotor_momentum * (np.arange(6) != 2))
    flight = Flight(theta=TRUE_THETA, cluster=failed, gimbals=restless(), initial_momentum_B=np.zeros(3))
    telemetry = exact_telemetry(flight, sample_times(16.0), sample_times(80.0), NOISE)
    estimate = estimated_alignments(telemetry, SETTINGS)
    open_ones = {name for name, std in zip(parameter_names(6), estimate.std, strict=True) if np.isnan(std)}
    assert {
        f"{kind} of cmg3" for kind in ("axis about s", "axis about t", "encoder zero", "momentum scale")
    } <= open_ones
    assert all(name.endswith("cmg3") for name in open_ones)
    np.testing.assert_allclose(estimate.parameters[6:], 0.0, atol=2e-4)  # it was built as drawn


def test_what_cannot_be_estimated_is_refused():
    with pytest.raises(InputError, match='initial_momentum = "estimated"'):
        estimated_alignments(replace(restless_record(), initial_momentum="zero"), SETTINGS)
    with pytest.raises(InputError, match="without gimbal angles"):
        sampled_gimbals(replace(restless_record(), gimbals=None))
