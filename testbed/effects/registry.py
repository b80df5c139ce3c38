"""All named effects, in the order in which reports list them."""

from __future__ import annotations

from collections.abc import Mapping

from testbed.effects.contract import Effect
from testbed.effects.gyro_latency import GyroLatency
from testbed.effects.rotor_speed import RotorSpeed
from testbed.effects.viscous_drag import ViscousDrag

_ALL: tuple[Effect, ...] = (ViscousDrag(), RotorSpeed(), GyroLatency())

EFFECTS: Mapping[str, Effect] = {effect.id: effect for effect in _ALL}
"""By id."""
