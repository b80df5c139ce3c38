"""Flights of a platform with effects built in, and what predictions miss of them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from testbed.arrays import Array
from testbed.assembly.extension import extended, write_extended
from testbed.assembly.platform import PlatformModel, nominal_platform
from testbed.assembly.telemetry import telemetry_of
from testbed.dynamics.inertia import theta_of
from testbed.effects.contract import Extension
from testbed.estimation.telemetry import Telemetry
from testbed.experiment.conduct import conduct
from testbed.experiment.experiment import Experiment
from testbed.prediction.compared import compared
from testbed.prediction.grid import grid_of
from testbed.prediction.hooks import Hooks
from testbed.prediction.integration import Values, node_rates
from testbed.prediction.motor_torques import measured_torques, motor_torques
from testbed.prediction.prediction import predicted
from testbed.prediction.servo_response import measured_responses, servo_responses
from testbed.prediction.smoothed import gimbal_motion
from testbed.scenario.reader import read_scenario
from testbed.scenario.scenario import Scenario
from testbed.scenario.shipped import shipped_scenario

STICKING = 0.05
"""rad/s. Below, a dry friction takes any value within its limits, and MuJoCo's gimbals creep."""


@cache
def scenario(body_rate: tuple[float, float, float] = (0.2, -0.6, 0.3)) -> Scenario:
    """A short noise-free flight, released with spin; its gimbals start smoothly, so that samples of them tell all."""
    shipped = read_scenario(shipped_scenario("diagnose"))
    turns = np.cumsum(np.random.default_rng(3).uniform(-0.4, 0.4, (5, 6)), axis=0)
    change = {
        "initial": {"body_rate_rad_s": list(body_rate)},
        "gyro": {"noise_rad_s": 0.0},
        "encoder": {"noise_rad": 0.0},
        "tachometer": {"noise_rad_s": 0.0},
        "torque_sensor": {"noise_N_m": 0.0},
        "simulation": {"duration_s": 1.25, "control_rate_hz": 160.0, "telemetry_rate_hz": 160.0},
        "controller": {"feedback_gain_1_s": 1.0},
        "estimation": {"initial_momentum": "estimated", "estimators": ["iv_momentum"]},
    }
    spline = {
        "kind": "control_points",
        "parametrization": "gimbal",
        "duration_s": 2.0,
        "gimbal_angle_rad": np.vstack([np.zeros((3, 6)), turns]).tolist(),
    }
    changed = extended(shipped, Extension(scenario=change))
    return Scenario.model_validate(changed.model_dump(by_alias=True, exclude_unset=True) | {"maneuver": spline})


@cache
def nominal() -> PlatformModel:
    return nominal_platform(scenario())


@dataclass(frozen=True, kw_only=True)
class Flight:
    released: Scenario
    experiment: Experiment
    telemetry: Telemetry

    def values(self, *effects: Array, further_rate: Array | float = 0.0) -> Values:
        """The nominal inertia, the release, and the effects' sizes."""
        return Values(
            theta=theta_of(nominal().inertia)[None],
            initial_rate=(np.array(self.released.initial.body_rate_rad_s) + further_rate)[None, None],
            effects=tuple(size[None] for size in effects),
        )

    def missed(self, hooks: list[Hooks], values: Values) -> Array:
        """What the gyro read less the prediction, shape (N, 3), rad/s."""
        return np.asarray(self.telemetry.body_rate - predicted(grid_of([self.telemetry]), hooks, values)[0][0])

    def missed_from_any_start(self) -> Array:
        """What the nominal model leaves whatever the initial rate was, shape (N, 3), rad/s."""
        plain, step = self.missed([], self.values()), 1e-6
        turned = [self.missed([], self.values(further_rate=step * axis)) - plain for axis in np.eye(3)]
        columns = np.stack(turned, axis=-1).reshape(-1, 3) / step
        return plain - (columns @ np.linalg.lstsq(columns, plain.ravel())[0]).reshape(-1, 3)

    def residual(self, hooks: list[Hooks], *effects: Array) -> float:
        """Largest difference of the prediction from what the gyro read, rad/s."""
        return float(np.abs(self.missed(hooks, self.values(*effects))).max())

    def response_residual(self, hooks: list[Hooks], *effects: Array) -> float:
        """Largest difference of the gimbals' predicted responses to their commands from those measured, rad."""
        grid, sizes = grid_of([self.telemetry]), self.values(*effects).effects
        return float(np.abs(servo_responses(grid, hooks, sizes)[0] - measured_responses(grid)[0]).max())

    def torque_residual(self, hooks: list[Hooks], *effects: Array) -> float:
        """Largest difference of the predicted torques of turning motors from those measured, N·m."""
        grid, values = grid_of([self.telemetry]), self.values(*effects)
        (torques,) = motor_torques(grid, hooks, values.effects, node_rates(grid, hooks, values))[0]
        run = grid.runs[0]
        turning = np.abs(gimbal_motion(run)(run.actuator_time[compared(run)], 1)) > STICKING
        return float(np.abs(torques - measured_torques(grid)[0])[turning].max())


def flown(extensions: list[Extension], folder: Path, released: Scenario | None = None) -> Flight:
    """Write the extended model, read it back and fly it; telemetry is taken for what the nominal model says it is."""
    start = scenario() if released is None else released
    experiment = conduct(read_scenario(write_extended(start, extensions, nominal().inertia, folder)), seed=1)
    telemetry = telemetry_of(experiment.flown.record, start, nominal())
    return Flight(released=start, experiment=experiment, telemetry=telemetry)
