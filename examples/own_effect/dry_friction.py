"""Dry friction of an air bearing that touches: a torque of constant size against the body rate."""

import numpy as np

import testbed as tb

CREEP = 1e-3
"""rad/s; below it the torque falls to zero smoothly, so that it has derivatives."""


class Friction(tb.Hooks):
    """How the effect enters the prediction; analytic in its value, without abs or comparisons."""

    def torque(self, value, at):
        """Return T = -c ω / √(|ω|² + ω₀²), shape (R, P, 3), N·m, for c of shape (P, 1)."""
        speed = np.sqrt((at.body_rate**2).sum(axis=-1, keepdims=True) + CREEP**2)
        return -value * at.body_rate / speed


class DryFriction(tb.Effect):
    """T = -c ω/|ω|, one coefficient for all axes."""

    id = "bearing_friction"
    components = ("platform",)
    parameters = (tb.Parameter(name="torque_N_m", unit="N·m", typical=5e-5, lower=0.0),)
    sentence = "A torque of constant size opposes the body rate, as a bearing that touches does."
    look_alikes = ("viscous_drag",)
    confirm = "The same maneuver at half the rate: dry friction brakes as hard."
    flies = False

    def hooks(self, component):
        """Return how it enters the prediction."""
        return Friction()

    def extension(self, component, values, scenario):
        """Return nothing: a flying model cannot have it yet."""
        return tb.Extension()
