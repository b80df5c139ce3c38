"""Effects of reaction wheels: their derivatives, and MuJoCo flying the scenario with each of them built in."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from testbed.arrays import Array
from testbed.assembly.extension import extended, write_extended
from testbed.assembly.platform import nominal_platform
from testbed.assembly.telemetry import telemetry_of
from testbed.diagnosis.channels import wheel_channel
from testbed.dynamics.inertia import theta_of
from testbed.effects.contract import Effect, Extension, components_in, wheel_index
from testbed.effects.noise_effect import Readings
from testbed.effects.registry import EFFECTS, NOISE_EFFECTS
from testbed.estimation.telemetry import Telemetry
from testbed.experiment.conduct import conduct
from testbed.prediction.grid import grid_of
from testbed.prediction.hooks import Hooks
from testbed.prediction.integration import Values
from testbed.prediction.prediction import predicted, predicted_channels, predicted_with_derivatives
from testbed.prediction.wheel_impulses import impulses_of
from testbed.prediction.wheel_response import impulses_with, measured_impulses
from testbed.scenario.reader import read_scenario
from testbed.scenario.scenario import Scenario
from testbed.scenario.shipped import shipped_scenario

LEFT = 2e-6
"""rad/s. Torques jump at every control period; wheel speeds sampled there leave so much between."""
SHARE = 0.01
"""Of the signature: another spin inertia is a share of the whole platform's, too, which the prediction leaves alone."""
OF_WHEELS = [pytest.param(each, id=each.id) for each in EFFECTS.values() if each.id.startswith("wheel_")]
IN_MOTORS = [each for each in OF_WHEELS if set(each.values[0].needs) & {"wheel_torque", "wheel_torque_command"}]
"""They show between what a motor was asked for and what turned its wheel."""
IN_MOTION = [each for each in OF_WHEELS if each not in IN_MOTORS]
LEFT_BY_MOTORS = 3e-9
"""N·m. The body turns along curves, and friction with the wheels, where impulses are taken along lines."""
LEFT_IN_MOTION = 4e-6
"""rad/s. Motors that give another torque than the tracker asked for jump by more."""
RATE = (0.1, -0.15, 0.2)
WHEEL = "wheel3"
ROUNDED = {"wheel_delay": 0.02}
"""Share of a signature that MuJoCo's steps round off: a late command is a line through one of them, at jumps a 24th of
an interval of two steps."""


@cache
def scenario(share: float = 1.0) -> Scenario:
    """Five noise-free seconds of the CubeSat, released with a share of a spin and with turning wheels."""
    shipped = read_scenario(shipped_scenario("cubesat_wheels"))
    inertia = [list(row) for row in shipped.platform.inertia_kg_m2]
    points = np.vstack([RATE, RATE, np.random.default_rng(5).uniform(-0.15, 0.15, (5, 3)), np.zeros((2, 3))])
    changes = {
        "truth": {"inertia_kg_m2": inertia},
        "initial": {
            "body_rate_rad_s": list(share * np.array(RATE)),
            "wheel_momentum_N_m_s": [0.002, -0.001, 0.003, -0.002],
        },
        "gyro": {"sample_rate_hz": 20.0, "noise_rad_s": 0.0, "bias_instability_rad_s": 0.0},
        "wheel_tachometer": {"noise_rad_s": 0.0},
        "maneuver": {"body_rate_rad_s": (share * points).tolist(), "duration_s": 20.0},
        "simulation": {"duration_s": 5.0, "control_rate_hz": 100.0, "telemetry_rate_hz": 100.0},
        "controller": {"feedback_gain_1_s": 0.5},
        "estimation": {"estimators": ["iv_momentum"]},
    }
    keys = shipped.model_dump(mode="json", by_alias=True, exclude_unset=True, exclude_none=True)
    keys["gyro"].pop("bias_correlation_time_s")
    for section, values in changes.items():
        keys.setdefault(section, {}).update(values)
    return Scenario.model_validate(keys)


def flown(extension: Extension | None, folder, base: Scenario | None = None) -> Telemetry:
    base = base or scenario()
    changed = base if extension is None else extended(base, extension)
    inertia = nominal_platform(base).inertia
    written = read_scenario(write_extended(base, [] if extension is None else [extension], inertia, folder))
    assert written.truth == changed.truth.model_copy(update={"inertia_kg_m2": None})
    experiment = conduct(written, seed=1)
    assert experiment.outcome == "completed"
    return telemetry_of(experiment.flown.record, base, nominal_platform(base))


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


@pytest.mark.parametrize("effect", IN_MOTION)
def test_mujoco_and_the_prediction_show_the_same_signature(effect: Effect, tmp_path):
    size = typical(effect)
    telemetry = flown(effect.extension(WHEEL, size, scenario()), tmp_path)
    signature, left = missed(telemetry, []), missed(telemetry, [effect.hooks(WHEEL)], size)
    print(f"{effect.id}: signature {signature:.1e} rad/s, left {left:.1e}")
    assert left < LEFT + SHARE * signature
    assert signature > 50.0 * LEFT


def gentle() -> Scenario:
    """Return one in which no motor comes to its limit, where nothing is compared."""
    return scenario(0.3)


