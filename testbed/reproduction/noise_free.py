"""A maneuver flown without gyro noise: the motion about which noise is linearised."""

from __future__ import annotations

import numpy as np

from testbed.arrays import Array, Regressor, Theta
from testbed.assembly.estimators import estimation_settings
from testbed.assembly.platform import nominal_platform, true_platform
from testbed.assembly.telemetry import telemetry_of
from testbed.campaign.flights import fly_seeds
from testbed.dynamics.inertia import theta_of
from testbed.estimation.noise_response import NoiseResponse, finite_sample_bias, noise_response
from testbed.estimation.prefilter import filtered_equation
from testbed.estimation.telemetry import Telemetry
from testbed.maneuver.maneuver import Maneuver
from testbed.scenario.scenario import Scenario


class NoiseFreeFlight:
    """What the closed loop flies where the gyro does not disturb it; it starts from rest, its momentum known."""

    def __init__(self, scenario: Scenario, maneuver: Maneuver) -> None:
        """Fly it.

        Args:
            scenario: with the noise that is left out.
            maneuver: its reference.
        """
        quiet = scenario.model_copy(update={"gyro": scenario.gyro.model_copy(update={"noise_rad_s": 0.0})})
        (flight,) = fly_seeds(quiet, maneuver, [scenario.seed])
        assert flight.flown is not None  # a shipped scenario without dispersions
        nominal = nominal_platform(scenario)
        self.telemetry: Telemetry = telemetry_of(flight.flown.record, quiet, nominal)
        self.true_theta: Theta = theta_of(true_platform(scenario).inertia)
        self._reference = estimation_settings(scenario, nominal, maneuver).reference_rate

    def response(self, prefilter_time: float) -> NoiseResponse:
        """Return what noise does to the equation behind a prefilter of time γ, s."""
        return noise_response(self.telemetry, self.telemetry.body_rate, self.true_theta, prefilter_time)

    def instrument(self, prefilter_time: float) -> Regressor:
        """Return Z of the reference, as the paper's estimator takes it, shape (3N, 6)."""
        assert self._reference is not None  # a maneuver has one
        rate = self._reference(self.telemetry.gyro_time)
        return filtered_equation(self.telemetry, rate, prefilter_time).regressor


def predicted_iv_bias(scenario: Scenario, maneuver: Maneuver) -> Array:
    """Return the bias that the paper's estimator has on a maneuver in theory, shape (6,), kg·m².

    Args:
        scenario: gyro noise and prefilter.
        maneuver: what is flown.
    """
    flight, prefilter = NoiseFreeFlight(scenario, maneuver), scenario.estimation.prefilter_time_constant_s
    return np.asarray(
        finite_sample_bias(flight.response(prefilter), flight.instrument(prefilter), scenario.gyro.noise_rad_s)
    )
