"""A late or slow gyro in logs that begin at a release, and in logs that begin in the middle of a motion."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from support.diagnosed_records import nominal, records
from testbed.diagnosis.fitting import fitted
from testbed.diagnosis.model import Hypothesis
from testbed.diagnosis.reading import data_set_of
from testbed.dynamics.inertia import theta_of
from testbed.effects.registry import EFFECTS

DELAY = 0.05


def without_begin(record, seconds):
    """The record as if the logger had been switched on later."""
    kept = record.time >= seconds
    channels = {name: values[kept] for name, values in record.channels.items()}
    return replace(record, time=record.time[kept] - seconds, channels=channels)


@pytest.fixture(scope="module")
def flown():
    return records(4, seconds=6.0, hooks=[EFFECTS["gyro_latency"].hooks("gyro")], values=[np.array([DELAY])])


@pytest.mark.parametrize("later", [0.0, 2.0])
def test_what_the_gyro_shows_of_the_time_before_the_log_speaks_for_no_other_effect(flown, later):
    """Held where the log begins at a release; where it does not, that missed 23 sigma, and late telemetry was named."""
    scenario, platform = nominal()
    runs = data_set_of([without_begin(each, later) for each in flown], scenario, platform).runs
    late = Hypothesis(effect=EFFECTS["gyro_latency"], component="gyro")
    fit = fitted(runs, [late], theta_of(platform.inertia), [np.array([0.01])])
    (delay,) = fit.values.effects[0].ravel()
    print(f"{delay * 1e3:.2f} ms, χ² {fit.chi_square / fit.freedom:.3f}")
    assert delay == pytest.approx(DELAY, abs=0.002)
    assert fit.chi_square < 1.2 * fit.freedom


@pytest.fixture(scope="module")
def slowed():
    slow = EFFECTS["gyro_bandwidth"].hooks("gyro")
    return records(4, seconds=6.0, hooks=[slow], values=[np.array([0.02])])


@pytest.mark.parametrize("spikes", [0, 1, 3])
def test_what_runs_show_as_they_start_is_no_spike(slowed, spikes):
    """Behind a low-pass of 8 Hz, four first samples were left out as spikes, and five effects were named for the rest.

    One run's is chance, and goes.
    """
    scenario, platform = nominal()
    disturbed = [spiked(each, at < spikes) for at, each in enumerate(slowed)]
    runs = data_set_of(disturbed, scenario, platform).runs
    gone = [len(record.time) - len(run.gyro_time) for record, run in zip(disturbed, runs.grid.runs, strict=False)]
    assert sum(gone) == (1 if spikes == 1 else 0)


def spiked(record, really):
    rate = record.channels["body_rate"].copy()
    rate[0] += 40.0 * record.details.gyro_noise * really
    return replace(record, channels=record.channels | {"body_rate": rate})
