"""What is uncertain of actuators and gyro while the inertia is estimated."""

from __future__ import annotations

from testbed.quantities import AngleNoise, RateSpread, ScaleSpread
from testbed.scenario.section import Section


class Uncertainty(Section):
    """Standard deviations of what the estimators take for exact; they widen the intervals of the inertia.

    A value that is omitted is the spread that [dispersion] states for it, or else what data sheets of small hardware
    allow; it is zero only where a zero is written.
    """

    rotor_momentum_relative: ScaleSpread | None = None
    """Of each rotor's momentum as the telemetry gives it, as a share: of the rotor's inertia and the tachometer's scale
    where rotor speeds are recorded, of the total angular momentum where they are not; omitted: 0.002."""
    applied_torque_relative: ScaleSpread | None = None
    """Of each thruster's torque, or of that about each body axis where the records do not tell thrusters apart, as a
    share of it; omitted: 0.02. A common error of torque and inertia shows nowhere in the motion."""
    gimbal_zero_rad: AngleNoise | None = None
    """Of each gimbal encoder's zero; omitted: 0.001."""
    gimbal_axis_misalignment_rad: AngleNoise | None = None
    """Of each gimbal axis about the unit's spin axis and about its transverse axis, and of each wheel's axis about two
    axes across it; omitted: 0.001."""
    gyro_bias_rad_s: RateSpread | None = None
    """Of each gyro axis's constant bias; omitted: as in [dispersion], or else 0.002."""
    gyro_scale_factor: ScaleSpread | None = None
    """Of each gyro axis's relative scale factor error; omitted: as in [dispersion], or else 0.002."""
    gyro_misalignment_rad: AngleNoise | None = None
    """Of each gyro axis towards each of the two others; omitted: 0.001."""
