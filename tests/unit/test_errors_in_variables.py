"""Noise of encoders stands in the prediction: it is smoothed where that helps, and gives no effect a name."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from support.diagnosed_records import NOISE, nominal, records
from testbed.diagnosis import tachometers
from testbed.diagnosis.errors_in_variables import taken_out
from testbed.diagnosis.fitting import fitted
from testbed.diagnosis.method import diagnosed
from testbed.diagnosis.model import Hypothesis
from testbed.diagnosis.reading import data_set_of
from testbed.dynamics.inertia import theta_of
from testbed.effects.registry import EFFECTS, NOISE_EFFECTS

ENCODER = 3e-3
"""rad; it adds a tenth of the gyro's variance to the prediction's error, and more."""
SLOW = [
    Hypothesis(effect=EFFECTS["telemetry_skew"], component="actuators"),
    Hypothesis(effect=EFFECTS["gyro_bandwidth"], component="gyro"),
]
"""Together a filter without a delay, which takes fast noise out of a prediction and leaves the motion."""


def with_noisy_encoders(recorded, noise, seed=1):
    rng = np.random.default_rng(seed)
    return [
        replace(
            each,
            channels=each.channels
            | {"gimbal_angle": each.channels["gimbal_angle"] + noise * rng.standard_normal((len(each.time), 6))},
            details=replace(each.details, gyro_noise=NOISE),
        )
        for each in recorded
    ]


def data_of(recorded):
    return data_set_of(recorded, *nominal())


@pytest.fixture
def as_sent(monkeypatch):
    """Leave gimbal angles as the encoders gave them."""
    monkeypatch.setattr(tachometers, "smoothed_gimbals", lambda _: iter(()))


@pytest.mark.usefixtures("as_sent")
@pytest.mark.parametrize("seed", range(3))
def test_what_a_filter_gains_of_encoders_noise_is_what_it_takes_out(seed):
    """The gyro has no noise here: all that a filter explains is the encoders'."""
    theta = theta_of(nominal()[1].inertia)
    runs = data_of(with_noisy_encoders(records(4, seconds=10.0, noise=1e-9), 1e-3, seed)).runs
    without = fitted(runs, [], theta, [])
    slow = fitted(runs, SLOW, theta, [np.array([0.02]), np.array([0.03])])
    gained, taken = without.deviance - slow.deviance, taken_out(runs, without, slow)
    assert 1.0 < gained < taken < 3.0 * gained


def test_exact_encoders_hold_nothing_to_take_out():
    theta = theta_of(nominal()[1].inertia)
    runs = data_of(records(2)).runs
    without = fitted(runs, [], theta, [])
    slow = replace(without, noise_deviance=-5.0)  # whatever it gains
    assert taken_out(runs, without, slow) == 0.0


def test_noisy_angles_are_smoothed_and_exact_ones_stay():
    noisy = data_of(with_noisy_encoders(records(4, seconds=10.0), ENCODER)).runs.grid.runs[0].gimbals
    exact = data_of(records(4, seconds=10.0)).runs.grid.runs[0].gimbals
    assert 0.5 * ENCODER < noisy.angle_noise < 1.5 * ENCODER
    assert np.std(noisy.angle - exact.angle) < 0.95 * ENCODER  # some gimbals of a few swings show no noise for sure
    assert (exact.angle_noise, exact.angle_variance) == (0.0, None)


def test_encoders_noise_is_no_colour_of_the_gyro_and_no_effect():
    """A gyro twice as fast as the encoders: an error of one of these stands in two of its samples."""
    fast = with_noisy_encoders(records(5, seconds=12.0, seed=4), ENCODER)
    slow_encoders = []
    for each in fast:
        angle = each.channels["gimbal_angle"].copy()
        angle[1::2] = np.nan
        slow_encoders.append(replace(each, channels=each.channels | {"gimbal_angle": angle}))
    data = data_of(slow_encoders)
    few = (
        "gyro_latency",
        "gyro_bandwidth",
        "gyro_scale",
        "gimbal_zero",
        "rotor_speed",
        "telemetry_skew",
        "body_torque",
    )
    effects = {name: EFFECTS[name] for name in few}
    *_, final = diagnosed(data.runs, data.heldout, effects, theta_of(nominal()[1].inertia), noise_effects=NOISE_EFFECTS)
    assert final.verdict == "none"
