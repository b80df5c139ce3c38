"""Six free gimbals and rotors on the free-floating platform, against Basilisk's VSCMG effector.

The trajectory was frozen by basilisk/make_trajectory.py, which writes the platform's numbers down once more and shares
no code with the testbed. The invariants stand beside the agreement: two codes can share a sign error.
"""

from pathlib import Path

import mujoco
import numpy as np
import pytest

HERE = Path(__file__).parent
MODEL = HERE.parents[1] / "models" / "platform.xml"
TRAJECTORY = HERE / "basilisk" / "trajectory.csv"

SHIPPED_STEP = 1.25e-3
BASILISK_STEP = 1.0e-3
NOMINAL_MOMENTUM = 0.004714  # Js Ω of one rotor, N·m·s


def units(kind):
    return [f"cmg{number}_{kind}" for number in range(1, 7)]


@pytest.fixture(scope="module")
def basilisk():
    with TRAJECTORY.open(encoding="utf-8") as lines:
        table = np.genfromtxt((line for line in lines if not line.startswith("#")), delimiter=",", names=True)

    def columns(signal, suffix, components="123456"):
        return np.stack([table[f"{signal}_{component}_{suffix}"] for component in components], axis=1)

    return {
        "time": table["time_s"],
        "body_rate": columns("body_rate", "rad_s", "xyz"),
        "gimbal_angle": columns("gimbal_angle", "rad"),
        "gimbal_rate": columns("gimbal_rate", "rad_s"),
        "rotor_speed": columns("rotor_speed", "rad_s"),
    }


@pytest.fixture
def model():
    """The shipped model with its gimbal motors' tachometer loops off: no motor exerts any torque."""
    spec = mujoco.MjSpec.from_file(str(MODEL))
    for name in units("gimbal_motor"):
        spec.actuator(name).biasprm[:] = 0.0
    return spec.compile()


def start(model, initial):
    """Return data in the trajectory's first state, `initial` being its first row by signal."""
    data = mujoco.MjData(model)
    data.qvel[3:6] = initial["body_rate"]  # a free joint's angular velocity is in body axes
    for joints, position, velocity in (("gimbal", "gimbal_angle", "gimbal_rate"), ("rotor", None, "rotor_speed")):
        for index, name in enumerate(units(joints)):
            data.joint(name).qvel = initial[velocity][index]
            data.joint(name).qpos = initial[position][index] if position else 0.0
    return data


def momentum_and_energy(model, data):
    """Return angular momentum about the centre of mass in N, N·m·s, and kinetic energy, J."""
    mujoco.mj_forward(model, data)
    mujoco.mj_subtreeVel(model, data)
    mujoco.mj_energyVel(model, data)
    return data.subtree_angmom[0].copy(), data.energy[1]


def fly(model, basilisk, step):
    """Return body rate, gimbal angle and rotor speed at Basilisk's sample times, then momentum and energy there."""
    model.opt.timestep = step
    data = start(model, {signal: series[0] for signal, series in basilisk.items()})
    body_rate, gimbal_angle, rotor_speed, momentum, energy = [], [], [], [], []
    for time in basilisk["time"]:
        while data.time < time - step / 2:
            mujoco.mj_step(model, data)
        assert data.time == pytest.approx(time, abs=1e-9)
        body_rate.append(data.qvel[3:6].copy())
        gimbal_angle.append([data.joint(name).qpos[0] for name in units("gimbal")])
        rotor_speed.append([data.joint(name).qvel[0] for name in units("rotor")])
        total, kinetic = momentum_and_energy(model, data)
        momentum.append(total)
        energy.append(kinetic)
    return tuple(np.array(series) for series in (body_rate, gimbal_angle, rotor_speed, momentum, energy))


# At Basilisk's own step both integrators are the same RK4 and only rounding is left, which the swinging gimbals amplify
# (measured 3.5e-11). The shipped step is held to the figure promised: what differs is the step's error (measured
# 5.7e-9), not the model.
@pytest.mark.parametrize(("step", "tolerance"), [(BASILISK_STEP, 1e-9), (SHIPPED_STEP, 1e-6)])
def test_body_rate_agrees_with_basilisk(model, basilisk, step, tolerance):
    body_rate, *_ = fly(model, basilisk, step)
    error = np.abs(body_rate - basilisk["body_rate"]).max()
    print(f"body rate against Basilisk at {step * 1e3:g} ms: {error:.1e} rad/s")
    assert np.abs(basilisk["body_rate"]).max() > 0.03  # something moved
    assert error <= tolerance


def test_gimbals_and_rotors_agree_with_basilisk(model, basilisk):
    _, gimbal_angle, rotor_speed, _, _ = fly(model, basilisk, BASILISK_STEP)
    assert np.ptp(basilisk["gimbal_angle"], axis=0).min() > 0.5  # every gimbal moved
    # A gimbal turns some thirty times as fast as the platform, and its error grows alike.
    np.testing.assert_allclose(gimbal_angle, basilisk["gimbal_angle"], rtol=0, atol=1e-7)
    np.testing.assert_allclose(rotor_speed, basilisk["rotor_speed"], rtol=0, atol=1e-7)


def test_free_flight_conserves_momentum_and_energy(model, basilisk):
    *_, momentum, energy = fly(model, basilisk, BASILISK_STEP)
    momentum_drift = np.linalg.norm(momentum - momentum[0], axis=1).max() / (6 * NOMINAL_MOMENTUM)
    energy_drift = np.abs(energy / energy[0] - 1).max()
    print(f"momentum drift {momentum_drift:.1e} of 6 h0, energy drift {energy_drift:.1e} of the kinetic energy")
    # RK4 at 1 ms drifts by its truncation error only.
    assert momentum_drift <= 1e-9
    assert energy_drift <= 1e-9
