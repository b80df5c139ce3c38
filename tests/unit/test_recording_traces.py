from dataclasses import replace

import numpy as np
import pytest

from support.flights import content, flown
from testbed.recording.traces import flight_traces

SAMPLES = 11


@pytest.fixture(scope="module")
def flight():
    return flown(SAMPLES)


@pytest.fixture(scope="module")
def traces(flight):
    return {trace.path: trace for trace in flight_traces(flight.time, flight.channels, content(SAMPLES))}


def test_the_gyro_keeps_its_own_samples_only(flight, traces):
    gyro = traces["body_rate/body_rate"]
    assert gyro.style == "points"
    np.testing.assert_array_equal(gyro.time, flight.time[::5])
    np.testing.assert_array_equal(gyro.values, flight.channels["body_rate"][::5])


def test_tracking_error_is_true_minus_reference(traces):
    np.testing.assert_allclose(traces["tracking_error/true_minus_reference"].values, -1e-3, rtol=1e-9)


def test_limits_run_from_end_to_end_on_both_sides(flight, traces):
    limit = traces["gimbal_rate/limit"]
    np.testing.assert_array_equal(limit.time, flight.time[[0, -1]])
    np.testing.assert_array_equal(limit.values, [[2.0, -2.0]] * 2)
    expected = [0.021, 0.021, 0.0254, -0.021, -0.021, -0.0254]
    np.testing.assert_array_equal(traces["cluster_momentum/limit"].values, [expected] * 2)


def test_units_and_axes_keep_their_names_and_the_rest_shares_one(traces):
    assert traces["gimbal_rate/true_gimbal_rate"].names == ("cmg1", "cmg2", "cmg3", "cmg4", "cmg5", "cmg6")
    assert traces["body_rate/true_body_rate"].names == ("x", "y", "z")
    assert traces["body_rate/reference_body_rate"].names == ("reference",) * 3
    assert traces["singularity_measure/singularity_measure"].names == ("singularity measure",)


def test_a_measured_flight_shows_what_it_has(flight):
    measured = {name: flight.channels[name] for name in ("body_rate", "gimbal_torque")}
    measured["gimbal_angle"] = flight.channels["true_gimbal_angle"]
    bare = replace(content(SAMPLES), envelope_fraction=None, residuals=())
    paths = {trace.path for trace in flight_traces(flight.time, measured, bare)}
    assert paths == {
        "body_rate/body_rate",
        "gimbal_angle/gimbal_angle",
        "gimbal_torque/gimbal_torque",
        "gimbal_torque/limit",
    }
