"""A data set as a folder of records, and its answer sealed in another."""

from __future__ import annotations

import hashlib
import json
from dataclasses import asdict
from pathlib import Path

import numpy as np

from concealing.case import Case
from concealing.craft import Array, nominal_craft
from concealing.flown import Flown, FlownCase, applied_torque, fly_case, generator, theta
from concealing.guidance import software_of
from concealing.instruments import encoder_error, gyro_error
from concealing.library import KINDS
from concealing.mujoco_flight import fly_in_mujoco
from testbed.records.record import Record, RunDetails
from testbed.records.writing import write_record

_DROPOUTS, _OUTLIERS, _SALT = range(3, 6)
_BURST = 3
_SPIKE = (8.0, 30.0)
_OTHER_NAMES = {("contact", "time"): "time_since_release", ("slosh", "mass"): "loose_mass"}
"""Of parameters whose plain name would mean something else to a diagnosis: an instant in all runs laid end to end, and
the mass that would swing as this one does at an arm that is agreed on."""
SEAL = "sealed.sha256"


def conceal(case: Case, data_folder: Path, answer_folder: Path) -> Flown:
    """Fly a case, write its records, seal its answer.

    The data folder holds what a measured data set would, and the hash of the answer; the answer folder holds
    answer.json. Nothing but the measurements themselves depends on the hidden effects.

    Args:
        case: what to fly.
        data_folder: new or empty.
        answer_folder: new or empty; another one.
    """
    flown = fly_in_mujoco(case) if case.simulator == "mujoco" else fly_case(case)
    answer = answer_text(flown)
    _write(answer_folder / "answer.json", answer)
    for index in range(len(case.runs)):
        write_record(record(flown, index), data_folder / f"run_{index + 1}.csv")
    _write(data_folder / SEAL, hashlib.sha256(answer.encode()).hexdigest() + "\n")  # last: the set is whole
    return flown


def is_sealed(data_folder: Path, answer_folder: Path) -> bool:
    """Return whether an answer is the one that was sealed when the data were made."""
    answer = (answer_folder / "answer.json").read_bytes()
    return hashlib.sha256(answer).hexdigest() == (data_folder / SEAL).read_text(encoding="utf-8").strip()


def _write(path: Path, text: str) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")


def record(flown: Flown, index: int) -> Record:
    """Return one run as its telemetry tells it, spikes and gaps included."""
    case, telemetry = flown.case, flown.case.telemetry
    ticks = np.arange(0, round(case.runs[index].duration / flown.clock.period) + 1, flown.clock.gyro_ticks)
    channels = {"body_rate": flown.log.gyro[ticks, index]}
    if isinstance(flown, FlownCase):
        channels["body_rate"] = channels["body_rate"] + gyro_error(case, flown.log, flown.mechanics, index, ticks)
    channels["body_rate"] = _spiked(case, index, channels["body_rate"], flown.sensors.gyro_noise)
    channels |= _actuation(flown, index, ticks)
    kept = _kept(case, index, len(ticks))
    stated = telemetry.stated_noise
    return Record(
        time=flown.log.time[ticks][kept],
        channels={name: values[kept] for name, values in channels.items()},
        details=RunDetails(
            name=f"run_{index + 1}",
            gyro_noise=None if stated is None else stated * flown.sensors.gyro_noise,
        ),
    )


def answer_text(flown: Flown) -> str:
    """Return the answer: effects with parameters, true inertia, initial rates, noise; salted, so that no hash tells."""
    case = flown.case
    salt = np.random.default_rng([case.seed, _SALT]).bytes(32).hex()
    answer = {
        "schema": 1,
        "stratum": case.stratum,
        "effects": [
            {
                "effect": hidden.effect,
                "component": hidden.component,
                "parameters": {
                    parameter_key(hidden.effect, name): {"value": value, "unit": KINDS[hidden.effect].units[name]}
                    for name, value in hidden.parameters.items()
                },
            }
            for hidden in case.effects
        ],
        "notes": case.notes,
        "true_theta_kg_m2": theta(flown.craft),
        "initial_rates_rad_s": flown.log.body_rate[0].tolist(),
        "gyro_noise_rad_s": np.hypot(flown.sensors.gyro_noise, flown.craft.gyro.extra_noise).tolist(),
        "stated_over_nominal_noise": case.telemetry.stated_noise,
        "case": asdict(case) | {"scenario": case.scenario.name},
        "salt": salt,
    }
    return json.dumps(answer, indent=1) + "\n"


