"""What the platform measures, and how well. Names follow IEEE Std 952."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated

from pydantic import Field, model_validator

from testbed.quantities import (
    AngleNoise,
    BodyRate,
    Corner,
    CorrelationTime,
    Drift,
    Latency,
    RateLimit,
    RateNoise,
    ScaleError,
    SmallAngle,
    TorqueNoise,
)
from testbed.scenario.section import Conflict, Section, refuse
from testbed.scenario.values import BodyRates, PerUnit, Rate, Three


class Gyro(Section):
    """Three-axis rate gyro; all errors but the white noise are off unless given."""

    sample_rate_hz: Rate
    """Samples per second."""
    noise_rad_s: RateNoise
    """Standard deviation of the white noise of a sample, each axis."""
    noise_uncertainty: Annotated[float, Field(gt=0, le=1)] = 0.1
    """Share by which that may be wrong, one standard deviation: a diagnosis estimates the noise, what is stated is its
    prior."""
    noise_correlation: Annotated[float, Field(ge=-0.9, le=0.9)] = 0.0
    """Correlation of neighbouring samples of that noise, a first-order autoregression; the estimators do not know of
    it."""
    extra_noise_rad_s: Three[RateNoise] = (0.0, 0.0, 0.0)
    """White noise of each axis beyond noise_rad_s, independent of it; the estimators do not know of it."""
    bias_rad_s: BodyRates = (0.0, 0.0, 0.0)
    """Constant bias, gyro axes."""
    drift_rad_s2: Three[Drift] = (0.0, 0.0, 0.0)
    """Rate at which the bias grows from the start of the flight, gyro axes."""
    bias_instability_rad_s: RateNoise = 0.0
    """Standard deviation of the slowly varying bias, a first-order Gauss-Markov process, each axis."""
    bias_correlation_time_s: CorrelationTime | None = None
    """Correlation time of that process; omitted: infinite, a constant bias drawn once per flight."""
    rate_random_walk_rad_s_per_sqrt_s: RateNoise = 0.0
    """Rate random walk: the bias's standard deviation grows with this times the square root of time, each axis."""
    scale_factor_error: Three[ScaleError] = (0.0, 0.0, 0.0)
    """Relative scale factor error s of each axis: the gyro reads (1 + s) times the rate; a pure number."""
    misalignment_rad: Three[SmallAngle] = (0.0, 0.0, 0.0)
    """Rotation vector from body axes to gyro axes."""
    cross_axis_rad: Three[SmallAngle] = (0.0, 0.0, 0.0)
    """Share of the other axis that both y and z, both x and z, both x and y read: what makes the axes oblique."""
    bandwidth_hz: Corner | None = None
    """Corner frequency of the gyro's first-order low-pass; omitted: none."""
    latency_s: Latency = 0.0
    """Age of the rate that a sample shows."""
    quantization_rad_s: RateNoise = 0.0
    """Step of the output's quantisation; 0: none."""
    saturation_rad_s: RateLimit | None = None
    """Largest rate that the gyro can show; omitted: none."""

    @model_validator(mode="after")
    def _consistent(self) -> Gyro:
        refuse(self._conflicts())
        return self

    def _conflicts(self) -> Iterator[Conflict]:
        if self.bias_correlation_time_s is not None and self.bias_instability_rad_s == 0.0:
            text = "has no effect without a bias_instability_rad_s above 0; give both or neither"
            yield Conflict(key="bias_correlation_time_s", text=text)
        saturation = self.saturation_rad_s
        floor = max(self.noise_rad_s, self.quantization_rad_s)
        if saturation is not None and saturation <= floor:
            text = f"{saturation} leaves no signal above noise and quantisation ({floor}); raise it"
            yield Conflict(key="saturation_rad_s", text=text)


class Encoder(Section):
    """Gimbal encoders, one on each unit; perfect unless given."""

    noise_rad: AngleNoise = 0.0
    """Standard deviation of the white noise of a sample."""
    quantization_rad: AngleNoise = 0.0
    """Step of the output's quantisation; 0: none."""
    zero_rad: PerUnit[SmallAngle] = ()
    """Error of each encoder's zero, added to what it reads; an empty list: none."""
    dead_zone_rad: PerUnit[AngleNoise] = ()
    """Play between each encoder and its axis: the encoder is half of it ahead, the way the axis turns; an empty list:
    none."""


class Tachometer(Section):
    """Rotor tachometers, one on each unit; perfect unless given."""

    noise_rad_s: RateNoise = 0.0
    """Standard deviation of the white noise of a sample."""
    scale_factor_error: PerUnit[ScaleError] = ()
    """Relative scale factor error s of each tachometer: it reads (1 + s) times the speed; a pure number; an empty list:
    none."""


class WheelTachometer(Section):
    """Tachometers of the reaction wheels, one on each; perfect unless given."""

    noise_rad_s: RateNoise = 0.0
    """Standard deviation of the white noise of a sample."""
    bias_rad_s: PerUnit[BodyRate] = ()
    """Reading of each tachometer where its wheel stands still; an empty list: none."""
    scale_factor_error: PerUnit[ScaleError] = ()
    """Relative scale factor error s of each tachometer, as of the rotors'; a pure number; an empty list: none."""


class WheelTorqueSensor(Section):
    """Measurement of each wheel motor's torque, from its current; perfect unless given."""

    noise_N_m: TorqueNoise = 0.0
    """Standard deviation of the white noise of a sample."""


class TorqueSensor(Section):
    """Measurement of each gimbal motor's torque, from its current; perfect unless given."""

    noise_N_m: TorqueNoise = 0.0
    """Standard deviation of the white noise of a sample."""
