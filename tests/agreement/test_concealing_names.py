"""Answers and diagnoses spell effects, components and parameters alike; where they cannot, it is listed here."""

import numpy as np
import pytest

from concealing.library import FURTHER, LISTED
from concealing.sealing import file_key
from concealing.wheel_effects import BY_NAME, OF_BEARINGS, OF_WHEELS
from testbed.effects.contract import ALL_WHEELS, components_in
from testbed.effects.registry import EFFECTS, NOISE_EFFECTS

HIDEABLE = {**LISTED, **FURTHER, **OF_WHEELS, **OF_BEARINGS, **BY_NAME}
OF_RIGS = {"actuator_gain", "actuator_rate_limit"}
"""Hidden by `concealing.rig`, by numbers of its own."""
OF_THRUSTERS = {"actuator_weak", "actuator_misaligned", "thrust_offset", "rotor_acceleration_reaction"}
"""Effects that the platform of the concealing engine, which has gimbals, cannot have; data/crazypad shows them."""
KNOWN = {
    name: effect
    for name, effect in {**EFFECTS, **NOISE_EFFECTS}.items()
    if effect.environment != "orbit" and name not in OF_RIGS | OF_THRUSTERS
}
"""Platforms on which effects are hidden by name have gyros or wheels, and none is on an orbit."""
ONLY_HIDDEN = {
    "contact": {"time_since_release_s", "run"},
    "slosh": {"loose_mass_kg", "place_x_m", "place_y_m", "place_z_m"},
    "gimbal_coulomb_friction": {"stribeck_torque_N_m", "stribeck_rate_rad_s"},
    "rotor_imbalance": {"dynamic_kg_m2", "phase_rad"},
    "gyro_drift": {"random_walk_rad_s1.5"},
}
OF_ALL_WHEELS = {"wheel_lag", "wheel_viscous_friction", "wheel_coulomb_friction"}
"""Diagnosed of all wheels alike as well, and hidden in one wheel at a time."""
ONLY_MODELLED = {"dry_friction": {"width_rad_s"}, "contact": {"time_s"}, "slosh": {"mass_kg"}}


@pytest.mark.parametrize("effect", sorted(KNOWN))
def test_parameters_have_the_same_names(effect):
    parameters = KNOWN[effect].parameters
    values = np.array([parameter.typical for parameter in parameters])
    modelled = {quantity.name for quantity in KNOWN[effect].quantities(values, np.zeros_like(values))}
    hidden = {file_key(effect, name, unit) for name, unit in HIDEABLE[effect].units.items()}
    assert hidden - modelled == ONLY_HIDDEN.get(effect, set())
    assert modelled - hidden == ONLY_MODELLED.get(effect, set())


@pytest.mark.parametrize("effect", sorted(KNOWN))
def test_components_have_the_same_names(effect):
    alike = {ALL_WHEELS} if effect in OF_ALL_WHEELS else set()
    assert set(components_in(KNOWN[effect], 6, 4)) == set(HIDEABLE[effect].components) | alike


def test_every_effect_that_is_diagnosed_can_be_hidden():
    assert set(KNOWN) <= set(HIDEABLE)
