"""Effects of reaction wheels: their derivatives, and MuJoCo flying the scenario with each of them built in."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from testbed.arrays import Array
from testbed.assembly.extension import extended, write_extended
from testbed.assembly.platform import nominal_platform
from testbed.assembly.telemetry import telemetry_of
from testbed.dynamics.inertia import theta_of
from testbed.effects.contract import Effect, Extension, components_in
from testbed.effects.registry import EFFECTS
from testbed.estimation.telemetry import Telemetry
from testbed.experiment.conduct import conduct
from testbed.prediction.grid import grid_of
from testbed.prediction.hooks import Hooks
from testbed.prediction.integration import Values
from testbed.prediction.prediction import predicted, predicted_with_derivatives
from testbed.scenario.reader import read_scenario
from testbed.scenario.scenario import Scenario
from testbed.scenario.shipped import shipped_scenario

LEFT = 2e-6
"""rad/s. Torques jump at every control period; wheel speeds sampled there leave so much between."""
SHARE = 0.01
"""Of the signature: another spin inertia is a share of the whole platform's, too, which the prediction leaves alone."""
OF_WHEELS = [pytest.param(each, id=each.id) for each in EFFECTS.values() if each.id.startswith("wheel_")]
RATE = (0.1, -0.15, 0.2)
WHEEL = "wheel3"


@cache
def scenario() -> Scenario:
    """Five noise-free seconds of the CubeSat, released with a spin and with turning wheels."""
    shipped = read_scenario(shipped_scenario("cubesat_wheels"))
    inertia = [list(row) for row in shipped.platform.inertia_kg_m2]
    points = np.vstack([RATE, RATE, np.random.default_rng(5).uniform(-0.15, 0.15, (5, 3)), np.zeros((2, 3))])
    changes = {
        "truth": {"inertia_kg_m2": inertia},
        "initial": {"body_rate_rad_s": list(RATE), "wheel_momentum_N_m_s": [0.002, -0.001, 0.003, -0.002]},
        "gyro": {"sample_rate_hz": 20.0, "noise_rad_s": 0.0, "bias_instability_rad_s": 0.0},
        "wheel_tachometer": {"noise_rad_s": 0.0},
        "maneuver": {"body_rate_rad_s": points.tolist(), "duration_s": 20.0},
        "simulation": {"duration_s": 5.0, "control_rate_hz": 100.0, "telemetry_rate_hz": 100.0},
        "controller": {"feedback_gain_1_s": 0.5},
        "estimation": {"estimators": ["iv_momentum"]},
    }
    keys = shipped.model_dump(mode="json", by_alias=True, exclude_unset=True, exclude_none=True)
    keys["gyro"].pop("bias_correlation_time_s")
    for section, values in changes.items():
        keys.setdefault(section, {}).update(values)
    return Scenario.model_validate(keys)


def flown(extension: Extension | None, folder) -> Telemetry:
    changed = scenario() if extension is None else extended(scenario(), extension)
    inertia = nominal_platform(scenario()).inertia
    written = read_scenario(write_extended(scenario(), [] if extension is None else [extension], inertia, folder))
    assert written.truth == changed.truth.model_copy(update={"inertia_kg_m2": None})
    experiment = conduct(written, seed=1)
    assert experiment.outcome == "completed"
    return telemetry_of(experiment.flown.record, scenario(), nominal_platform(scenario()))


def values_of(*sizes: Array) -> Values:
    theta = theta_of(nominal_platform(scenario()).inertia)
    return Values(
        theta=theta[None], initial_rate=np.array(RATE)[None, None], effects=tuple(each[None] for each in sizes)
    )


def missed(telemetry: Telemetry, hooks: list[Hooks], *sizes: Array) -> float:
    reading = predicted(grid_of([telemetry]), hooks, values_of(*sizes))[0][0]
    return float(np.abs(telemetry.body_rate - reading).max())


def typical(effect: Effect) -> Array:
    return np.array([parameter.typical for parameter in effect.parameters])


def test_without_effects_the_prediction_explains_the_flight(tmp_path):
    assert missed(flown(None, tmp_path), []) < LEFT


@pytest.mark.parametrize("effect", OF_WHEELS)
def test_mujoco_and_the_prediction_show_the_same_signature(effect: Effect, tmp_path):
    size = typical(effect)
    telemetry = flown(effect.extension(WHEEL, size, scenario()), tmp_path)
    signature, left = missed(telemetry, []), missed(telemetry, [effect.hooks(WHEEL)], size)
    print(f"{effect.id}: signature {signature:.1e} rad/s, left {left:.1e}")
    assert left < LEFT + SHARE * signature
    assert signature > 50.0 * LEFT


@pytest.mark.parametrize("effect", OF_WHEELS)
def test_derivatives_agree_with_differences(effect: Effect, tmp_path):
    telemetry = flown(None, tmp_path)
    grid, hooks, at = grid_of([telemetry]), [effect.hooks(WHEEL)], typical(effect)
    _, derivatives = predicted_with_derivatives(grid, hooks, values_of(at), range(6, 6 + len(at)))
    for index, scale in enumerate(at):
        step = 1e-5 * scale * np.eye(len(at))[index]
        forward, back = (predicted(grid, hooks, values_of(at + sign * step))[0][0] for sign in (1.0, -1.0))
        exact = derivatives[0][..., index] * scale
        assert np.abs(exact).max() > 1e-7, effect.parameters[index].name
        np.testing.assert_allclose(exact, (forward - back) / 2e-5, atol=2e-9)


@pytest.mark.parametrize("effect", OF_WHEELS)
def test_a_platform_has_them_at_as_many_wheels_as_it_has(effect: Effect):
    assert components_in(effect, 6) == ()
    assert components_in(effect, 0, 4) == ("wheel1", "wheel2", "wheel3", "wheel4")
