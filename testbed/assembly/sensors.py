"""The sensors of a flight, with errors drawn from the scenario's seed."""

from __future__ import annotations

from math import inf

import numpy as np
import scipy

from testbed.dynamics.inertia import cross_matrix, inertia_of
from testbed.scenario.actuators import wheel_count
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
        # A gyro turned by the vector v reads exp(-v×) ω of what the body feels; oblique axes add to it.
        misalignment=inertia_of(np.array([0.0, 0.0, 0.0, *gyro.cross_axis_rad]))
        + scipy.linalg.expm(-cross_matrix(np.array(gyro.misalignment_rad)))
        - np.eye(3),
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
    children = np.random.SeedSequence(seed).spawn(7)
    gyro_seed, unit_seeds = children[0], [*children[1:4], *children[5:]]  # the fifth draws the dispersions
    parameters = gyro_parameters(scenario)
    gyro = gyro_on_clock(parameters, scenario.simulation.control_rate_hz)
    sensors = _unit_sensors(scenario)
    counts = [scenario.gyros.units] * 3 + [wheel_count(scenario.actuators)] * 2
    errors = [
        unit_errors(sensor, clock.ticks + 1, count, child)
        for sensor, count, child in zip(sensors, counts, unit_seeds, strict=True)
    ]
    encoder, tachometer, torque_sensor, wheel_tachometer, wheel_torque_sensor = sensors
    return Sensors(
        gyro=gyro,
        gyro_errors=gyro_errors(parameters, clock.ticks // gyro.ticks_per_sample + 1, gyro_seed),
        encoder=encoder,
        encoder_errors=errors[0],
        encoder_dead_zone=np.array(per_unit(scenario.encoder.dead_zone_rad, scenario.gyros.units, 0.0)),
        tachometer=tachometer,
        tachometer_errors=errors[1],
        torque_sensor=torque_sensor,
        torque_errors=errors[2],
        wheel_tachometer=wheel_tachometer,
        wheel_speed_errors=errors[3],
        wheel_torque_sensor=wheel_torque_sensor,
        wheel_torque_errors=errors[4],
    )


def _unit_sensors(scenario: Scenario) -> tuple[UnitSensor, ...]:
    encoder, tachometer, units = scenario.encoder, scenario.tachometer, scenario.gyros.units
    wheels, wheel_units = scenario.wheel_tachometer, wheel_count(scenario.actuators)
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
        UnitSensor(
            white_noise=wheels.noise_rad_s,
            zero_offset=np.array(per_unit(wheels.bias_rad_s, wheel_units, 0.0)),
            scale_factor_error=np.array(per_unit(wheels.scale_factor_error, wheel_units, 0.0)),
        ),
        UnitSensor(
            white_noise=scenario.wheel_torque_sensor.noise_N_m,
            # A current: of a motor that gives another torque for it, it shows what was to be given.
            scale_factor_error=1.0 / np.array(per_unit(scenario.truth.wheel_torque_factor, wheel_units, 1.0)) - 1.0,
        ),
    )
