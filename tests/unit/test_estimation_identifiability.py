"""What a run cannot tell is refused by every estimator, and named."""

from dataclasses import replace

import numpy as np
import pytest

from support.synthetic_telemetry import (
    NOMINAL_THETA,
    TRUE_THETA,
    exact_telemetry,
    noisy,
    nominal_flight,
    sample_times,
)
from testbed.dynamics.inertia import momentum_regressor
from testbed.errors import InputError, UnidentifiableError
from testbed.estimation.estimate import EstimationSettings
from testbed.estimation.identifiability import require_identifiable
from testbed.estimation.registry import ESTIMATORS

SETTINGS = EstimationSettings(nominal_theta=NOMINAL_THETA)
TIMES = sample_times(16.0)


def flown_with(modes, noise, seed, momentum_B=None, times=TIMES):
    """The nominal motion with some of its three modes (about x, y, z) left out."""
    flight = nominal_flight(momentum_B)
    gimbals = replace(flight.gimbals, amplitude=flight.gimbals.amplitude * np.array(modes))
    exact = exact_telemetry(replace(flight, gimbals=gimbals), times, times, noise)
    return noisy(exact, seed, 1e-4)


@pytest.mark.parametrize("noise", [0.025, 0.001658])
@pytest.mark.parametrize("name", ESTIMATORS)
def test_a_turn_about_one_axis(name, noise):
    message = r"^J11, J22, J12 cannot be determined: the body hardly turns but about the axis \[.*, 1\]"
    with pytest.raises(UnidentifiableError, match=message):
        ESTIMATORS[name](flown_with([0, 0, 1], noise, 0), SETTINGS)


@pytest.mark.parametrize("name", ESTIMATORS)
def test_a_turn_in_a_plane(name):
    message = r"^J33 cannot be determined: the body hardly turns about the axis \[.*, 1\]"
    with pytest.raises(UnidentifiableError, match=message):
        ESTIMATORS[name](flown_with([1, 1, 0], 0.001658, 0), SETTINGS)


@pytest.mark.parametrize("name", ESTIMATORS)
def test_no_turn_at_all(name):
    with pytest.raises(UnidentifiableError, match=r"J12 cannot be determined: its body rate, 0.0024 rad/s"):
        ESTIMATORS[name](flown_with([0, 0, 0], 0.025, 0), SETTINGS)


def test_noise_above_the_motion_is_named_as_such():
    with pytest.raises(UnidentifiableError, match=r"drowns in the gyro's noise of 5 rad/s per sample"):
        ESTIMATORS["iv"](flown_with([1, 1, 1], 5.0, 0), SETTINGS)


@pytest.mark.parametrize("name", ESTIMATORS)
def test_a_gyro_axis_that_reads_zero_determines_nothing(name):
    """Its columns are zero: the regressions were singular, and output error answered 1.9 kg·m² for J33."""
    flown = flown_with([1, 1, 1], 0.001658, 0)
    dead = replace(flown, body_rate=flown.body_rate * [1.0, 1.0, 0.0])
    with pytest.raises(
        UnidentifiableError, match="cannot be determined: the gyro reads exactly zero throughout about z"
    ):
        ESTIMATORS[name](dead, SETTINGS)


def test_output_error_finds_no_minimum_with_a_flipped_gyro():
    flown = flown_with([1, 1, 1], 0.001658, 0)
    with pytest.raises(InputError, match="output error found no minimum"):
        ESTIMATORS["output_error"](replace(flown, body_rate=-flown.body_rate), SETTINGS)


@pytest.mark.parametrize("name", ESTIMATORS)
def test_a_spin_without_actuators_leaves_the_scale_open(name):
    spin = flown_with([0, 0, 0], 0.0001, 0, momentum_B=np.array([0.006, -0.008, 0.012]))
    still = replace(spin, gimbals=None)
    with pytest.raises(UnidentifiableError, match=r"J11 .* J22 .* J33.*initial momentum"):
        ESTIMATORS[name](still, SETTINGS)


@pytest.mark.parametrize("name", ["iv", "iv_momentum"])
def test_an_instrument_that_does_not_turn_about_an_axis(name):
    flight = nominal_flight()
    settings = replace(
        SETTINGS, instrument="reference", reference_rate=lambda time: flight.body_rate(time) * np.array([1.0, 1.0, 0.0])
    )
    with pytest.raises(UnidentifiableError, match=r"^J33 cannot"):
        ESTIMATORS[name](flown_with([1, 1, 1], 0.025, 0), settings)


def test_a_combination_is_named_with_its_weights():
    rate = np.outer(np.sin(TIMES), [1.0, 2.0, 0.0])
    regressor = momentum_regressor(rate).reshape(-1, 6)
    with pytest.raises(UnidentifiableError) as caught:
        require_identifiable(regressor, 0.0, TRUE_THETA[:3].mean(), rate)
    text = str(caught.value)
    assert text.startswith("J11 + 0.25 J22 - 0.5 J12, J33, 0.5 J23 - J13 cannot be determined")  # ΔJ ω = 0, by hand
    assert "but about the axis [0.45, 0.89, 0]" in text


def test_a_motion_that_drowns_in_noise():
    with pytest.raises(UnidentifiableError, match="too weak, or too short, for the gyro's noise"):
        ESTIMATORS["output_error"](flown_with([1, 1, 1], 0.025, 0, times=sample_times(16.0, 1.0, 2.0)), SETTINGS)


def test_a_weak_but_honest_excitation_is_accepted():
    weak = flown_with([0.15, 0.15, 0.15], 0.001658, 0)
    estimate = ESTIMATORS["output_error"](weak, SETTINGS)
    assert (np.abs(estimate.theta - TRUE_THETA) < 4.0 * estimate.std).all()
