"""What a flown case leaves behind: its records, and its answer."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path

import numpy as np

from concealing.case import Case
from concealing.craft import Array, nominal_craft
from concealing.flown import Flown, FlownCase, applied_torque, fly_case, theta
from concealing.guidance import software_of
from concealing.instruments import encoder_error, gyro_error
from concealing.library import KINDS
from concealing.mujoco_flight import fly_in_mujoco
from concealing.sealing import kept_rows, sealed_text, spiked, write_sealed
from testbed.records.record import Record, RunDetails


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
    records = [record(flown, index) for index in range(len(case.runs))]
    write_sealed(answer_text(flown), records, data_folder, answer_folder)
    return flown


def record(flown: Flown, index: int) -> Record:
    """Return one run as its telemetry tells it, spikes and gaps included."""
    case, telemetry = flown.case, flown.case.telemetry
    ticks = np.arange(0, round(case.runs[index].duration / flown.clock.period) + 1, flown.clock.gyro_ticks)
    channels = {"body_rate": flown.log.gyro[ticks, index]}
    if isinstance(flown, FlownCase):
        channels["body_rate"] = channels["body_rate"] + gyro_error(case, flown.log, flown.mechanics, index, ticks)
    noise = flown.sensors.gyro_noise
    channels["body_rate"] = spiked(case.seed, index, telemetry.outliers, channels["body_rate"], noise)
    sent = np.arange(len(ticks)) % telemetry.actuator_every == 0
    channels |= {name: np.where(sent[:, None], each, np.nan) for name, each in _actuation(flown, index, ticks).items()}
    kept = kept_rows(case.seed, index, telemetry.dropouts, len(ticks))
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
    content = {
        "notes": case.notes,
        "true_theta_kg_m2": theta(flown.craft),
        "initial_rates_rad_s": flown.log.body_rate[0].tolist(),
        "gyro_noise_rad_s": np.hypot(flown.sensors.gyro_noise, flown.craft.gyro.extra_noise).tolist(),
        "stated_over_nominal_noise": case.telemetry.stated_noise,
        "case": asdict(case) | {"scenario": case.scenario.name},
    }
    return sealed_text(case.seed, case.stratum, case.effects, KINDS, content)


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
