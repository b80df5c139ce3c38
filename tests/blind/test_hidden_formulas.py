"""A set of the benchmark of hidden formulas whose names were wrong."""

from __future__ import annotations

from benchmarks.formula_sets import SCENARIO, data_of, set_of
from testbed.assembly.platform import nominal_platform
from testbed.diagnosis.findings import additions
from testbed.diagnosis.method import diagnosed
from testbed.dynamics.inertia import theta_of
from testbed.effects.registry import EFFECTS, NOISE_EFFECTS
from testbed.scenario.reader import read_scenario

NAMED = ("gyro_misalignment", "contact", "gyro_scale", "gyro_latency", "viscous_drag")
"""What was named, and two more: with all effects it goes the same way, in three times the time."""


def test_a_formula_takes_the_place_of_effects_beside_which_another_fits_worse():
    """They were a gyro's misalignment and a touch, and the gyro's scale stood out but fitted worse beside them."""
    case, hidden = set_of(61873, 34)
    data, nominal = data_of(case), nominal_platform(read_scenario(SCENARIO))
    effects = {name: EFFECTS[name] for name in NAMED}
    *_, final = diagnosed(data.runs, data.heldout, effects, theta_of(nominal.inertia), noise_effects=NOISE_EFFECTS)
    (named,) = additions(final)
    assert named.component == hidden.formula
    (size,) = named.quantities
    assert abs(size.value - hidden.values[0]) < 4.0 * size.std
    assert not final.left_over
