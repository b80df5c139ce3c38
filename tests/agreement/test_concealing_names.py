"""Answers and diagnoses spell effects, components and parameters alike; where they cannot, it is listed here."""

import numpy as np
import pytest

from concealing.files import told_name
from concealing.library import LISTED
from testbed.effects.contract import components_in
from testbed.effects.registry import EFFECTS, NOISE_EFFECTS

THRUSTERS_ONLY = {
    "actuator_gain",
    "actuator_weak",
    "actuator_misaligned",
    "thrust_offset",
    "rotor_acceleration_reaction",
}
"""Effects that the platform of the concealing engine, which has gimbals, cannot have; data/crazypad shows them."""
KNOWN = {name: effect for name, effect in (EFFECTS | dict(NOISE_EFFECTS)).items() if name not in THRUSTERS_ONLY}
ONLY_HIDDEN = {
    "contact": {"time_since_release_s", "run"},
    "slosh": {"loose_mass_kg", "place_x_m", "place_y_m", "place_z_m"},
    "gimbal_coulomb_friction": {"stribeck_torque_N_m", "stribeck_rate_rad_s"},
    "rotor_imbalance": {"dynamic_kg_m2", "phase_rad"},
    "gyro_drift": {"random_walk_rad_s1.5"},
}
ONLY_TOLD = {"contact": {"time_s"}, "slosh": {"mass_kg"}}


@pytest.mark.parametrize("effect", sorted(KNOWN))
def test_parameters_have_the_same_names(effect):
    parameters = KNOWN[effect].parameters
    values = np.array([parameter.typical for parameter in parameters])
    told = {quantity.name for quantity in KNOWN[effect].quantities(values, np.zeros_like(values))}
    hidden = {told_name(effect, name) for name in LISTED[effect].units}
    assert hidden - told == ONLY_HIDDEN.get(effect, set())
    assert told - hidden == ONLY_TOLD.get(effect, set())


@pytest.mark.parametrize("effect", sorted(KNOWN))
def test_components_have_the_same_names(effect):
    assert set(components_in(KNOWN[effect], 6)) == set(LISTED[effect].components)


def test_every_effect_that_is_diagnosed_can_be_hidden():
    assert set(KNOWN) <= set(LISTED)
