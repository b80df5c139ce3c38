"""Fit the inertia through the simulator with mujoco.sysid, in an environment of its own: nothing of the testbed here.

python sysid_fit.py CASE.json   prints, as JSON, one {"seconds", "theta_kg_m2"} per record of the case

The gimbals of the fitted model follow the measured angles by stiff position servos with rate feed-forward (noise-free,
what they miss moves the inertia by less than a tenth of the bound at 1.25 ms); the rotors keep their speed, the body is
free, and what is fitted is the body rate at the gyro's samples.
"""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from mujoco import sysid
from scipy.interpolate import CubicSpline

SERVO_STIFFNESS = 1.0
"""Natural frequency of a gimbal's servo times the step: RK4 bears 2.8."""
DAMPING = 0.7
SCALE = 0.01
"""kg m2; the fit's parameters are of order one."""


def prepared(case: dict[str, Any]) -> mujoco.MjSpec:
    """Return the platform with position servos on its gimbals and a gyro on its bus."""
    spec = mujoco.MjSpec.from_file(case["model"])
    spec.option.timestep = case["step_s"]
    for actuator in [a for a in spec.actuators if "gimbal" in a.name]:
        spec.delete(actuator)
    frequency, inertia = SERVO_STIFFNESS / case["step_s"], case["gimbal_axis_inertia_kg_m2"]
    for number in range(1, 7):
        joint = f"cmg{number}_gimbal"
        spec.joint(joint).actfrclimited = False
        on_joint = {"target": joint, "trntype": mujoco.mjtTrn.mjTRN_JOINT}
        spec.add_actuator(name=f"cmg{number}_angle", **on_joint).set_to_position(kp=inertia * frequency**2)
        spec.add_actuator(name=f"cmg{number}_rate", **on_joint).set_to_velocity(kv=2 * DAMPING * inertia * frequency)
    spec.body("bus").add_site(name="gyro")
    site = mujoco.mjtObj.mjOBJ_SITE
    spec.add_sensor(name="gyro", type=mujoco.mjtSensor.mjSENS_GYRO, objtype=site, objname="gyro")
    return spec


def control(case: dict[str, Any], record: dict[str, Any], model: mujoco.MjModel) -> sysid.TimeSeries:
    """Return the servos' set points on the model's steps: held through a step, so taken in its middle."""
    spline = CubicSpline(record["angle_time_s"], record["gimbal_angle_rad"])
    times = np.arange(round(record["angle_time_s"][-1] / case["step_s"]) + 1) * case["step_s"]
    middle, values = times + case["step_s"] / 2, np.zeros((len(times), model.nu))
    for number in range(1, 7):
        values[:, model.actuator(f"cmg{number}_angle").id] = spline(middle)[:, number - 1]
        values[:, model.actuator(f"cmg{number}_rate").id] = spline(middle, 1)[:, number - 1]
        values[:, model.actuator(f"cmg{number}_rotor_motor").id] = 1.0
    return sysid.TimeSeries(times, values)


def start(record: dict[str, Any], model: mujoco.MjModel) -> np.ndarray:
    """Return the state at the start of the record: at rest, gimbals and rotors as measured."""
    data = mujoco.MjData(model)
    for number in range(1, 7):
        data.qpos[model.joint(f"cmg{number}_gimbal").qposadr[0]] = record["gimbal_angle_rad"][0][number - 1]
        data.qvel[model.joint(f"cmg{number}_rotor").dofadr[0]] = record["rotor_speed_rad_s"][0][number - 1]
    return sysid.create_initial_state(model, data.qpos, data.qvel, data.act)


def inertia_parameter(case: dict[str, Any]) -> sysid.Parameter:
    """Return the six entries J11, J22, J33, J23, J13, J12 of the whole platform as one parameter, in units of SCALE."""
    units = np.array(case["units_inertia_kg_m2"])

    def write(spec: mujoco.MjSpec, parameter: sysid.Parameter) -> None:
        j11, j22, j33, j23, j13, j12 = SCALE * parameter.value
        bus = np.array([[j11, j12, j13], [j12, j22, j23], [j13, j23, j33]]) - units
        body = spec.body("bus")
        body.inertia, body.iquat = [0.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]
        body.fullinertia = [*np.diag(bus), bus[0, 1], bus[0, 2], bus[1, 2]]

    guess = np.array(case["first_theta_kg_m2"]) / SCALE
    return sysid.Parameter("inertia", guess, guess - 0.5, guess + 0.5, modifier=write)


def weighted_residual(_: Any, predicted: Any, measured: Any, *_rest: Any, **_more: Any) -> Any:
    """Return measured minus predicted rate at the gyro's samples: white and of one size, as the likelihood has it."""
    at_samples = predicted.resample(measured.times)
    # sysid compares the two mappings by ==, which holds for the same object only.
    prediction = sysid.TimeSeries(measured.times, at_samples.data, measured.signal_mapping)
    return measured.data - prediction.data, prediction, measured


def fit(case: dict[str, Any], record: dict[str, Any]) -> dict[str, Any]:
    """Fit one record; everything that sysid itself does is timed."""
    spec = prepared(case)
    model = spec.compile()
    times, rate = np.array(record["gyro_time_s"]), np.array(record["body_rate_rad_s"])
    measured = sysid.TimeSeries.from_names(times[1:], rate[1:], model)
    begin, drive = start(record, model), control(case, record, model)
    began = time.perf_counter()
    parameters = sysid.ParameterDict()
    parameters.add(inertia_parameter(case))
    sequence = sysid.ModelSequences("platform", spec, "flight", begin, drive, measured)
    extra = {"modify_residual": weighted_residual} if case["weighted"] else {}
    residual = sysid.build_residual_fn(models_sequences=[sequence], **extra)
    quiet = {"verbose": False}
    found, _ = sysid.optimize(parameters, residual, optimizer=case["optimizer"], **quiet)
    return {
        "seconds": time.perf_counter() - began,
        "theta_kg_m2": (SCALE * found["inertia"].value).tolist(),
    }


if __name__ == "__main__":
    content = json.loads(Path(sys.argv[1]).read_text(encoding="utf-8"))
    print("\n" + json.dumps([fit(content, record) for record in content["records"]]))