def parameter_key(effect: str, name: str) -> str:
    """Return a parameter's name as files spell it: delay_s, impulse_x_N_m_s, frequency_hz."""
    unit, name = KINDS[effect].units[name], _OTHER_NAMES.get((effect, name), name)
    suffix = {"1": "", "Hz": "hz"}.get(unit, unit.replace("/", "_").replace(" ", "_"))
    return f"{name}_{suffix}" if suffix else name


def _actuation(flown: Flown, index: int, ticks: Array) -> dict[str, Array]:
    case, log = flown.case, flown.log
    if case.actuation == "applied_torque":
        asked = applied_torque(case)
        return {"applied_torque": np.array([asked(time)[index] for time in log.time[ticks] - _late(flown)])}
    telemetry, angle = case.telemetry, log.encoder[:, index]
    if isinstance(flown, FlownCase):
        angle = angle + encoder_error(case, flown.log, flown.mechanics, index)
    if telemetry.momentum == "cluster_momentum":
        return {"cluster_momentum": _recorded(flown, _cluster_momentum(flown, angle, index), ticks)}
    channels = {"gimbal_angle": angle}
    if telemetry.rate_command:
        channels["gimbal_rate_command"] = log.rate_order[:, index]
    if telemetry.gimbal_torque:
        channels["gimbal_torque"] = log.motor_torque[:, index]
    if telemetry.tachometers:
        channels["rotor_speed"] = log.tachometer[:, index]
    return {name: _recorded(flown, values, ticks) for name, values in channels.items()}


def _late(flown: Flown) -> float:
    """Return by how much the actuators' channels are late, s: by a hidden effect, and by what no model says."""
    return flown.craft.telemetry_late + flown.case.instruments.telemetry_delay


def _recorded(flown: Flown, values: Array, ticks: Array) -> Array:
    """Return what is written down at ticks of a channel at all of them; late, between its samples.

    A straight line between two samples takes up to half of their noise's variance away.
    """
    late = _late(flown)
    if late == 0.0:
        return values[ticks]
    time, shown = flown.log.time, flown.log.time[ticks] - late
    return np.stack([np.interp(shown, time, column) for column in values.T], axis=1)


def _cluster_momentum(flown: Flown, angle: Array, index: int) -> Array:
    """h = Σ (Js Ω s + (Jg + Jt) ḋ g) as a flight computer sends it: from encoders, tachometers and nominal axes."""
    units = nominal_craft(software_of(flown.case.scenario).platform).units
    rate = np.gradient(angle, flown.clock.period, axis=0)
    cos, sin = np.cos(angle)[..., None], np.sin(angle)[..., None]
    spin = units.spin_axis * cos + units.transverse_axis * sin
    momentum = units.spin_inertia * flown.log.tachometer[:, index]
    return np.einsum("tm,tmi->ti", momentum, spin) + (units.turning_inertia * rate) @ units.gimbal_axis


def _spiked(case: Case, index: int, gyro: Array, noise: float) -> Array:
    """Replace a share of the gyro's samples by spikes on one axis."""
    rng = np.random.default_rng(generator(case, _OUTLIERS).spawn(index + 1)[index])
    hit = rng.random(len(gyro)) < case.telemetry.outliers
    size = rng.choice((-1.0, 1.0), len(gyro)) * rng.uniform(*_SPIKE, len(gyro)) * noise
    spikes = np.zeros_like(gyro)
    spikes[np.arange(len(gyro)), rng.integers(0, 3, len(gyro))] = hit * size
    return gyro + spikes


def _kept(case: Case, index: int, rows: int) -> Array:
    """Return which rows came through: bursts of them are lost, the first and the last never."""
    rng = np.random.default_rng(generator(case, _DROPOUTS).spawn(index + 1)[index])
    begins = rng.random(rows) < case.telemetry.dropouts / _BURST
    lost = np.convolve(begins, np.ones(_BURST), mode="full")[:rows] > 0
    lost[[0, -1]] = False
    return ~lost
