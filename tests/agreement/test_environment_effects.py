"""Effects of an environment: their derivatives, and MuJoCo flying the scenario with each of them built in."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from testbed.arrays import Array
from testbed.assembly.extension import extended, write_extended
from testbed.assembly.platform import nominal_platform
from testbed.assembly.telemetry import telemetry_of
from testbed.dynamics.inertia import theta_of
from testbed.effects.contract import Effect, Extension
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
"""Of the signature: what the controller does about an effect is held for a period, too."""
OF_ENVIRONMENT = [pytest.param(each, id=each.id) for each in EFFECTS.values() if each.environment]
SHIPPED = {"air_bearing": "air_bearing", "orbit": "cubesat_wheels"}
ORBIT = {"kind": "orbit", "altitude_m": 4e5, "magnetic_field_T": [2e-5, -1e-5, 3e-5], "torque_N_m": [2e-7, -1e-7, 0.0]}
QUAT = [0.98, 0.1, -0.14, 0.0969536]
SECONDS = {"air_bearing": 6.0, "orbit": 40.0}
"""A gravity gradient takes its time."""


@cache
def scenario(kind: str) -> Scenario:
    """A shipped platform in the environment, without noise, released with a spin and with turning wheels."""
    shipped = read_scenario(shipped_scenario(SHIPPED[kind]))
    rate = np.array([0.03, -0.05, 0.1])
    points = np.vstack([rate, rate, np.random.default_rng(5).uniform(-0.1, 0.1, (5, 3)), np.zeros((2, 3))])
    changes = {
        "truth": {"inertia_kg_m2": [list(row) for row in shipped.platform.inertia_kg_m2]},
        "initial": {
            "body_rate_rad_s": rate.tolist(),
            "attitude_quat_NB": (np.array(QUAT) / np.linalg.norm(QUAT)).tolist(),
        },
        "gyro": {"sample_rate_hz": 20.0, "noise_rad_s": 0.0, "bias_instability_rad_s": 0.0},
        "wheel_tachometer": {"noise_rad_s": 0.0},
        "maneuver": {"body_rate_rad_s": points.tolist(), "duration_s": SECONDS[kind]},
        "simulation": {"duration_s": SECONDS[kind], "control_rate_hz": 100.0, "telemetry_rate_hz": 100.0},
        "controller": {"feedback_gain_1_s": 0.5},
        "estimation": {"estimators": ["iv_momentum"]},
        "environment": {} if kind == "air_bearing" else ORBIT,
    }
    keys = shipped.model_dump(mode="json", by_alias=True, exclude_unset=True, exclude_none=True)
    keys["gyro"].pop("bias_correlation_time_s")
    keys["truth"] = {}
    keys["environment"] = {key: value for key, value in keys.get("environment", {}).items() if key != "tilt_limit_rad"}
    for section, values in changes.items():
        keys.setdefault(section, {}).update(values)
    return Scenario.model_validate(keys)


def flown(kind: str, extension: Extension | None, folder) -> Telemetry:
    nominal = scenario(kind)
    changed = nominal if extension is None else extended(nominal, extension)
    inertia = nominal_platform(nominal).inertia
    written = read_scenario(write_extended(nominal, [] if extension is None else [extension], inertia, folder))
    assert written.truth == changed.truth.model_copy(update={"inertia_kg_m2": None})
    experiment = conduct(written, seed=1)
    assert experiment.outcome == "completed"
    return telemetry_of(experiment.flown.record, nominal, nominal_platform(nominal))


def values_of(telemetry: Telemetry, kind: str, *sizes: Array) -> Values:
    theta = theta_of(nominal_platform(scenario(kind)).inertia)
    return Values(
        theta=theta[None], initial_rate=telemetry.body_rate[:1][None], effects=tuple(each[None] for each in sizes)
    )


def missed(telemetry: Telemetry, kind: str, hooks: list[Hooks], *sizes: Array) -> float:
    reading = predicted(grid_of([telemetry]), hooks, values_of(telemetry, kind, *sizes))[0][0]
    return float(np.abs(telemetry.body_rate - reading).max())


def typical(effect: Effect) -> Array:
    return np.array([parameter.typical for parameter in effect.parameters])


@pytest.mark.parametrize("kind", ["air_bearing", "orbit"])
def test_the_environment_is_in_the_prediction(kind, tmp_path):
    left = missed(flown(kind, None, tmp_path), kind, [])
    print(f"{kind}: left {left:.1e} rad/s")
    assert left < LEFT


@pytest.mark.parametrize("effect", OF_ENVIRONMENT)
def test_an_absent_effect_changes_nothing(effect: Effect, tmp_path):
    kind, absent = effect.environment, np.array([parameter.absent for parameter in effect.parameters])
    telemetry = flown(kind, effect.extension("platform", absent, scenario(kind)), tmp_path)
    values = values_of(telemetry, kind)
    plain = predicted(grid_of([telemetry]), [], values)[0]
    with_effect = predicted(grid_of([telemetry]), [effect.hooks("platform")], replace(values, effects=(absent[None],)))
    np.testing.assert_allclose(with_effect[0], plain, atol=1e-12)


@pytest.mark.parametrize("effect", OF_ENVIRONMENT)
def test_mujoco_and_the_prediction_show_the_same_signature(effect: Effect, tmp_path):
    kind, size = effect.environment, typical(effect)
    telemetry = flown(kind, effect.extension("platform", size, scenario(kind)), tmp_path)
    signature, left = missed(telemetry, kind, []), missed(telemetry, kind, [effect.hooks("platform")], size)
    print(f"{effect.id}: signature {signature:.1e} rad/s, left {left:.1e}")
    assert left < LEFT + SHARE * signature
    assert signature > 25.0 * LEFT


@pytest.mark.parametrize("effect", OF_ENVIRONMENT)
def test_derivatives_agree_with_differences(effect: Effect, tmp_path):
    kind, at = effect.environment, typical(effect)
    telemetry = flown(kind, None, tmp_path)
    grid, hooks = grid_of([telemetry]), [effect.hooks("platform")]
    columns = range(6 + len(at))  # of the inertia too: the gravity gradient is in proportion to it
    _, derivatives = predicted_with_derivatives(grid, hooks, values_of(telemetry, kind, at), columns)
    for index, scale in enumerate(at):
        step = 1e-5 * scale * np.eye(len(at))[index]
        forward, back = (
            predicted(grid, hooks, values_of(telemetry, kind, at + sign * step))[0][0] for sign in (1.0, -1.0)
        )
        exact = derivatives[0][..., 6 + index] * scale
        assert np.abs(exact).max() > 1e-7, effect.parameters[index].name
        np.testing.assert_allclose(exact, (forward - back) / 2e-5, atol=2e-9)
