"""What held-out runs say of a model, and torques of no effect by their shape."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import block_diag
from scipy.stats import chi2

from support.diagnosed_records import nominal, records
from support.unlisted_torques import Growing, Humming, Pulsing
from testbed.diagnosis.fitting import fitted
from testbed.diagnosis.latent import goodness, on_all_runs
from testbed.diagnosis.misfit import log_evidence
from testbed.diagnosis.model import Hypothesis, orthonormal, projected_out
from testbed.diagnosis.reading import data_set_of
from testbed.diagnosis.torque_shapes import (
    TorqueShape,
    _normals,
    _Tried,
    evidence_of_any,
    no_better_than_together,
    torque_shapes,
)
from testbed.diagnosis.torque_space import torque_responses, torque_space
from testbed.dynamics.inertia import theta_of
from testbed.effects.registry import EFFECTS
from testbed.estimation.random_walk import Increments, likeliest_variance

DRAG = Hypothesis(effect=EFFECTS["viscous_drag"], component="platform")
LATENCY = Hypothesis(effect=EFFECTS["gyro_latency"], component="gyro")


def baseline(used, placed=()):
    scenario, platform = nominal()
    data = data_set_of(used, scenario, platform)
    fit = fitted(data.runs, placed, theta_of(platform.inertia), [np.zeros(each.size) for each in placed])
    return data, fit


def carried(used):
    data, without = baseline(used)
    _, with_latency = baseline(used, [LATENCY])
    return log_evidence(data.heldout, with_latency) - log_evidence(data.heldout, without)


def test_an_effect_that_is_there_carries_over_to_held_out_runs():
    assert carried(records(3, hooks=[LATENCY.hooks], values=[np.array([6e-3])])) > 10.0


def test_an_effect_that_is_not_there_does_not_carry_over():
    gained = [carried(records(3, seed=seed)) for seed in range(12)]
    assert np.mean(np.exp(0.5 * np.array(gained))) < 3.0  # its expectation is 1: so it is a p-value's divisor
    assert np.median(gained) < 0.5


def test_an_estimate_at_its_bound_is_known_only_as_well_as_its_runs_say():
    """A drag about one axis is fitted at nothing; the run that is held out shows it, and had spoken against drag."""
    used = records(2, hooks=[DRAG.hooks], values=[np.array([6e-4, 1.5e-4, 6e-4])], seed=24, seconds=1.5)
    (data, dragged), (_, without) = baseline(used, [DRAG]), baseline(used)
    assert dragged.at_bound.tolist() == [False, False, True]
    assert log_evidence(data.heldout, dragged) > log_evidence(data.heldout, without)


def test_without_held_out_runs_nothing_is_said():
    data, fit = baseline(records(1))
    assert log_evidence(data.heldout, fit) == 0.0


@pytest.mark.parametrize(
    ("hook", "size", "words", "frequency"),
    [
        (Growing(), 4e-5, "grows in proportion", None),
        (Humming(1.3), 4e-4, "oscillates at", 1.3),
        (Pulsing(), 4e-3, "comes in a pulse every 0.8", 1.25),
    ],
)
def test_an_unmodelled_torque_is_described_by_its_shape(hook, size, words, frequency):
    data, fit = baseline(records(3, hooks=[hook], values=[np.array([size])]))
    best = torque_shapes(*on_all_runs(data.runs, data.heldout, fit))[0]
    assert words in best.words
    assert best.p_value < 1e-6
    assert frequency is None or best.frequency_hz == pytest.approx(frequency, abs=0.1)


def test_noise_has_no_shape_and_suits_the_model():
    data, fit = baseline(records(3))
    everything, on_all = on_all_runs(data.runs, data.heldout, fit)
    shapes = torque_shapes(everything, on_all)
    assert evidence_of_any(shapes, tested=60, prior_odds=1.0) < 0.0
    assert min(shape.p_value for shape in shapes) > 0.05
    assert goodness(on_all, everything.noise_freedom) > 0.01


def shape(kind, evidence):
    return TorqueShape(kind=kind, words="", evidence=evidence, reduction=evidence, p_value=1.0)


def test_a_torque_alone_explains_no_more_than_with_the_effects_beside_it():
    seems, small = (replace(shape("pulses", each), phase=at) for at, each in enumerate((1000.0, 90.0)))
    beside = [replace(seems, reduction=7.0), replace(small, reduction=2.0)]
    bounded = no_better_than_together([seems, small], beside[::-1], by_effects=950.0)
    assert [each.evidence for each in bounded] == [957.0, 90.0]


def test_a_kind_of_many_shapes_is_no_likelier_beforehand_than_one_of_few():
    alone = [shape("growing", 20.0)]
    alike = [*alone, *(shape("pulses", 20.0) for _ in range(100))]
    one_of_many = [*alone, shape("pulses", 30.0), *(shape("pulses", 0.0) for _ in range(99))]
    assert evidence_of_any(alone, tested=60, prior_odds=1.0) == pytest.approx(20.0 - 2.0 * np.log(60))
    assert evidence_of_any(alike, tested=60, prior_odds=1.0) == pytest.approx(20.0 + 2.0 * np.log(2 / 60))
    either = np.exp(10.0) + np.exp(15.0) / 100.0
    assert evidence_of_any(one_of_many, 60, prior_odds=1.0) == pytest.approx(2.0 * np.log(either / 60), abs=1e-3)


def test_unmodelled_torques_are_as_probable_a_priori_as_their_odds_say():
    alone = [shape("growing", 20.0)]
    assert evidence_of_any(alone, tested=60, prior_odds=3.0) == pytest.approx(20.0 - 2.0 * np.log(20.0))


@pytest.mark.parametrize(("known", "most"), [(20.0, 0.03), (np.inf, 1.0)])
def test_noise_of_another_level_than_is_known_is_rarely_a_torque(known, most):
    """Taken for known, noise that is known with 20 degrees of freedom makes a torque at p < 0.01 in a fifth of sets."""
    rng = np.random.default_rng(0)
    power, found = 1e4 * 0.97 ** np.arange(480), 0
    for _ in range(SETS_OF_NOISE):
        level = 20.0 / rng.chisquare(20.0)
        ratio = likeliest_variance(
            Increments.independent(power, np.sqrt(level * power) * rng.standard_normal(len(power))), known
        )[1]
        found += ratio > chi2.isf(0.02, 1)
    assert found <= most * SETS_OF_NOISE
    assert np.isfinite(known) or found > 0.1 * SETS_OF_NOISE


SETS_OF_NOISE = 200


@pytest.mark.parametrize("known", [20.0, np.inf])
def test_a_torque_stands_out_of_noise_however_well_that_is_known(known):
    power = 1e4 * 0.97 ** np.arange(480)
    values = np.sqrt(1.0 + 3e-3 * power) * np.random.default_rng(1).standard_normal(len(power))
    assert likeliest_variance(Increments.independent(power, np.sqrt(power) * values), known)[1] > 30.0


def silent(record):
    """Return a record whose gyro has lost a second and a half: a window of knots has no samples."""
    lost = (record.time > 2.0) & (record.time < 3.5)
    rate = np.where(lost[:, None], np.nan, record.channels["body_rate"])
    return replace(record, channels={**record.channels, "body_rate": rate})


@pytest.mark.parametrize(("knots", "as_read"), [(20, replace), (150, replace), (150, silent)])
def test_what_torques_can_do_is_the_same_in_parts_as_in_one_matrix(knots, as_read):
    """Lengths and angles of the responses, and what of the residual lies among them: run by run, and by windows."""
    data, fit = baseline([as_read(record) for record in records(3)])
    runs, fit = on_all_runs(data.runs, data.heldout, fit)
    space = torque_space(runs, fit, knots)
    nuisance = orthonormal(fit.jacobian[: runs.samples])
    whole = projected_out(block_diag(*torque_responses(runs, fit, knots)), nuisance)
    torques = np.random.default_rng(3).standard_normal((len(runs.names), knots, 2))
    shape = _Tried(kind="growing", words="", torques=torques)
    by_run = replace(shape, kind="oscillation of every run's own", by_run=True)
    for (alone,), (information,), (found,) in _normals([shape, by_run], space):
        apart = [block_diag(*torques)] if alone.by_run else [torques.reshape(-1, 2)]
        hats = np.concatenate([np.kron(each, np.eye(3)[:, axis : axis + 1]) for axis in range(3) for each in apart], 1)
        if alone.by_run:  # amplitudes run by run, axis by axis in each
            hats = hats.reshape(len(hats), 3, len(torques), 2).swapaxes(1, 2).reshape(len(hats), -1)
        direct = whole @ hats
        most = np.abs(direct).max() ** 2
        np.testing.assert_allclose(information, direct.T @ direct, rtol=1e-7, atol=1e-7 * most)
        slope = direct.T @ fit.residual[: runs.samples]
        np.testing.assert_allclose(found, slope, rtol=1e-7, atol=1e-7 * np.abs(slope).max())
