"""Random formulas, and a rigid body that MuJoCo and the prediction turn by them."""

from __future__ import annotations

import numpy as np
from hypothesis import strategies as st

from testbed.arrays import Array
from testbed.dynamics.inertia import theta_of
from testbed.estimation.telemetry import Telemetry
from testbed.formulas.law import Law
from testbed.formulas.motion import ATTITUDES, RATES
from testbed.formulas.parser import parsed
from testbed.formulas.pattern import PLACEMENTS, Pattern
from testbed.plant.build import build
from testbed.plant.plant import Plant
from testbed.plant.properties import InitialState, PlatformProperties
from testbed.prediction.formula_hooks import formula_hooks
from testbed.prediction.grid import grid_of
from testbed.prediction.integration import Values, node_rates

INERTIA = np.array([[0.022, 1e-3, 0.0], [1e-3, 0.024, -5e-4], [0.0, -5e-4, 0.027]])
DURATION, STEP = 0.5, 1.0 / 1024.0
"""s; MuJoCo turns attitudes on by second-order steps, which leave 2e-9 rad/s at 1024 Hz."""


def laws(smooth: bool = True) -> st.SearchStrategy[Law]:
    """Return laws of one to three factors, with any memory; without corners where smooth."""
    number = st.floats(0.1, 2.0).map(lambda value: round(value, 3))
    plain = st.sampled_from(
        [*RATES, *ATTITUDES, "t", "norm(w)", *([] if smooth else [f"abs({rate})" for rate in RATES])]
    )
    wave = st.builds("{}(2*pi*{}*t)".format, st.sampled_from(["sin", "cos"]), number)
    pulse = st.builds("pulse({}, {})".format, st.floats(0.2, 0.8), st.floats(0.1, 0.3))
    product = st.lists(plain | wave | pulse, min_size=1, max_size=3).map("*".join)
    memory = st.sampled_from(["lag", "delay"] if smooth else ["lag", "delay", "hysteresis"])
    return (product | st.builds("{}({}, {})".format, memory, product, number)).map(parsed)


def patterns(smooth: bool = True) -> st.SearchStrategy[Pattern]:
    """Return laws along an axis of the body, or in a direction of the body or of space."""
    one = laws(smooth).map(lambda law: (law,))
    return st.builds(lambda many, place: Pattern(laws=many, placement=place), one, st.sampled_from(PLACEMENTS))


def in_mujoco(pattern: Pattern, sizes: Array, body_rate: Array) -> Array:
    """Return the body rate at every integrator step, shape (N, 3), rad/s."""
    attitude = np.array([0.5, -0.5, 0.5, 0.5])
    start = InitialState(
        body_rate=body_rate, attitude=attitude, position=np.zeros(3), velocity=np.zeros(3), gimbal_angle=np.zeros(0)
    )
    properties = PlatformProperties(units=0, inertia=INERTIA, mass=4.0, step=STEP)
    plant = Plant([build(properties)], initial=[start], rotor_momentum=np.zeros((1, 0)), torques=pattern.torques(sizes))
    rates = [plant.body_rate[0].copy()]
    for _ in range(round(DURATION / STEP)):
        plant.advance(np.zeros((1, 0)), 1)
        rates.append(plant.body_rate[0].copy())
    assert not plant.divergence
    return np.array(rates)


def predicted_rates(pattern: Pattern, sizes: Array, body_rate: Array, step: float = STEP) -> Array:
    """Return the predicted body rate at every node of the grid, shape (N, 3), rad/s."""
    time = np.linspace(0.0, DURATION, round(DURATION / step) + 1)
    run = Telemetry(
        gyro_time=time,
        body_rate=np.tile(body_rate, (len(time), 1)),
        gyro_noise=1e-3,
        gimbals=None,
        actuator_time=time,
        applied_torque=np.zeros((len(time), 3)),
    )
    values = Values(
        theta=theta_of(INERTIA)[None], initial_rate=body_rate[None, None], effects=(np.asarray(sizes)[None],)
    )
    return np.asarray(node_rates(grid_of([run], step), [formula_hooks(pattern)], values)[0, 0])
