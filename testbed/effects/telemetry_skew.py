"""The telemetry of the actuators is on another clock than the gyro's."""

from __future__ import annotations

from dataclasses import replace
from typing import final

from typing_extensions import override

from testbed.arrays import Array
from testbed.effects.actuator_response import skewed
from testbed.effects.contract import Effect, Extension, Parameter
from testbed.prediction.grid import Gimbals, Grid
from testbed.prediction.hooks import Hooks
from testbed.scenario.scenario import Scenario


class _Skewed(Hooks):
    predicts_gimbals = False  # on their own clock the gimbals' channels agree, with the body's motion on it

    @override
    def gimbals(self, gimbals: Gimbals, value: Array, grid: Grid) -> Gimbals:
        """What is recorded at t was so at t - s: what is so at t is recorded at t + s."""
        angle, rate, momentum = (
            skewed(each, grid, value[:, 0]) for each in (gimbals.angle, gimbals.rate, gimbals.rotor_momentum)
        )
        return replace(gimbals, angle=angle, rate=rate, rotor_momentum=momentum)

    @override
    def telemetry_lateness(self, value: Array) -> Array:
        return value[:, 0]

    @override
    def cluster_momentum(self, momentum_B: Array, value: Array, grid: Grid) -> Array:
        """Leave chords as they are, and read the gyro at other times: shifted, their corners lay between nodes."""
        if grid.gimbals is not None or grid.momentum_held:
            return momentum_B
        return skewed(momentum_B, grid, value[:, 0])

    @override
    def actuator_response(self, asked_B: Array, value: Array, grid: Grid) -> Array:
        return asked_B if grid.torque_held else skewed(asked_B, grid, value[:, 0])

    @override
    def held_torque_delay(self, value: Array) -> Array:
        return -value[:, 0]


@final
class TelemetrySkew(Effect):
    """What the actuators' telemetry shows at t was so at t - s by the gyro's clock; s is negative where it is early."""

    id = "telemetry_skew"
    components = ("actuators",)
    parameters = (Parameter(name="late_s", unit="s", typical=0.01, lower=-0.5, upper=0.5, plausible=(-0.2, 0.2)),)
    sentence = "The telemetry of the actuators is late, or early where negative, against the gyro's."
    look_alikes = ("gyro_latency", "actuator_delay")
    confirm = "An impulse on platform and actuator at once: each stream shows it at its own time."
    yields_to = ("gyro_latency", "gyro_bandwidth", "actuator_delay", "actuator_lag")
    flies = False  # a flight has one clock

    @override
    def hooks(self, component: str) -> Hooks:
        return _Skewed()

    @override
    def extension(self, component: str, values: Array, scenario: Scenario) -> Extension:
        return Extension()