def missed_by_motors(telemetry: Telemetry, hooks: list[Hooks], *sizes: Array) -> float:
    """Return the largest mean torque of an interval that is not explained, N·m."""
    impulses = impulses_of(telemetry, commanded=True)
    assert min(map(len, impulses.kept)) > 0.9 * len(impulses.interval)
    given = impulses_with(impulses, hooks, [each[None] for each in sizes])[0]
    torque = np.abs((impulses.needed - given) / impulses.interval[:, None]).T
    return float(max(of_wheel[kept].max() for of_wheel, kept in zip(torque, impulses.kept, strict=True)))


def test_without_effects_motors_give_what_they_are_asked_for(tmp_path):
    left = missed_by_motors(flown(None, tmp_path, gentle()), [])
    print(f"left {left:.1e} N·m")
    assert left < LEFT_BY_MOTORS


@pytest.mark.parametrize("effect", [*IN_MOTORS, pytest.param(EFFECTS["wheel_inertia"], id="wheel_inertia")])
def test_mujoco_and_the_prediction_show_the_same_impulses_of_motors(effect: Effect, tmp_path):
    size = typical(effect)
    telemetry = flown(effect.extension(WHEEL, size, gentle()), tmp_path, gentle())
    signature, left = missed_by_motors(telemetry, []), missed_by_motors(telemetry, [effect.hooks(WHEEL)], size)
    print(f"{effect.id}: signature {signature:.1e} N·m, left {left:.1e}")
    assert left < LEFT_BY_MOTORS + ROUNDED.get(effect.id, SHARE) * signature
    assert signature > 50.0 * LEFT_BY_MOTORS


@pytest.mark.parametrize("effect", IN_MOTORS)
def test_what_happens_in_motors_leaves_the_motion_explained(effect: Effect, tmp_path):
    assert missed(flown(effect.extension(WHEEL, typical(effect), scenario()), tmp_path), []) < LEFT_IN_MOTION


def test_an_unbalanced_wheel_draws_the_line_that_is_sought(tmp_path):
    effect = NOISE_EFFECTS["wheel_imbalance"]
    size = typical(effect)
    telemetry = flown(effect.extension(WHEEL, size, gentle()), tmp_path, gentle())
    line = missed_from_any_start(telemetry)
    readings = Readings(
        measured=[telemetry.body_rate],
        residual=[line],
        sigma=np.full((1, 3), LEFT),
        runs=[telemetry],
        inertia=nominal_platform(scenario()).inertia,
        parameters=0,
    )
    finding = effect.found(WHEEL, readings)
    left = line - finding.explained[0]
    print(f"{effect.id}: signature {np.abs(line).max():.1e} rad/s, left {np.abs(left).max():.1e}, {finding.values}")
    np.testing.assert_allclose(finding.values, size, rtol=0.02)
    assert np.abs(left).max() < 0.05 * np.abs(line).max()


def missed_from_any_start(telemetry: Telemetry) -> Array:
    """Return measured less predicted, from the initial rate that fits best: the first sample trembles too."""
    values = replace(values_of(), initial_rate=telemetry.body_rate[:1][None])
    (reading,), (derivatives,) = predicted_with_derivatives(grid_of([telemetry]), [], values, range(6, 9))
    residual = telemetry.body_rate - reading
    slopes = derivatives.reshape(-1, 3)
    return residual - (slopes @ np.linalg.lstsq(slopes, residual.ravel())[0]).reshape(residual.shape)


@pytest.mark.parametrize("effect", OF_WHEELS)
def test_derivatives_agree_with_differences(effect: Effect, tmp_path):
    """Of the motion in rad/s, of the motors in shares of the largest impulse."""
    telemetry = flown(None, tmp_path, gentle())
    grid, hooks, at = grid_of([telemetry]), [effect.hooks(WHEEL)], 0.9 * typical(effect)  # no kink
    grid = replace(grid, wheel_noise=wheel_channel(grid))
    index = 0 if any(effect is each.values[0] for each in IN_MOTION) else 1 + wheel_index(WHEEL)
    size = 1.0 if index == 0 else float(max(np.abs(block).max() for (block,) in measured_impulses(grid)))
    _, derivatives = predicted_with_derivatives(grid, hooks, values_of(at), range(6, 6 + len(at)), predicted_channels)
    for number, scale in enumerate(at):
        step = 1e-5 * scale * np.eye(len(at))[number]
        forward, back = (predicted_channels(grid, hooks, values_of(at + sign * step))[index][0] for sign in (1.0, -1.0))
        exact = derivatives[index][..., number] * scale / size
        assert np.abs(exact).max() > 1e-7, effect.parameters[number].name
        np.testing.assert_allclose(exact, (forward - back) / 2e-5 / size, atol=2e-9)


@pytest.mark.parametrize("effect", OF_WHEELS)
def test_a_platform_has_them_at_as_many_wheels_as_it_has(effect: Effect):
    assert components_in(effect, 6) == ()
    each = ("wheel1", "wheel2", "wheel3", "wheel4")
    assert components_in(effect, 0, 4) in {each, ("wheels",), (*each, "wheels")}
    assert len(components_in(effect, 0, 1)) == 1
