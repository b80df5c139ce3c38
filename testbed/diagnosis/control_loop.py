"""What flights show whose commands a controller makes of the body rate: constant torques, and little else.

Draughts turn the platform, the controller answers, and records hold what it makes of the body rate, whatever the
actuators do. What an effect makes of changing commands, or of the motion, is therefore found in healthy flights too, of
another size in each; the mean torque that holds the platform is of the platform (docs/explanation/real-flight.md).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from testbed.arrays import Array
from testbed.diagnosis.data import Runs
from testbed.diagnosis.model import Fit
from testbed.effects.actuator_gain import ActuatorGain
from testbed.effects.contract import Effect
from testbed.prediction.grid import Grid
from testbed.prediction.hooks import Hooks, Instant

NO_FEEDBACK = "commands that no controller makes of the body rate"
"""What is missing to test for an effect that acts on what changes alone."""


def with_mean_thrust(runs: Runs) -> Runs:
    """Return windows in which each actuator's thrust is its mean over the record; as they are where none is known.

    The torque that all of them make together stays as it is.
    """
    thrust = runs.grid.thrust
    if thrust is None:
        return runs
    windows = [run.thrust for run in runs.grid.runs if run.thrust is not None]
    means = [
        np.concatenate([windows[index] for index in np.flatnonzero(runs.record_of == number)]).mean(axis=0)
        for number in range(len(runs.record_names))
    ]
    own = np.array(means)[runs.record_of]
    of_runs = zip(runs.grid.runs, windows, own, strict=True)
    held = tuple(replace(run, thrust=_held(window, mean)) for run, window, mean in of_runs)
    return replace(runs, grid=replace(runs.grid, runs=held, thrust=_held(thrust, own[:, None, None])))


def _held(samples: Array, mean: Array) -> Array:
    return np.broadcast_to(mean, samples.shape).copy()


def acts_steadily(effect: Effect, grid: Grid) -> bool:
    """Return whether an effect is a constant torque, or reads as one, while the platform rests under constant commands.

    Args:
        effect: any; what holds of its first component holds of all.
        grid: of runs that it is to be tested on.
    """
    hooks = effect.hooks(effect.components[0])
    typical = np.array([[parameter.typical for parameter in effect.parameters]])
    return not hooks.states and (_changes_torque(hooks, typical, grid) or _reads_as_torque(hooks, typical))


def _changes_torque(hooks: Hooks, typical: Array, grid: Grid) -> bool:
    """Return whether an effect adds a constant to the torque of constant commands, or to none."""
    samples = grid.time.shape[1]
    asked_B = _held(grid.applied_torque_B, grid.applied_torque_B.mean(axis=2, keepdims=True))
    thrust = None if grid.thrust is None else _held(grid.thrust, grid.thrust.mean(axis=2, keepdims=True))
    steady = replace(grid, applied_torque_B=asked_B, thrust=thrust)
    given_B = hooks.actuator_response(hooks.asked_torque(asked_B, typical, steady), typical, steady)
    change_B = hooks.applied_torque(given_B[:, :, -samples:], typical, steady) - asked_B[:, :, -samples:]
    largest = float(np.abs(change_B).max())
    if largest > _ROUNDING * float(np.abs(asked_B).max()):
        return float(np.abs(change_B - change_B[:, :, :1]).max()) < _ROUNDING * largest
    at_rest = Instant(
        time=np.zeros((1, 1)), body_rate=np.zeros((1, 1, 3)), attitude=np.eye(3), state=np.zeros((1, 1, 0))
    )
    return bool(np.any(hooks.torque(typical, at_rest)))


def _reads_as_torque(hooks: Hooks, typical: Array) -> bool:
    """Return whether a gyro at rest reads a rate that grows with time."""
    start, later = hooks.gyro_reading(np.zeros((1, 2, 3)), typical, np.array([0.0, 1.0]), 0)[0]
    return not np.array_equal(start, later)


_ROUNDING = 1e-9
"""Share of a torque below which a difference is one of rounding.

Source: formula: between rounding, 1e-16 times what a filter multiplies it by, and a typical effect, 1e-3 and more."""


def shows_the_loop(runs: Runs, model: Fit) -> bool:
    """Return whether commands explain so little of the motion that records show the controller's answer to it.

    The geometric mean over the axes counts: about one axis an effect may still be missing.

    Args:
        runs: that the model was fitted to.
        model: any.
    """
    gains = [each for each in model.placed if each.given and isinstance(each.effect, ActuatorGain)]
    if not runs.known_in_part or not gains:
        return False
    logarithms = model.effect_values[model.own(gains[0])]
    return not gains[0].effect.parameters[0].is_plausible(float(logarithms.mean()))
