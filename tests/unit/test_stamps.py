"""How unevenly rows are stamped, and what of a wheel's delay that leaves open."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from testbed.effects.wheel_delay import WheelDelay
from testbed.effects.wheel_lag import WheelLag
from testbed.prediction.stamps import stamp_jitter


def jittered(std: float, lost: int = 0) -> SimpleNamespace:
    time = np.arange(2000) * 0.1 + np.random.default_rng(4).normal(0.0, std, 2000)
    return SimpleNamespace(actuator_time=np.delete(time, np.arange(100, 100 + 7 * lost, 7)))


@pytest.mark.parametrize("lost", [0, 20])
def test_jitter_is_that_of_the_stamps_whatever_is_lost(lost):
    assert stamp_jitter([jittered(3e-4, lost), jittered(3e-4)]) == pytest.approx(3e-4, rel=0.05)


def test_an_even_clock_leaves_nothing_open():
    assert stamp_jitter([jittered(0.0)]) < 1e-12


@pytest.mark.parametrize("effect", [WheelDelay(), WheelLag()])
def test_a_delay_of_the_size_of_the_jitter_is_not_resolved(effect):
    grid = SimpleNamespace(runs=[jittered(3e-4)])
    assert effect.unresolved(grid) == pytest.approx([3e-4], rel=0.05)
