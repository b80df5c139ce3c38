"""Platforms with any actuators, on orbit and on an air bearing, against Basilisk's reaction-wheel and VSCMG effectors.

The trajectories were frozen by basilisk/make_platforms.py and basilisk/make_orbit.py. docs/reference/agreement.md has
the figures, and says what either side could share.
"""

from copy import deepcopy

import numpy as np
import pytest

from support.agreement import CASES, PLATFORMS, difference, flown, frozen, orbited

SHIPPED_STEP = 1.25e-3
PROMISED = 1e-8


@pytest.mark.parametrize("name", PLATFORMS)
def test_body_rate_agrees_with_basilisk_for_ten_seconds(name):
    reference = frozen(name)
    assert reference.time[-1] == 10.0
    assert np.ptp(reference.body_rate, axis=0).min() > 0.05  # something moved about every axis
    worst = difference(name, SHIPPED_STEP)
    print(f"{name}: body rate against Basilisk {worst:.1e} rad/s")
    assert worst <= PROMISED


@pytest.mark.parametrize("name", PLATFORMS)
def test_actuators_agree_with_basilisk(name):
    ours, reference = flown(name, SHIPPED_STEP), frozen(name)
    for signal in ("gimbal_angle", "rotor_speed", "wheel_speed"):
        moved = getattr(reference, signal)
        if moved.size:
            assert np.ptp(moved, axis=0).min() > 1e-3
            np.testing.assert_allclose(getattr(ours, signal), moved, rtol=0, atol=PROMISED)


def test_what_differs_is_the_error_of_our_step():
    """Half the step: a sixteenth of it. A difference between the models would stay."""
    assert difference("six_cmgs", SHIPPED_STEP / 2) < difference("six_cmgs", SHIPPED_STEP) / 12


# What the agreement would notice, by keys of basilisk/platforms.toml: small errors of either side, each of which moves
# the body rate by a hundred times the promised figure or more.
CHANGES = {
    "a wheel's spin inertia, 1e-4 of it": ("three_wheels", ("wheel", "spin_inertia_kg_m2"), 1.5e-9),
    "a rotor's transverse inertia, 1e-3 of it": ("four_cmgs", ("cmg", "rotor_transverse_inertia_kg_m2"), 5.3e-9),
    "friction of the wheels' bearings, 1e-3 of it": ("four_wheels", ("wheel", "viscous_friction_N_m_s"), 2e-10),
    "the wheels' torque limit, 1e-3 of it": ("three_wheels", ("wheel", "torque_limit_N_m"), 1.2e-6),
    "skew, a hundredth of a degree": ("four_cmgs", ("platforms", "four_cmgs", "cmgs", "skew_deg"), 0.01),
    "rotor momentum, 1e-4 of it": ("mixed", ("cmg", "rotor_momentum_N_m_s"), 4.7e-7),
    "mass of the platform on its pivot, a tenth of a gram": ("air_bearing", ("mass_kg",), 1e-4),
    "gravity, 1e-4 of it": ("air_bearing", ("platforms", "air_bearing", "pivot", "gravity_m_s2"), 1e-3),
}  # fmt: skip


@pytest.mark.parametrize("change", CHANGES)
def test_the_agreement_notices_small_errors(change):
    name, keys, amount = CHANGES[change]
    cases = deepcopy(CASES)
    table = cases
    for key in keys[:-1]:
        table = table[key]
    table[keys[-1]] += amount
    moved = np.abs(flown(name, SHIPPED_STEP, cases).body_rate - frozen(name).body_rate).max()
    print(f"{change}: moves the body rate by {moved:.1e} rad/s")
    assert moved > 100 * PROMISED


def test_gravity_gradient_on_orbit_agrees_with_basilisk():
    reference = frozen("orbit").body_rate
    worst = np.abs(orbited(1.0) - reference).max()
    print(f"orbit: body rate against Basilisk {worst:.1e} rad/s")
    assert worst <= PROMISED
    free = deepcopy(CASES)
    free["orbit"]["gravitational_parameter_m3_s2"] = 0.0
    assert np.abs(orbited(1.0, free) - reference).max() > 1e-4  # the gradient does turn it
