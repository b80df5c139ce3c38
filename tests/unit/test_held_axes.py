"""A table that turns about two axes, and one under one wheel: what they cannot show has no name."""

from __future__ import annotations

import numpy as np
import pytest

from support.thrusters import body_scenario
from support.vectors import cross
from testbed.assembly.platform import nominal_body
from testbed.diagnosis.findings import additions
from testbed.diagnosis.fitting import fitted
from testbed.diagnosis.method import diagnosed
from testbed.diagnosis.model import independent
from testbed.diagnosis.reading import data_set_of
from testbed.diagnosis.torque_shapes import torque_shapes
from testbed.diagnosis.torque_space import torque_responses
from testbed.diagnosis.trims import with_one_trim
from testbed.dynamics.inertia import theta_of
from testbed.effects.registry import EFFECTS
from testbed.records.record import Record, RunDetails
from tests.unit.test_measured_actuators import RIG

NOISE = 1e-3
INERTIA = np.array([[0.9, 0.02, 0.03], [0.02, 1.1, 0.0], [0.03, 0.0, 1.25]])
TABLE = """
schema = 1
name = "table"
description = "A table that turns about x and z."
seed = 1

[platform]
inertia_kg_m2 = [[1.0, 0.0, 0.0], [0.0, 1.1, 0.0], [0.0, 0.0, 1.1]]
axes = ["x", "z"]

[gyro]
sample_rate_hz = 20.0
noise_rad_s = 1e-3

[diagnosis]
applied_torque = "held"
"""
LIVE = [0, 2]


def table_run(seed: int, drag: float) -> Record:
    """Fifteen seconds under torques that are held for 0.2 s, integrated in steps of 10 ms."""
    rng = np.random.default_rng(seed)
    inverse, step, rate = np.linalg.inv(INERTIA[np.ix_(LIVE, LIVE)]), 0.01, np.zeros(3)
    time, torques, rates = 0.05 * np.arange(300), np.full((300, 3), np.nan), np.empty((300, 3))

    def slope(rate, torque):
        acting = torque - cross(rate, INERTIA @ rate) - drag * rate
        return np.insert(inverse @ acting[LIVE], 1, 0.0)

    for index in range(300):
        if index % 4 == 0:
            wanted = 0.3 * np.sin(np.array([0.9, 0.0, 0.7]) * time[index] + seed)
            torque = np.where([True, False, True], 0.8 * (wanted - rate), 0.0)
            torques[index] = torque
        rates[index] = rate
        for _ in range(5):
            middle = rate + 0.5 * step * slope(rate, torque)
            rate = rate + step * slope(middle, torque)
    rates = rates + rng.normal(0.0, NOISE, rates.shape)
    rates[:, 1] = np.nan
    details = RunDetails(name=f"run{seed}", gyro_noise=NOISE)
    return Record(time=time, channels={"body_rate": rates, "applied_torque": torques}, details=details)


def table(drag: float):
    scenario = body_scenario(TABLE, "table.toml")
    nominal = nominal_body(scenario)
    data = data_set_of([table_run(seed, drag) for seed in range(1, 5)], scenario, nominal)
    return data, theta_of(nominal.inertia)


def test_a_healthy_table_of_two_axes_lacks_nothing():
    """A torque about the axis that is held left rounding, of which an oscillation was made with p = 5e-143."""
    data, theta = table(drag=0.0)
    effects = {name: EFFECTS[name] for name in ("viscous_drag", "gyro_latency")}
    *_, state = diagnosed(data.runs, data.heldout, effects, theta)
    assert state.verdict == "none"
    assert state.model.shown[:6].tolist() == [True, False, True, True, True, True]
    fit = fitted(with_one_trim(data.runs), [], theta, [])
    for response in torque_responses(data.runs, fit, 40):
        assert not response.reshape(len(response), -1, 3)[:, :, 1].any()
        assert response.any()


def test_drag_of_a_table_of_two_axes_keeps_its_name():
    """Products with the rate about the held axis had the evidence of 7.6 million, and took the name back."""
    data, theta = table(drag=0.05)
    effects = {name: EFFECTS[name] for name in ("viscous_drag", "gyro_latency")}
    *_, state = diagnosed(data.runs, data.heldout, effects, theta)
    (added,) = additions(state)
    assert added.effect.id == "viscous_drag"
    shapes = torque_shapes(data.runs, state.model)
    assert max(shape.evidence for shape in shapes) < 30.0
    for quantity in added.quantities:
        if quantity.name != "coefficient_y_N_m_s_rad":
            assert quantity.value == pytest.approx(0.05, abs=4.0 * quantity.std)


def test_what_rounding_leaves_of_a_direction_is_none():
    columns = np.array([[1.0, 1.0, 0.0], [0.0, 0.0, 2.0]])
    information = columns.T @ columns
    information[0, 1] = information[1, 0] = 1.0 + 1e-9  # more than their lengths allow
    kept, slope = independent(information, np.array([5.0, 4.0, 2.0]))
    assert np.linalg.eigvalsh(kept).min() > -1e-12
    np.testing.assert_allclose(slope, [4.5, 4.5, 2.0], atol=1e-8)


def wheel_run(seed: int, larger: float) -> Record:
    """A table without friction under one wheel, J ω + Jw Ω = 0, whose spin inertia is larger by a share."""
    rng = np.random.default_rng(seed)
    time, spin = 0.05 * np.arange(800), 1e-4 * (1.0 + larger)
    torque = 2e-3 * np.sin(np.array([[0.5], [0.9], [1.7]]) * time + rng.uniform(0.0, 6.0, (3, 1))).sum(axis=0)
    momentum = np.concatenate([[0.0], np.cumsum(0.05 * torque[:-1])])  # torque held for 0.05 s
    rate = -momentum / (0.055 - spin)  # of the table without its wheel
    rates = np.full((len(time), 3), np.nan)
    rates[:, 2] = rate + rng.normal(0.0, NOISE, len(time))
    speed = momentum / spin - rate
    channels = {
        "body_rate": rates,
        "wheel_speed": speed,
        "wheel_torque": torque * (1.0 + 0.01 * rng.standard_normal(800)),
    }
    shaped = {name: values if values.ndim == 2 else values[:, None] for name, values in channels.items()}
    return Record(time=time, channels=shaped, details=RunDetails(name=f"run{seed}", gyro_noise=NOISE))


@pytest.mark.parametrize("larger", [0.0, 0.04])
def test_one_wheel_and_its_torque_do_not_shrink_together_with_the_inertia(larger):
    """The noise of the wheel's impulses shrank with them: both had names with -50 %, and J33 was 27.5 ± 0.6."""
    scenario = body_scenario(RIG, "rig.toml")
    nominal = nominal_body(scenario)
    data = data_set_of([wheel_run(seed, larger) for seed in range(1, 5)], scenario, nominal)
    effects = {name: EFFECTS[name] for name in ("wheel_inertia", "wheel_torque_scale", "viscous_drag")}
    *_, state = diagnosed(data.runs, data.heldout, effects, theta_of(nominal.inertia))
    if not larger:
        assert state.verdict == "none"
        return
    (added,) = additions(state)
    alike = {added.effect.id, *(each.effect.id for each in added.look_alikes)}
    assert alike == {"wheel_inertia", "wheel_torque_scale"}
    if added.effect.id == "wheel_inertia":
        assert added.quantities[0].value == pytest.approx(larger, abs=4.0 * added.quantities[0].std)
        assert state.model.theta[2] == pytest.approx(0.055, abs=1e-4)
