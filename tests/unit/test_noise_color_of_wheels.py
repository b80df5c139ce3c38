"""A colour that tachometers put into the residual is none of the gyro's."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from testbed.effects.gyro_noise_color import GyroNoiseColor
from testbed.effects.noise_effect import Readings
from testbed.estimation.noise_spectrum import NoiseSpectrum

GYRO = 8e-6


def run(lines):
    """Three wheels of 2e-3 kg·m² along the axes, whose speeds are counted in lines of their turn for 0.1 s."""
    rng = np.random.default_rng(3)
    angle = 0.1 * np.cumsum(100.0 + 5.0 * np.sin(0.05 * np.arange(401))[:, None] + rng.random(3), axis=0)
    counted = np.floor(angle * lines / (2.0 * np.pi)) * 2.0 * np.pi / lines
    wheels = SimpleNamespace(wheels=SimpleNamespace(axis_B=np.eye(3)), momentum=2e-3 * np.diff(counted, axis=0) / 0.1)
    return SimpleNamespace(live=np.arange(3), gimbals=None, cluster_momentum=None, wheels=wheels)


def p_value(color, telemetry):
    shown = 5.0 * np.eye(3)
    readings = Readings(
        measured=[],
        residual=[],
        sigma=np.full((1, 3), 1.5 * GYRO),
        runs=[telemetry],
        inertia=shown,
        parameters=6,
        spectrum=NoiseSpectrum(
            variance_ratio=np.ones((1, 3)), correlation=np.full(3, color), color=color, color_std=0.025, freedom=300.0
        ),
    )
    return GyroNoiseColor().found("gyro", readings).p_value


def test_counted_lines_that_make_much_of_the_residual_explain_its_colour():
    assert p_value(-0.2, run(lines=1024)) == pytest.approx(1.0)


@pytest.mark.parametrize("color", [-0.6, 0.2])
def test_a_colour_that_no_tachometer_makes_is_the_gyros(color):
    assert p_value(color, run(lines=1024)) < 1e-3


def test_a_colour_is_the_gyros_where_tachometers_are_fine():
    assert p_value(-0.2, run(lines=20_000)) < 1e-6


def test_a_colour_is_the_gyros_where_no_wheel_turns():
    without = SimpleNamespace(live=np.arange(3), gimbals=None, cluster_momentum=None, wheels=None)
    assert p_value(-0.2, without) < 1e-6
