"""Symmetries that no estimator may break: axes, units and clock are the observer's choice."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from support.synthetic_telemetry import (
    NOMINAL_THETA,
    exact_telemetry,
    noisy,
    nominal_flight,
    sample_times,
    with_gimbals,
)
from testbed.dynamics.inertia import inertia_of, theta_of
from testbed.estimation.estimate import EstimationSettings
from testbed.estimation.registry import ESTIMATORS
from testbed.rotation.quaternion import exponential, matrix_of

TIMES = sample_times(16.0)
TELEMETRY = noisy(exact_telemetry(nominal_flight(np.array([0.003, -0.004, 0.006])), TIMES, TIMES, 0.025), 5, 1e-4)
SETTINGS = EstimationSettings(nominal_theta=NOMINAL_THETA)
ESTIMATES = {name: estimator(TELEMETRY, SETTINGS) for name, estimator in ESTIMATORS.items()}
SEARCH_TOLERANCE = 1e-7
"""kg·m²; output error ends when a step changes its cost by 1e-8, far below a standard deviation of 2e-4."""

components = st.floats(-2.0, 2.0)
few = settings(max_examples=5, deadline=None, derandomize=True)


def turned(theta, matrix):
    return theta_of(matrix @ inertia_of(theta) @ matrix.T)


@pytest.mark.parametrize("name", ESTIMATORS)
@given(rotation_vector=st.tuples(components, components, components))
@few
def test_other_body_axes_give_the_same_body(name, rotation_vector):
    matrix = matrix_of(exponential(np.array(rotation_vector)))
    cluster = TELEMETRY.gimbals.cluster
    turned_axes = {"gimbal_axis_B": cluster.gimbal_axis_B @ matrix.T, "spin_axis_B": cluster.spin_axis_B @ matrix.T}
    telemetry = replace(
        with_gimbals(TELEMETRY, cluster=replace(cluster, **turned_axes)), body_rate=TELEMETRY.body_rate @ matrix.T
    )
    estimate = ESTIMATORS[name](telemetry, replace(SETTINGS, nominal_theta=turned(NOMINAL_THETA, matrix)))
    np.testing.assert_allclose(estimate.theta, turned(ESTIMATES[name].theta, matrix), atol=SEARCH_TOLERANCE)


@pytest.mark.parametrize("name", ESTIMATORS)
@given(factor=st.floats(0.1, 10.0))
@few
def test_momentum_and_inertia_enter_homogeneously(name, factor):
    cluster = TELEMETRY.gimbals.cluster
    telemetry = with_gimbals(
        TELEMETRY,
        cluster=replace(
            cluster,
            rotor_momentum=factor * cluster.rotor_momentum,
            rotor_spin_inertia=factor * cluster.rotor_spin_inertia,
            rotor_transverse_inertia=factor * cluster.rotor_transverse_inertia,
            gimbal_inertia=factor * cluster.gimbal_inertia,
        ),
    )
    estimate = ESTIMATORS[name](telemetry, replace(SETTINGS, nominal_theta=factor * NOMINAL_THETA))
    np.testing.assert_allclose(estimate.theta / factor, ESTIMATES[name].theta, atol=SEARCH_TOLERANCE)
    np.testing.assert_allclose(estimate.std / factor, ESTIMATES[name].std, rtol=1e-3)


@pytest.mark.parametrize("name", ESTIMATORS)
@given(start=st.floats(-1e3, 1e5))
@few
def test_the_clock_may_start_anywhere(name, start):
    telemetry = replace(TELEMETRY, gyro_time=TIMES + start, actuator_time=TIMES + start)
    np.testing.assert_allclose(
        ESTIMATORS[name](telemetry, SETTINGS).theta, ESTIMATES[name].theta, atol=SEARCH_TOLERANCE
    )
