"""A blind case: everything that decides one data set, as plain data."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from concealing.effect import HiddenEffect

Vector = tuple[float, float, float]


@dataclass(frozen=True, kw_only=True)
class Run:
    """One run.

    Attributes:
        duration: s.
        maneuver: index in the pool.
        planned_spin: body rate at release that the maneuver is planned for, rad/s.
        release_error: what the body rate at release is beside it, rad/s.
    """

    duration: float
    maneuver: int
    planned_spin: Vector = (0.0, 0.0, 0.0)
    release_error: Vector = (0.0, 0.0, 0.0)


@dataclass(frozen=True, kw_only=True)
class Telemetry:
    """What of the flight is written down, and how well.

    Attributes:
        gyro_rate: Hz; 16, 50 or 100.
        momentum: gimbal angles, or the cluster's momentum in their place.
        tachometers, gimbal_torque, rate_command: whether these channels are recorded.
        encoder_noise: rad; None for the scenario's.
        encoder_step: rad; None for the scenario's.
        actuator_every: rows from one sample of the actuators to the next; the rows between have the gyro's alone.
        dropouts: share of rows that are lost, in short bursts.
        outliers: share of gyro samples that are spikes.
        stated_noise: stated over actual nominal gyro noise; None where nothing is stated.
    """

    gyro_rate: float = 16.0
    momentum: Literal["gimbal_angle", "cluster_momentum"] = "gimbal_angle"
    tachometers: bool = True
    gimbal_torque: bool = True
    rate_command: bool = True
    encoder_noise: float | None = None
    encoder_step: float | None = None
    actuator_every: int = 1
    dropouts: float = 0.0
    outliers: float = 0.0
    stated_noise: float | None = 1.0

    @property
    def control_rate(self) -> float:
        """Hz; a multiple of the gyro's rate."""
        return 80.0 if self.gyro_rate == 16.0 else 100.0


@dataclass(frozen=True, kw_only=True)
class Instruments:
    """What the instruments do that no model of them says: nothing, by default.

    Attributes:
        noise_correlation: of neighbouring samples of the gyro's noise, a first-order autoregression.
        noise_white: share of its variance that is white beside that.
        tail_freedom: degrees of freedom of Student's t distribution that the gyro's noise has; None for a normal one.
        noise_by_run: largest share by which the gyro's noise differs from the stated one, in every run by its own.
        jitter: standard deviation of the instant of a gyro sample, s.
        averaging: whether a gyro sample is the mean over the period that ends with it.
        anti_alias: -3 dB of the gyro's second-order (Butterworth) filter in shares of its rate; None for none.
        eccentricity: amplitude of the encoders' error once a turn, rad.
        encoder_delay: by which the encoders' samples are later than the other channels', in periods of the gyro.
        telemetry_delay: by which all samples of the actuators are late, s; negative where they are early.
        clock_skew: by which the gyro's clock is behind at the end of a run, s; it is right at release.
    """

    noise_correlation: float = 0.0
    noise_white: float = 0.0
    tail_freedom: float | None = None
    noise_by_run: float = 0.0
    jitter: float = 0.0
    averaging: bool = False
    anti_alias: float | None = None
    eccentricity: float = 0.0
    encoder_delay: float = 0.0
    telemetry_delay: float = 0.0
    clock_skew: float = 0.0


@dataclass(frozen=True, kw_only=True)
class Case:
    """One data set.

    Attributes:
        scenario: the nominal one.
        seed: of noise, dropouts and outliers.
        runs: in the order of their files.
        effects: hidden in it.
        theta_error: true minus nominal J11, J22, J33, J23, J13, J12 without any effect, kg·m².
        telemetry: what is written down.
        instruments: what they do that no model of them says; for flights by this package's own equations only, but for
            the gyro's noise and late telemetry.
        actuation: CMGs, or a torque that is applied and known.
        feedback: whether the gyro closes the loop; without, only the encoders do.
        simulator: what flies it: this package's equations of motion, or MuJoCo.
        stratum: which part of the score card the case belongs to.
        notes: what the stratum's generator knows of it, such as its size in detectable sizes.
    """

    scenario: Path
    seed: int
    runs: tuple[Run, ...]
    effects: tuple[HiddenEffect, ...] = ()
    theta_error: tuple[float, ...] = (0.0,) * 6
    telemetry: Telemetry = field(default_factory=Telemetry)
    instruments: Instruments = field(default_factory=Instruments)
    actuation: Literal["cmg", "applied_torque"] = "cmg"
    feedback: bool = True
    simulator: Literal["equations", "mujoco"] = "equations"
    stratum: str = "null"
    notes: dict[str, float | str] = field(default_factory=dict)
