"""What a campaign draws for each flight."""

from __future__ import annotations

import numpy as np
import pytest

from testbed.assembly.dispersion import dispersed
from testbed.campaign.flights import fly_seeds
from testbed.dynamics.inertia import theta_of
from testbed.errors import InputError
from testbed.experiment.planning import plan_maneuver
from testbed.scenario.dispersion import Dispersion
from testbed.scenario.reader import read_scenario
from tests.unit.test_scenario_reader import SHIPPED
from tests.unit.test_side_by_side import NOMINAL, SHORT

SPREAD = Dispersion(
    inertia_kg_m2=(1e-4, 2e-4, 3e-4, 1e-5, 2e-5, 3e-5),
    rotor_momentum_relative=0.01,
    body_rate_rad_s=(0.01, 0.02, 0.03),
    velocity_m_s=(0.1, 0.2, 0.3),
    gyro_bias_rad_s=(1e-3, 2e-3, 3e-3),
    gyro_scale_factor=(1e-3, 2e-3, 3e-3),
)
DRAWS = 400


def with_spread(spread: Dispersion):
    return SHORT.model_copy(update={"dispersion": spread})


def drawn(spread: Dispersion, seed: int):
    return dispersed(with_spread(spread), seed)


def quantities(scenario) -> np.ndarray:
    """Everything that can be dispersed, in the order of the section."""
    return np.concatenate(
        [
            theta_of(np.array(scenario.truth.inertia_kg_m2)),
            scenario.truth.rotor_momentum_N_m_s,
            scenario.initial.body_rate_rad_s,
            scenario.initial.velocity_m_s,
            scenario.gyro.bias_rad_s,
            scenario.gyro.scale_factor_error,
        ]
    )


def test_draws_have_the_stated_mean_and_spread():
    values = np.array([quantities(drawn(SPREAD, seed)) for seed in range(DRAWS)])
    mean = np.concatenate([[0.022, 0.022, 0.027, 0.0, 0.0, 0.0], np.full(6, 0.004714), np.zeros(12)])
    gyro = [SPREAD.gyro_bias_rad_s, SPREAD.gyro_scale_factor]
    start = [SPREAD.body_rate_rad_s, SPREAD.velocity_m_s]
    std = np.concatenate([SPREAD.inertia_kg_m2, np.full(6, 4.714e-5), *start, *gyro])
    # 24 quantities, 400 draws: 4 standard errors of a mean, and of a standard deviation (1/sqrt(2 · 399)).
    np.testing.assert_array_less(np.abs(values.mean(axis=0) - mean), 4.0 * std / np.sqrt(DRAWS))
    np.testing.assert_allclose(values.std(axis=0, ddof=1), std, rtol=4.0 / np.sqrt(2.0 * (DRAWS - 1)))
    correlation = np.corrcoef(values.T) - np.eye(values.shape[1])
    assert np.abs(correlation).max() < 4.5 / np.sqrt(DRAWS), "each quantity is drawn on its own"


def test_to_disperse_one_quantity_more_does_not_change_another():
    rates = Dispersion(body_rate_rad_s=SPREAD.body_rate_rad_s)
    assert drawn(rates, 3).initial.body_rate_rad_s == drawn(SPREAD, 3).initial.body_rate_rad_s
    assert drawn(rates, 3).truth == SHORT.truth


def test_a_scenario_without_dispersion_is_flown_as_it_is():
    assert dispersed(SHORT, 7) is SHORT


def test_a_draw_that_belongs_to_no_body_is_a_failed_flight_and_the_others_fly():
    wild = Dispersion(inertia_kg_m2=(0.03, 0.03, 0.03, 0.0, 0.0, 0.0))
    maneuver = plan_maneuver(SHORT, NOMINAL).maneuver
    flights = fly_seeds(with_spread(wild), maneuver, range(6))
    failed = [flight for flight in flights if flight.message]
    assert 0 < len(failed) < 6
    assert all(flight.flown is None and "inertia" in flight.message for flight in failed)
    assert all(flight.flown is not None for flight in flights if not flight.message)


@pytest.mark.parametrize("key", ["body_rate_rad_s = [0.0, 0.01, 0.0]", "rotor_momentum_relative = 0.01"])
def test_drawn_momentum_is_not_taken_to_be_zero(tmp_path, key):
    text = (SHIPPED / "basic.toml").read_text(encoding="utf-8")
    path = tmp_path / "drawn.toml"
    path.write_text(text.replace("[maneuver]", f"[dispersion]\n{key}\n\n[maneuver]"), encoding="utf-8")
    with pytest.raises(InputError, match=r'estimation.initial_momentum: is "zero", but dispersion.*use "estimated"'):
        read_scenario(path)
