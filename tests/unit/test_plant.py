"""The plant: rotor servos and their clamp, the cabin, divergence."""

from __future__ import annotations

import numpy as np
import pytest

from support.platforms import ROTOR_MOMENTUM, OnePlatform, initial, plant, restless_torque, shipped
from testbed.errors import UnphysicalPlatformError
from testbed.plant.build import build, shipped_model, specification
from testbed.plant.properties import PlatformProperties

LIMIT = 0.0052


def overspeeding(rotors: str) -> OnePlatform:
    momentum = np.full(6, ROTOR_MOMENTUM)
    momentum[2] = 0.0056
    model = build(PlatformProperties(rotor_momentum=momentum, rotor_momentum_limit=LIMIT))
    return plant(model, rotors=rotors, limit=LIMIT, rotor_momentum=momentum)


@pytest.mark.parametrize("rotors", ["constant_speed", "free"])
def test_an_overspeeding_rotor_is_clamped_to_its_limit(rotors):
    flown = overspeeding(rotors)
    assert flown.rotor_clamped.tolist() == [False, False, True, False, False, False]
    for _ in range(80):
        flown.advance(np.zeros(6), 10)
    speed = flown.qvel[flown.layout.rotor_speed]
    # A free rotor is released as soon as it is inside, within one control period of braking at 300 1/s.
    assert abs(speed[2]) * 1e-5 <= LIMIT * (1.0 + 1e-6)
    assert abs(speed[2]) * 1e-5 >= LIMIT * 0.98
    others = np.delete(speed, 2)
    np.testing.assert_allclose(others, ROTOR_MOMENTUM / 1e-5, rtol=1e-3)


def test_constant_speed_rotors_keep_their_speed_and_free_ones_do_not():
    drifts = {}
    for rotors in ("constant_speed", "free"):
        flown = plant(shipped(), initial(body_rate=np.array([0.2, 0.1, -0.1])), rotors=rotors)
        for tick in range(400):
            flown.advance(restless_torque(tick * 0.0125), 10)
        drifts[rotors] = np.abs(flown.qvel[flown.layout.rotor_speed] / 471.4 - 1.0).max()
    assert drifts["constant_speed"] < 2e-5  # disturbance Js ω̇ over the gain Js · 300 1/s
    assert drifts["free"] > 1e-4


def test_motor_torque_stays_at_its_limit():
    flown = plant(shipped())
    flown.advance(np.full(6, 0.5), 1)
    torque = flown.joint_torque[flown.layout.gimbal_rate]
    np.testing.assert_allclose(torque, 0.015, rtol=1e-12)


def test_divergence_names_time_and_last_finite_state(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    flown = plant(build(PlatformProperties(step=0.02)))  # the rotor servo's 300 1/s · 0.02 s is beyond RK4's 2.8
    message = r"(?s)t = [\d.]+ s and [\d.]+ s.*last finite state"
    with pytest.raises(AssertionError, match=message) as caught:
        flown.advance(restless_torque(0.1), 4000)
    divergence = str(caught.value)
    assert "nan" not in divergence
    assert "\n" not in divergence
    for name in ("position", "attitude", "gimbal angles", "body rate", "gimbal rates", "rotor speeds [471.4, "):
        assert name in divergence
    assert "qpos" not in divergence
    assert list(tmp_path.iterdir()) == [], "MuJoCo leaves no log file behind"


def test_a_drifting_platform_meets_the_cabin_wall():
    model = build(PlatformProperties(cabin_size=np.array([1.0, 1.0, 1.0])))
    flown = plant(model, initial(velocity=np.array([0.2, 0.0, 0.0])))
    touched = []
    for _ in range(320):
        flown.advance(np.zeros(6), 10)
        touched.append(flown.contacts > 0)
    free_path = 0.5 - 0.09
    assert np.argmax(touched) * 0.0125 == pytest.approx(free_path / 0.2, abs=0.05)
    assert flown.qvel[0] < 0.2


def test_the_shipped_step_is_a_million_times_better_than_needed():
    """Body rate against a 10 times smaller step over 5 s of restless gimbals: docs/notes/step.md."""
    rates = []
    for step in (0.00125, 0.000125):
        flown = plant(build(PlatformProperties(step=step)))
        for tick in range(400):
            flown.advance(restless_torque(tick * 0.0125), round(0.0125 / step))
        rates.append(flown.body_rate.copy())
    assert np.abs(rates[0] - rates[1]).max() < 1e-6
    print(f"body rate error of the 1.25 ms step: {np.abs(rates[0] - rates[1]).max():.2e} rad/s")


def test_an_inertia_that_the_gyros_exceed_is_refused_by_their_name():
    with pytest.raises(UnphysicalPlatformError, match="when the gyros are taken off has the principal moments"):
        specification(PlatformProperties(inertia=np.diag([0.001, 0.02, 0.02])), shipped_model())
