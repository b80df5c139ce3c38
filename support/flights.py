"""A short flight of the shipped platform as a recording's plain inputs."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np

from support.platforms import plant, restless_torque, shipped
from testbed.arrays import Array, Series
from testbed.plant.layout import layout_of
from testbed.recording.content import RecordingContent, ShownEstimate, ShownEvent, ShownResidual

THETA = np.array([0.022, 0.022, 0.027, 0.0, 0.0, 0.0])
STEPS_PER_SAMPLE = 10
STEP_NS = 1_250_000


@dataclass(frozen=True, kw_only=True)
class FlownSamples:
    """Samples of a flight at 80 Hz, beside MuJoCo's own state at each."""

    model: mujoco.MjModel
    time: Series
    channels: dict[str, Array]
    qpos: Array


def flown(samples: int, seed: int = 1) -> FlownSamples:
    """Fly with restless gimbals and note every channel that a recording shows."""
    model = shipped()
    layout, craft, rng = layout_of(model), plant(model), np.random.default_rng(seed)
    qpos, qvel, torque = [], [], []
    for sample in range(samples):
        qpos.append(craft.qpos.copy())
        qvel.append(craft.qvel.copy())
        torque.append(craft.joint_torque[layout.gimbal_rate].copy())
        craft.advance(restless_torque(sample * STEPS_PER_SAMPLE * STEP_NS * 1e-9), STEPS_PER_SAMPLE)
    position, velocity = np.array(qpos), np.array(qvel)
    body_rate = velocity[:, layout.body_rate]
    gyro = body_rate + rng.normal(0.0, 0.025, body_rate.shape)
    gyro[np.arange(samples) % 5 != 0] = np.nan
    saturated = np.zeros((samples, 6))
    saturated[2:5, 2] = 1.0
    channels = {
        "body_rate": gyro,
        "true_body_rate": body_rate,
        "reference_body_rate": body_rate + 1e-3,
        "true_gimbal_angle": position[:, layout.gimbal_angle],
        "true_gimbal_rate": velocity[:, layout.gimbal_rate],
        "true_rotor_angle": position[:, layout.rotor_angle],
        "true_rotor_speed": velocity[:, layout.rotor_speed],
        "true_attitude": position[:, layout.attitude],
        "true_position": position[:, layout.position],
        "true_cluster_momentum": -body_rate @ np.diag(THETA[:3]),
        "true_total_momentum": np.zeros_like(body_rate),
        "true_cluster_torque": np.zeros_like(body_rate),
        "gimbal_torque": np.array(torque),
        "singularity_measure": np.linspace(0.2, 0.9, samples)[:, None],
        "gimbal_rate_saturated": saturated,
        "gimbal_torque_saturated": np.zeros((samples, 6)),
        "rotor_momentum_clamped": np.zeros((samples, 6)),
    }
    time = np.arange(samples) * STEPS_PER_SAMPLE * (STEP_NS * 1e-9)
    return FlownSamples(model=model, time=time, channels=channels, qpos=position)


def content(samples: int) -> RecordingContent:
    """Limits, two estimates, residuals, events and text for a flight of so many samples."""
    rng = np.random.default_rng(2)
    std = 1e-4 * np.array([1.3, 1.2, 1.6, 1.0, 1.0, 0.9])
    return RecordingContent(
        limits={
            "gimbal_rate": np.array([2.0, -2.0]),
            "gimbal_torque": np.array([0.015, -0.015]),
            "rotor_speed": np.array([520.0]),
            "cluster_momentum": np.kron([1.0, -1.0], [0.021, 0.021, 0.0254]),
            "cluster_torque": np.kron([1.0, -1.0], [0.040, 0.040, 0.047]),
        },
        nominal_theta=THETA + 1e-4,
        true_theta=THETA,
        estimates=(
            ShownEstimate(name="ls", theta=THETA - 6e-4, std=std),
            ShownEstimate(name="output_error", theta=THETA + 2e-5, std=1.1 * std),
        ),
        bound_std=std,
        residuals=(
            ShownResidual(
                name="output_error", unit="rad/s", time=np.arange(4) * 0.0625, values=rng.normal(size=(4, 3))
            ),
        ),
        envelope_fraction=np.linspace(0.0, 0.8, samples),
        events=(ShownEvent(time=0.0, text="start"), ShownEvent(time=0.025, text="cmg3 at its rate limit")),
        result="| parameter | truth |\n|---|---|\n| J11 | 0.022 |",
        provenance="seed 7",
        properties={"seed": 7, "scenario": "zero_g"},
    )
