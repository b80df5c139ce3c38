"""What every steering law must do, wherever the gimbals stand."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from support.platforms import ROTOR_MOMENTUM, shipped
from testbed.cmg.cluster import momentum_jacobian
from testbed.cmg.singularity import singularity_measure
from testbed.cmg.steering import (
    GeneralizedSingularityRobust,
    MoorePenrose,
    OffDiagonalSingularityRobust,
    SingularityRobust,
    limit_rates,
    preferred_rates,
    steer,
)
from testbed.plant.geometry import cluster_of

CLUSTER = cluster_of(shipped())
LAWS = [MoorePenrose(), SingularityRobust(), GeneralizedSingularityRobust(), OffDiagonalSingularityRobust()]
ANGLES = arrays(np.float64, 6, elements=st.floats(-3.1, 3.1))
TORQUES = arrays(np.float64, 3, elements=st.floats(-0.04, 0.04))
RATES = arrays(np.float64, 6, elements=st.floats(-2.0, 2.0))
WALL = np.arctan2(CLUSTER.transverse_axis_B[:, 0], CLUSTER.spin_axis_B[:, 0])
"""Gimbal angles on the envelope along x: no torque along x is left."""


@pytest.mark.parametrize("law", LAWS, ids=lambda law: type(law).__name__)
@given(angle=ANGLES, torque=TORQUES, preferred=RATES)
@settings(max_examples=60, deadline=None)
def test_away_from_singularities_the_torque_is_given(law, angle, torque, preferred):
    jacobian = momentum_jacobian(CLUSTER, angle)
    measure = singularity_measure(jacobian, CLUSTER.rotor_momentum)
    assume(measure > 0.3)
    rate = steer(law, jacobian, torque, preferred, ROTOR_MOMENTUM, 0.3)
    # λ = 0.01 exp(-10 det), det ≥ 0.72 here: below 1e-5 of the smallest eigenvalue for the damped laws.
    np.testing.assert_allclose(jacobian @ rate, torque, atol=1e-4 * np.abs(torque).max() + 1e-12)


@given(angle=ANGLES, torque=TORQUES)
@settings(max_examples=60, deadline=None)
def test_moore_penrose_gives_the_smallest_rates(angle, torque):
    jacobian = momentum_jacobian(CLUSTER, angle)
    assume(singularity_measure(jacobian, CLUSTER.rotor_momentum) > 0.1)
    rate = steer(MoorePenrose(), jacobian, torque, np.zeros(6), ROTOR_MOMENTUM, 0.0)
    np.testing.assert_allclose(rate, np.linalg.lstsq(jacobian, torque, rcond=None)[0], rtol=1e-6, atol=1e-9)


@pytest.mark.parametrize("law", LAWS, ids=lambda law: type(law).__name__)
def test_at_a_singularity_the_damped_laws_stay_bounded_and_the_exact_one_does_not(law):
    jacobian = momentum_jacobian(CLUSTER, WALL)
    rate = steer(law, jacobian, np.array([0.02, 0.0, 0.0]), np.zeros(6), ROTOR_MOMENTUM, 0.4)
    fastest = np.abs(rate).max()
    assert np.isfinite(fastest)
    if isinstance(law, MoorePenrose | SingularityRobust):
        assert np.abs(jacobian @ rate)[0] < 1e-8, "torque along the lost direction is not to be had"
    if not isinstance(law, MoorePenrose):
        assert fastest < 50.0


def test_the_dithered_laws_leave_the_wall_where_the_plain_ones_lock():
    """A torque straight into the singular direction: SR commands nothing, GSR and o-DSR command an escape."""
    jacobian = momentum_jacobian(CLUSTER, WALL)
    torque = np.array([0.02, 0.0, 0.0])
    rates = {
        type(law).__name__: np.abs(steer(law, jacobian, torque, np.zeros(6), ROTOR_MOMENTUM, 0.4)).max() for law in LAWS
    }
    assert rates["SingularityRobust"] < 1e-6
    assert rates["GeneralizedSingularityRobust"] > 0.05
    assert rates["OffDiagonalSingularityRobust"] > 0.05


@given(angle=ANGLES, preferred=RATES)
@settings(max_examples=60, deadline=None)
def test_null_motion_gives_no_torque(angle, preferred):
    jacobian = momentum_jacobian(CLUSTER, angle)
    assume(singularity_measure(jacobian, CLUSTER.rotor_momentum) > 0.1)
    rate = steer(SingularityRobust(), jacobian, np.zeros(3), preferred, ROTOR_MOMENTUM, 0.0)
    np.testing.assert_allclose(jacobian @ rate, 0.0, atol=1e-12)


@given(rates=RATES, limit=st.floats(0.1, 3.0))
def test_limited_rates_keep_their_direction(rates, limit):
    limited, saturated = limit_rates(rates, limit)
    assert np.abs(limited).max() <= limit * (1.0 + 1e-12)
    assert saturated.tolist() == (np.abs(rates) > limit).tolist()
    np.testing.assert_allclose(limited * max(1.0, np.abs(rates).max() / limit), rates, atol=1e-12)


@given(angle=ANGLES, turns=st.integers(-2, 2))
def test_preferred_angles_are_reached_the_short_way_round(angle, turns):
    preferred = np.zeros(6) + 0.5
    plain = preferred_rates(angle, preferred, np.zeros(6), 2.0)
    turned = preferred_rates(angle + 2.0 * np.pi * turns, preferred, np.zeros(6), 2.0)
    np.testing.assert_allclose(turned, plain, atol=1e-12)
    assert np.abs(plain).max() <= 2.0 * np.pi + 1e-12


def test_a_batch_is_steered_like_its_members():
    angles = np.random.default_rng(5).uniform(-1.0, 1.0, (7, 6))
    torques = np.random.default_rng(6).uniform(-0.02, 0.02, (7, 3))
    for law in LAWS:
        together = steer(law, momentum_jacobian(CLUSTER, angles), torques, np.zeros((7, 6)), ROTOR_MOMENTUM, 0.2)
        alone = steer(law, momentum_jacobian(CLUSTER, angles[4]), torques[4], np.zeros(6), ROTOR_MOMENTUM, 0.2)
        np.testing.assert_allclose(together[4], alone, rtol=1e-12)


def test_a_failed_unit_is_not_asked():
    momentum = CLUSTER.rotor_momentum.copy()
    momentum[2] = 0.0
    jacobian = momentum_jacobian(CLUSTER, np.zeros(6), momentum)
    rate = steer(MoorePenrose(), jacobian, np.array([0.01, -0.01, 0.02]), np.zeros(6), ROTOR_MOMENTUM, 0.0)
    assert rate[2] == 0.0
    assert np.abs(np.delete(rate, 2)).min() > 0.0
