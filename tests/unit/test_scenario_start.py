"""A flight that starts with momentum must not be estimated as if it had none."""

import numpy as np
import pytest

from testbed.assembly.platform import true_platform
from testbed.cmg.cluster import platform_momentum
from testbed.errors import InputError
from testbed.plant.build import ROTOR_SERVO_BANDWIDTH as FLOWN_BANDWIDTH
from testbed.scenario.reader import read_scenario
from testbed.scenario.timing import ROTOR_SERVO_BANDWIDTH
from tests.unit.test_scenario_reader import SHIPPED

START = "gimbal_angle_rad = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0]"
REST = "body_rate_rad_s = [0.0, 0.0, 0.0]"
SKEW = "skew_deg = 63.9\n"
INERTIA = "inertia_kg_m2 = [[0.022, 0.0, 0.0], [0.0, 0.022, 0.0], [0.0, 0.0, 0.027]] # paper eq. (30)\n"
TURNED = "gimbal_angle_rad = [0.3, 0.1, -0.5, 0.0, 0.0, 0.9]"


def started(tmp_path, *changes, momentum="zero"):
    text = (SHIPPED / "basic.toml").read_text(encoding="utf-8")
    for old, new in (*changes, ('initial_momentum = "zero"', f'initial_momentum = "{momentum}"')):
        assert old in text
        text = text.replace(old, new)
    path = tmp_path / "started.toml"
    path.write_text(text, encoding="utf-8")
    return path


MOVING = {
    "body rate": [(REST, "body_rate_rad_s = [0.01, 0.0, 0.0]")],
    "body rate, inertia of the model": [(REST, "body_rate_rad_s = [0.01, 0.0, 0.0]"), (INERTIA, "")],
    "gimbal angles": [(START, TURNED)],
    "failed unit": [("failed = []", "failed = [3]")],
    "failed unit, skew of the model": [("failed = []", "failed = [3]"), (SKEW, "")],
    "unequal rotors": [
        ("[initial]", "[truth]\nrotor_momentum_N_m_s = [0.005, 0.0047, 0.0047, 0.0047, 0.0047, 0.0047]\n[initial]")
    ],
}
STILL = {
    "at rest": [],
    "gimbals turned alternately": [(START, "gimbal_angle_rad = [0.4, -0.4, 0.4, -0.4, 0.4, -0.4]")],
    "opposite units failed": [("failed = []", "failed = [1, 4]")],
    "all rotors alike too fast": [("[initial]", "[truth]\nrotor_momentum_N_m_s = 0.005\n[initial]")],
    "angles with a skew that only the model knows": [(START, TURNED), (SKEW, "")],
}


@pytest.mark.parametrize("case", MOVING)
def test_momentum_that_is_not_zero_is_refused(tmp_path, case):
    with pytest.raises(InputError, match=r'initial_momentum: is "zero", but .*; use "estimated"'):
        read_scenario(started(tmp_path, *MOVING[case]))
    assert read_scenario(started(tmp_path, *MOVING[case], momentum="estimated"))


@pytest.mark.parametrize("case", STILL)
def test_momentum_that_is_zero_or_unknown_is_not(tmp_path, case):
    assert read_scenario(started(tmp_path, *STILL[case])).estimation.initial_momentum == "zero"


@pytest.mark.parametrize("case", MOVING)
def test_the_momentum_stated_is_that_of_the_simulated_platform(tmp_path, case):
    scenario = read_scenario(started(tmp_path, *MOVING[case], momentum="estimated"))
    platform, start = true_platform(scenario), scenario.initial
    momentum = platform_momentum(
        platform.cluster,
        platform.inertia,
        np.array(start.body_rate_rad_s),
        np.array(start.gimbal_angle_rad),
        np.zeros(6),
    )
    with pytest.raises(InputError) as caught:
        read_scenario(started(tmp_path, *MOVING[case]))
    message = f"starts with momentum of {np.linalg.norm(momentum):.3g} N·m·s"
    assert (message in str(caught.value)) != ("inertia of the model" in case)


def test_a_start_whose_body_balances_its_rotors_has_no_momentum(tmp_path):
    scenario = read_scenario(started(tmp_path, (START, TURNED), momentum="estimated"))
    platform = true_platform(scenario)
    rotors = platform_momentum(
        platform.cluster, platform.inertia, np.zeros(3), np.array([0.3, 0.1, -0.5, 0, 0, 0.9]), np.zeros(6)
    )
    rate = np.linalg.solve(platform.inertia, -rotors).tolist()
    balanced = started(tmp_path, (START, TURNED), (REST, f"body_rate_rad_s = {rate}"))
    assert read_scenario(balanced).estimation.initial_momentum == "zero"


def test_the_step_is_checked_against_the_rotor_servo_that_flies():
    assert ROTOR_SERVO_BANDWIDTH == FLOWN_BANDWIDTH
