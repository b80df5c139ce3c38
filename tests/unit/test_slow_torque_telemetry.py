"""Torques of gimbals' motors that are sent less often than the gimbals' angles are compared where they were sampled."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import testbed as tb
from testbed.assembly.platform import nominal_body
from testbed.assembly.telemetry import telemetry_of
from testbed.diagnosis.channels import too_exact_torques, torque_channel
from testbed.prediction.grid import grid_of

NOISE = 4e-4
"""N·m, of a motor's torque."""


@pytest.fixture(scope="module")
def flown():
    scenario = tb.read_scenario("basic", {"torque_sensor.noise_N_m": NOISE})
    return scenario, tb.fly(scenario, seed=8117).record


def thinned(record, every):
    torque = np.full_like(record.channels["gimbal_torque"], np.nan)
    torque[::every] = record.channels["gimbal_torque"][::every]
    return replace(record, channels=record.channels | {"gimbal_torque": torque})


@pytest.mark.parametrize("every", [1, 5, 10])
def test_their_noise_is_that_of_what_was_sampled(flown, every):
    """On lines between samples at 5 Hz, torques with noise had none: a friction in the gimbals was not looked for."""
    scenario, record = flown
    telemetry = telemetry_of(thinned(record, every), scenario, nominal_body(scenario))
    grid = grid_of([telemetry])
    assert not too_exact_torques(grid)
    channel = torque_channel(grid)
    sampled = np.isfinite(telemetry.gimbals.torque).all(axis=1)
    assert 0.8 * len(sampled) / every < len(channel.measured[0]) <= sampled.sum()
    (noise, *_) = channel.noise
    assert np.all(noise.sigma > 0.5 * NOISE)
