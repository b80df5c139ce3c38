"""Loops as machine code: the same results as without, and nothing of it where runs are short."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest

from support.processes import ROOT
from support.synthetic_telemetry import TRUE_THETA, exact_telemetry, nominal_flight, sample_times
from testbed.estimation import motion, sensitivity
from testbed.estimation.motion import drive_of, simulate
from testbed.estimation.sensitivity import rate_sensitivity
from testbed.rotation import kinematics
from testbed.rotation.kinematics import integrate_attitude

MOMENTUM_B = np.array([0.003, -0.004, 0.006])
TELEMETRY = exact_telemetry(nominal_flight(MOMENTUM_B), sample_times(100.0), sample_times(100.0))


@pytest.fixture
def compile_all(monkeypatch):
    """Return what makes machine code of every loop, however short."""

    def take() -> None:
        for room in (motion, sensitivity, kinematics):
            monkeypatch.setattr(room, "LONG", 0)

    return take


def test_the_motion_is_the_same_to_the_last_bit(compile_all):
    drive = drive_of(TELEMETRY)
    before = simulate(drive, TRUE_THETA, MOMENTUM_B)
    compile_all()
    after = simulate(drive, TRUE_THETA, MOMENTUM_B)
    np.testing.assert_array_equal(after.momentum_B, before.momentum_B)
    np.testing.assert_array_equal(after.body_rate, before.body_rate)


def test_the_sensitivities_are_the_same(compile_all):
    drive = drive_of(TELEMETRY)
    flown = simulate(drive, TRUE_THETA, MOMENTUM_B)
    before = rate_sensitivity(drive, flown)
    compile_all()
    # A product of small matrices may be rounded differently by NumPy: 1e-16 in each of 160 steps.
    np.testing.assert_allclose(rate_sensitivity(drive, flown), before, rtol=0.0, atol=1e-13 * np.abs(before).max())


def test_the_attitude_is_the_same(compile_all):
    before = integrate_attitude(TELEMETRY.gyro_time, TELEMETRY.body_rate)
    compile_all()
    after = integrate_attitude(TELEMETRY.gyro_time, TELEMETRY.body_rate)
    np.testing.assert_allclose(after, before, rtol=0.0, atol=1e-14)  # 500 products, each rounded once


def test_an_attitude_of_many_samples_stays_a_rotation_and_turns_by_what_it_should():
    time = np.linspace(0.0, 100.0, 20_001)
    attitude = integrate_attitude(time, np.tile([0.0, 0.0, 0.3], (len(time), 1)))
    np.testing.assert_allclose(np.linalg.norm(attitude, axis=1), 1.0, atol=1e-15)
    np.testing.assert_allclose(attitude[-1], [np.cos(15.0), 0.0, 0.0, np.sin(15.0)], atol=1e-12)


def test_short_runs_do_not_even_import_the_compiler():
    code = (
        "import sys, numpy as np\n"
        "from testbed.rotation.kinematics import integrate_attitude\n"
        "import testbed.estimation.registry, testbed.cli.run\n"
        "integrate_attitude(np.linspace(0, 5, 80), np.zeros((80, 3)))\n"
        "assert 'numba' not in sys.modules\n"
    )
    subprocess.run([sys.executable, "-c", code], cwd=ROOT, check=True, capture_output=True)
