"""A body that thrusters turn: its scenario from a text, and its rate by SciPy's integration of Euler's equation."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
from scipy.integrate import solve_ivp

from support.vectors import cross
from testbed.arrays import Matrix3, Series, Vector3, Vectors3
from testbed.files import TextFile
from testbed.scenario.body import BodyScenario
from testbed.scenario.reader import body_scenario_of


def body_scenario(text: str, file: str) -> BodyScenario:
    """Return the scenario that a file of this name and text holds."""
    return body_scenario_of(TextFile(path=Path(file), content=text.encode(), text=text))


def turned(time: Series, rate: Vector3, inertia: Matrix3, torque_B: Callable[[float], Vector3]) -> Vectors3:
    """Return the body rate at given times, from the first on, shape (N, 3), rad/s.

    Args:
        time: shape (N,), s.
        rate: at the first of them, rad/s.
        inertia: shape (3, 3), kg·m².
        torque_B: at any time, N·m; without jumps.
    """
    inverse = np.linalg.inv(inertia)
    solution = solve_ivp(
        lambda at, body_rate: inverse @ (torque_B(at) - cross(body_rate, inertia @ body_rate)),
        time[[0, -1]],
        rate,
        t_eval=time,
        rtol=1e-11,
        atol=1e-14,
    )
    return np.asarray(solution.y.T)


def turned_by_held(time: Series, rate: Vector3, inertia: Matrix3, torque_B: Vectors3) -> Vectors3:
    """Return the body rate under torques that are each held from a time to the next; as `turned`, between two jumps.

    Args:
        time: shape (N,), s.
        rate: at the first of them, rad/s.
        inertia: shape (3, 3), kg·m².
        torque_B: from each time on, shape (N, 3), N·m; the last one is not used.
    """
    rates = [rate]
    for number, held in enumerate(torque_B[:-1]):
        rates.append(turned(time[number : number + 2], rates[-1], inertia, lambda _, held=held: held)[-1])
    return np.array(rates)
