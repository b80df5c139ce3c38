"""The estimators' prior knowledge from a scenario: nominal inertia, gyro noise, assumptions."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Literal

from testbed.assembly.platform import Body
from testbed.dynamics.inertia import theta_of
from testbed.estimation.estimate import EstimationSettings
from testbed.estimation.uncertainty import USUAL, Uncertainty
from testbed.maneuver.maneuver import Maneuver
from testbed.scenario.body import BodyScenario
from testbed.scenario.scenario import Scenario

UNCERTAINTY_KEYS: Mapping[str, str] = {
    "rotor_momentum": "rotor_momentum_relative",
    "applied_torque": "applied_torque_relative",
    "gimbal_zero": "gimbal_zero_rad",
    "gimbal_misalignment": "gimbal_axis_misalignment_rad",
    "gyro_bias": "gyro_bias_rad_s",
    "gyro_scale": "gyro_scale_factor",
    "gyro_misalignment": "gyro_misalignment_rad",
}
"""Key in [estimation.uncertainty] of each field of `Uncertainty`."""


def estimation_settings(scenario: BodyScenario, nominal: Body, maneuver: Maneuver | None) -> EstimationSettings:
    """Return the estimators' settings: nominal inertia, gyro noise, assumptions.

    Args:
        scenario: prefilter and instrument.
        nominal: the model that simulates the instrument.
        maneuver: the reference, on the record's clock; None for records measured elsewhere, whose instrument is then
            simulated from the estimate so far instead of taken from a reference.
    """
    instrument: Literal["reference", "nominal", "iterated"] = scenario.estimation.instrument
    if maneuver is None and instrument == "reference":
        instrument = "iterated"
    return EstimationSettings(
        nominal_theta=theta_of(nominal.turned_inertia),
        prefilter_time=scenario.estimation.prefilter_time_constant_s,
        instrument=instrument,
        reference_rate=None if maneuver is None else lambda time: maneuver.reference(time).body_rate,
        uncertainty=uncertainty_of(scenario),
    )


def uncertainty_of(scenario: BodyScenario) -> Uncertainty:
    """Return what is uncertain of actuators and gyro: as stated, as in [dispersion], or else as is usual."""
    stated = scenario.estimation.uncertainty
    spread = scenario.dispersion if isinstance(scenario, Scenario) else None
    usual = (
        USUAL
        if spread is None
        else replace(
            USUAL,
            gyro_bias=max(spread.gyro_bias_rad_s),
            gyro_scale=max(spread.gyro_scale_factor),
        )
    )
    given = {name: getattr(stated, key) for name, key in UNCERTAINTY_KEYS.items()}
    return replace(usual, **{name: value for name, value in given.items() if value is not None})
