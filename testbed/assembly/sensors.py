"""The sensors of a flight, with errors drawn from the scenario's seed."""

from __future__ import annotations

from math import inf

import numpy as np

from testbed.dynamics.inertia import cross_matrix, inertia_of
from testbed.scenario.scenario import Scenario
from testbed.scenario.values import per_unit
from testbed.sensors.gyro import GyroParameters, gyro_errors
from testbed.sensors.gyro_response import gyro_on_clock
from testbed.sensors.units import UnitSensor, unit_errors
from testbed.simulation.flight import Clock, Sensors


def gyro_parameters(scenario: Scenario) -> GyroParameters:
    """Return the gyro under its IEEE 952 names."""
    gyro = scenario.gyro
    return GyroParameters(
        sample_rate=gyro.sample_rate_hz,
        white_noise=np.hypot(gyro.noise_rad_s, gyro.extra_noise_rad_s),
        noise_correlation=gyro.noise_correlation,
        bias=np.array(gyro.bias_rad_s),
        drift=np.array(gyro.drift_rad_s2),
        bias_instability=gyro.bias_instability_rad_s,
        bias_correlation_time=inf if gyro.bias_correlation_time_s is None else gyro.bias_correlation_time_s,
        rate_random_walk=gyro.rate_random_walk_rad_s_per_sqrt_s,
        scale_factor_error=np.array(gyro.scale_factor_error),
        # A gyro turned by the small vector v reads ω - v × ω of what the body feels; oblique axes add to it.
        misalignment=inertia_of(np.array([0.0, 0.0, 0.0, *gyro.cross_axis_rad]))
        - cross_matrix(np.array(gyro.misalignment_rad)),
        bandwidth=inf if gyro.bandwidth_hz is None else gyro.bandwidth_hz,
        latency=gyro.latency_s,
        saturation=inf if gyro.saturation_rad_s is None else gyro.saturation_rad_s,
        quantization=gyro.quantization_rad_s,
    )


def flight_sensors(scenario: Scenario, clock: Clock, seed: int) -> Sensors:
    """Draw the sensors of one flight; each noise source has its own generator.

    Args:
        scenario: the sensors' parameters.
        clock: of the flight.
        seed: of this flight.

    Raises:
        InputError: the gyro's rate does not divide the control rate.
    """
    gyro_seed, *unit_seeds = np.random.SeedSequence(seed).spawn(4)
    parameters = gyro_parameters(scenario)
    gyro = gyro_on_clock(parameters, scenario.simulation.control_rate_hz)
    sensors = _unit_sensors(scenario)
    units = scenario.cluster.units
    errors = [
        unit_errors(sensor, clock.ticks + 1, units, child) for sensor, child in zip(sensors, unit_seeds, strict=True)
    ]
    encoder, tachometer, torque_sensor = sensors
    return Sensors(
        gyro=gyro,
        gyro_errors=gyro_errors(parameters, clock.ticks // gyro.ticks_per_sample + 1, gyro_seed),
        encoder=encoder,
        encoder_errors=errors[0],
        encoder_dead_zone=np.array(per_unit(scenario.encoder.dead_zone_rad, units, 0.0)),
        tachometer=tachometer,
        tachometer_errors=errors[1],
        torque_sensor=torque_sensor,
        torque_errors=errors[2],
    )


def _unit_sensors(scenario: Scenario) -> tuple[UnitSensor, UnitSensor, UnitSensor]:
    encoder, tachometer, units = scenario.encoder, scenario.tachometer, scenario.cluster.units
    return (
        UnitSensor(
            white_noise=encoder.noise_rad,
            zero_offset=np.array(per_unit(encoder.zero_rad, units, 0.0)),
            quantization=encoder.quantization_rad,
        ),
        UnitSensor(
            white_noise=tachometer.noise_rad_s,
            scale_factor_error=np.array(per_unit(tachometer.scale_factor_error, units, 0.0)),
        ),
        UnitSensor(white_noise=scenario.torque_sensor.noise_N_m),
    )
