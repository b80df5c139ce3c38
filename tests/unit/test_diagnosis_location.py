"""Where the gap is: the axis, the stretch of time, and what it goes along with."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from support.diagnosed_records import NOISE, nominal, records
from testbed.diagnosis.fitting import fitted
from testbed.diagnosis.location import located
from testbed.diagnosis.reading import data_set_of
from testbed.dynamics.inertia import theta_of
from testbed.effects.gyro_latency import GyroLatency
from testbed.effects.viscous_drag import ViscousDrag


def places(used):
    scenario, platform = nominal()
    runs = data_set_of(used, scenario, platform).runs
    return located(runs, fitted(runs, [], theta_of(platform.inertia), []))


def test_noise_alone_is_nowhere():
    assert places(records(3)) == ()


@pytest.mark.parametrize(
    ("hooks", "values", "signal", "path"),
    [
        (GyroLatency().hooks("gyro"), [0.02], "body_acceleration", "reading"),
        (ViscousDrag().hooks("platform"), [1e-3, 1e-3, 1e-3], "body_rate_z", "torque"),
    ],
)
def test_an_effect_is_found_by_what_it_follows_and_by_how_it_enters(hooks, values, signal, path):
    found = places(records(3, hooks=[hooks], values=[np.array(values)]))
    assert found[0].depends_on.startswith(signal)
    assert found[0].enters_as == path
    assert [place.share for place in found] == sorted((place.share for place in found), reverse=True)


def test_a_disturbance_is_found_on_its_axis_and_in_its_time():
    first, *others = records(3)
    during = (first.time > 1.0) & (first.time < 1.5)
    rate = first.channels["body_rate"] + 8.0 * NOISE * np.outer(during, [0.0, 0.0, 1.0])
    (found, *_) = places([replace(first, channels={**first.channels, "body_rate": rate}), *others])
    assert (found.signal, found.run) == ("body_rate_z", "run1")
    assert 0.9 < found.from_s < 1.2  # 1.0 s, a sample more or less for noise, and the refitted rates that bend to it
    assert 1.3 < found.to_s < 1.6
