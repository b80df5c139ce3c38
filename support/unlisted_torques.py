"""Torques on the platform that no effect of the library makes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from typing_extensions import override

from testbed.prediction.hooks import Hooks


class Growing(Hooks):
    """In proportion to time."""

    @override
    def torque(self, value, at):
        return value[:, :1] * at.time[..., None] * np.array([1.0, -0.5, 0.3])


@dataclass(frozen=True)
class Humming(Hooks):
    """A sine."""

    frequency_hz: float

    @override
    def torque(self, value, at):
        wave = np.sin(2.0 * np.pi * self.frequency_hz * at.time[..., None])
        return value[:, :1] * wave * np.array([1.0, 0.5, 0.0])


class Pulsing(Hooks):
    """Every 0.8 s, from 0.3 s on."""

    @override
    def torque(self, value, at):
        since = (at.time[..., None] - 0.3 + 0.4) % 0.8 - 0.4
        return value[:, :1] * np.exp(-0.5 * (since / 0.03) ** 2) * np.array([0.5, 1.0, -0.4])
